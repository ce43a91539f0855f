"""The report's first page, made from the summaries of all its scenes."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from conrod.report import numbers
from conrod.report.charts.styles import engine_title
from conrod.report.tables import paragraphs, table
from conrod.report.validation import prose
from conrod.runs.trajectory import Outcome

PURPOSE = (
    "conrod measures physics engines with mechanisms whose motion is known exactly. Each machine below is built once, "
    "as one description, translated for each engine, driven at constant crank speed, sampled, and compared with its "
    "exact kinematics. Each page holds the mechanism with its dimensions, the errors, the order in the step, the "
    "tolerances with their reasons, the settings, and what such a comparison cannot see."
)
KINEMATIC = (
    "*Kinematic mode* proves the model: the engine's own joints, solved at prescribed crank angles, against the exact "
    "poses. The presets measure the engine: real time stepping."
)


def index_page(scenes: Mapping[str, Any], command: str | None) -> str:
    """The index.

    Args:
        scenes: summaries as `summary.scene_summary` makes them, by name.
        command: what reproduces the report; None where no single command does.
    """
    # Where files are among the machines the verdicts' reasons are told here: there may be too many pages to look at.
    rows, head = _wide(scenes) if any("ruler" in scene for scene in scenes.values()) else _narrow(scenes)
    failed = [name for name, scene in scenes.items() if not scene["passed"]]
    verdict = f"**Not passed: {', '.join(failed)}.**" if failed else "**All judged results are within tolerance.**"
    return (
        paragraphs(
            "# Validation reports",
            PURPOSE,
            verdict,
            "\n".join(f"- [{name}]({name}.md): {scene['title']}" for name, scene in scenes.items()),
            table(head, rows),
            *_unsupported(scenes),
            KINEMATIC,
            prose.PRESETS,
            prose.ERRORS,
            "## Made with",
            _versions(scenes),
            f"{_origin(command)} [results.json](results.json) holds the numbers of all tables.",
        )
        + "\n"
    )


def _narrow(scenes: Mapping[str, Any]) -> tuple[list[list[str]], list[str]]:
    rows = [_row(name, entry) for name, scene in scenes.items() for entry in scene["results"]]
    return rows, ["machine", "engine", "preset", "steps per revolution", "largest position error / L", "verdict"]


def _wide(scenes: Mapping[str, Any]) -> tuple[list[list[str]], list[str]]:
    """The same with what is allowed; the verdict of a run that did not complete tells what ended it."""
    rows = []
    for name, scene in scenes.items():
        for entry in scene["results"]:
            *first, verdict = _row(name, entry)
            ended = entry["outcome"] not in (Outcome.COMPLETED.slug, Outcome.UNSUPPORTED.slug)
            rows.append([*first, _allowed(entry), f"{verdict}: {entry['reason']}" if ended else verdict])
    return rows, [
        *("machine", "engine", "preset", "steps per revolution", "largest position error / L"),
        *("position allowed / L", "verdict"),
    ]


def _allowed(entry: Mapping[str, Any]) -> str:
    allowed = (entry.get("tolerance") or {}).get("position")
    if allowed is None:
        return numbers.MISSING
    return allowed if isinstance(allowed, str) else numbers.measured(allowed)


def _unsupported(scenes: Mapping[str, Any]) -> list[str]:
    """What an engine cannot do, with the reason; nothing where both can do everything, or all is in closed form."""
    found = {
        (name, entry["engine"], entry["reason"]): None
        for name, scene in scenes.items()
        if "ruler" in scene
        for entry in scene["results"]
        if entry["outcome"] == Outcome.UNSUPPORTED.slug
    }
    rows = [[f"[{name}]({name}.md)", engine_title(engine), reason] for name, engine, reason in found]
    return ["## What an engine cannot do", table(["machine", "engine", "why"], rows)] if rows else []


def _row(name: str, entry: Mapping[str, Any]) -> list[str]:
    preset = entry["preset"] or "kinematic mode"
    steps = entry["steps_per_revolution"]
    return [
        f"[{name}]({name}.md)",
        engine_title(entry["engine"]),
        preset,
        numbers.MISSING if steps is None else str(steps),
        _error(entry),
        entry["verdict"],
    ]


def _error(entry: Mapping[str, Any]) -> str:
    found = entry["largest_position_error"]
    if entry["outcome"] != Outcome.COMPLETED.slug or found is None:
        return numbers.MISSING
    return found if isinstance(found, str) else numbers.measured(found)


def _origin(command: str | None) -> str:
    if command is None:
        return "The machines were not all measured by one command: each page names its own."
    return f"Reproduced by `{command}`; each page names the command that reproduces it alone."


def _versions(scenes: Mapping[str, Any]) -> str:
    """All versions that occur: scenes that were measured earlier stay as they were."""
    engines = sorted({(e["engine"], e["engine_version"]) for scene in scenes.values() for e in scene["results"]})
    found: dict[str, list[str]] = {"conrod": sorted({scene["conrod"] for scene in scenes.values()})}
    for engine, version in engines:
        found.setdefault(engine_title(engine), []).append(version)
    return table(["software", "version"], [[name, ", ".join(versions)] for name, versions in found.items()])
