"""The first page of a sweep's report, made from the entries of all its scenes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from conrod.report.charts.styles import engine_title
from conrod.report.sweep import prose
from conrod.report.sweep.fronts import COST_HEAD
from conrod.report.sweep.setting_tables import transfers_sentence, transfers_table
from conrod.report.tables import paragraphs, table

if TYPE_CHECKING:
    from conrod.studies.recommend.transfer import Transfer

# A number that the file of a machine has whose input makes one pass.
PASS = "driver.from"


def sweep_index(scenes: Mapping[str, Any], transfers: Sequence[Transfer], command: str | None, explanation: str) -> str:
    """The index.

    Args:
        scenes: entries as `document.scene_entry` makes them, by name.
        command: what reproduces the report; None where no single command does.
        explanation: where a newcomer learns to read it, in Markdown.
    """
    rows = [[f"[{name}]({name}.md)", *row] for name, scene in scenes.items() for row in scene["cheapest"]]
    head = ["machine", "position within", "engine", "cheapest settings", "steps per revolution", "error", *COST_HEAD]
    carried = transfers_table(transfers)
    return (
        paragraphs(
            "# Speed against accuracy",
            prose.PURPOSE,
            explanation,
            "\n".join(f"- [{name}]({name}.md): {scene['title']}" for name, scene in scenes.items()),
            "## The cheapest settings",
            table(head, rows) or "No run was timed, so there is no cost to show.",
            prose.COST,
            prose.ERRORS,
            *([prose.ONE_PASS] if any(PASS in scene["study"]["parameters"] for scene in scenes.values()) else []),
            "## What was found",
            *(block for name, scene in scenes.items() for block in _findings(name, scene)),
            *(
                ["## How far a choice carries", prose.TRANSFERS, transfers_sentence(transfers), carried]
                if carried
                else []
            ),
            "## Made with",
            _versions(scenes),
            f"{_origin(command)} [results.json](results.json) holds every point.",
        )
        + "\n"
    )


def _findings(name: str, scene: Mapping[str, Any]) -> list[str]:
    if not scene["findings"]:
        return []
    return [f"### [{name}]({name}.md)", "\n".join(f"- {text}" for text in scene["findings"])]


def _versions(scenes: Mapping[str, Any]) -> str:
    """All versions and machines that occur: scenes that were swept earlier stay as they were."""
    found: dict[str, list[str]] = {"conrod": sorted({scene["conrod"] for scene in scenes.values()})}
    engines = {(name, version) for scene in scenes.values() for name, version in scene["study"]["engines"].items()}
    for engine, version in sorted(engines):
        found.setdefault(engine_title(engine), []).append(version)
    found["machine that was timed on"] = sorted({scene["study"]["machine"] for scene in scenes.values()})
    found["grid"] = sorted({scene["study"]["grid"] for scene in scenes.values()})
    return table(["what", "which"], [[name, "; ".join(versions)] for name, versions in found.items()])


def _origin(command: str | None) -> str:
    if command is None:
        return "The machines were not all swept by one command: each page names its own."
    return f"Reproduced by `{command}`, up to the timings; each page names the command that reproduces it alone."
