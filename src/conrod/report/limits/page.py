"""The page of one scene's limits, in Markdown."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from typing import Any

from conrod.report.charts.styles import engine_title
from conrod.report.limits import prose
from conrod.report.limits.axis_section import axis_section, by_axis
from conrod.report.limits.boundaries_table import refusals
from conrod.report.limits.figures import FLOAT, LONG_RUNS, NEEDS, map_name
from conrod.report.limits.findings import needs_table
from conrod.report.limits.float_table import float_table
from conrod.report.limits.other_tables import determinism_table, long_run_table, maps_table
from conrod.report.limits.plain_words import sentences
from conrod.report.limits.undetected_table import quiet_elsewhere, quiet_table
from conrod.report.names import FIGURES
from conrod.report.tables import paragraphs
from conrod.studies.limits.axes import AXES
from conrod.studies.limits.maps import LimitMap
from conrod.studies.limits.results import LimitStudy, Walk


def limits_page(study: LimitStudy, entry: Mapping[str, Any], drawn: Collection[str]) -> str:
    """The page.

    Args:
        entry: of the scene in the document.
        drawn: the figures that there are.
    """

    def figure(name: str, text: str) -> str:
        return f"![{text}, {study.name}]({FIGURES}/{study.name}-{name}.svg)" if name in drawn else ""

    axes = by_axis(study.walks)
    maps = (block for found in study.maps for block in (_map_title(found), figure(map_name(found), _shows(found))))
    blocks = [
        f"# {study.name}: limits",
        f"{study.title}, with {_versions(study)}. See the [index](README.md) for the other machines.",
        _commands(entry["commands"]),
        prose.WORDS,
        *_dangers(study),
        *_section("In plain words", "", *_plain_words(axes)),
        *_section(
            "Axis by axis",
            f"{prose.BOUNDARIES} {prose.CHART}",
            *(axis_section(axis, walks, figure) for axis, walks in axes.items()),
        ),
        *_section("Two axes at once", prose.MAPS, maps_table(study.maps), *maps),
        *_section(
            "The mass ratio against the iterations",
            prose.NEEDS,
            figure(NEEDS, "Mass ratio that holds with a fixed number of iterations"),
            needs_table(study.needs),
        ),
        *_section(
            "Follower float",
            prose.FLOAT,
            figure(FLOAT, "Flight of the follower, how deep it sinks, and from which speed it flies"),
            float_table(study.floats),
            *_not_flown(study),
        ),
        *_section("The same again?", prose.DETERMINISM, determinism_table(study.determinism)),
        *_section(
            "Long runs",
            prose.LONG_RUNS,
            figure(LONG_RUNS, "Loop error and phase against revolutions"),
            long_run_table(study.long_runs),
        ),
        *_section("What was not walked, and why", "", _not_walked(axes)),
    ]
    return paragraphs(*blocks) + "\n"


def _section(title: str, before: str, *blocks: str) -> list[str]:
    """A section that is there only with what it is about."""
    return [f"## {title}", before, *blocks] if any(blocks) else []


def _versions(study: LimitStudy) -> str:
    return ", ".join(f"{engine_title(name)} {version}" for name, version in study.engines.items())


def _commands(commands: Sequence[str]) -> str:
    return "Reproduced by " + ", then ".join(f"`{command}`" for command in commands) + "."


def _dangers(study: LimitStudy) -> list[str]:
    """The quiet runs; they come first."""
    if not (study.maps or any(walk.probes for walk in study.walks)):
        return []
    found, others = quiet_table(study.walks), quiet_elsewhere(study)
    return ["## Wrong, and nothing says so", prose.QUIET if found or others else prose.NO_QUIET, found, others]


def _plain_words(axes: Mapping[str, Sequence[Walk]]) -> list[str]:
    blocks = []
    for axis, walks in axes.items():
        told = sentences(walks)
        if told:
            blocks += [f"**{AXES[axis].title}**", "\n".join(f"- {text}" for text in told)]
    return blocks


def _not_walked(axes: Mapping[str, Sequence[Walk]]) -> str:
    """Axes that were refused to all; what was refused to some stands with the axis."""
    whole = {axis: walks for axis, walks in axes.items() if not any(walk.probes for walk in walks)}
    return "\n".join(f"- {AXES[axis].title}: {' '.join(refusals(walks))}" for axis, walks in whole.items())


def _not_flown(study: LimitStudy) -> list[str]:
    refused = [found for found in study.floats if found.refusal]
    return [f"Not looked at with {engine_title(f.engine)} `{f.preset}`: {f.refusal}." for f in refused]


def _map_title(found: LimitMap) -> str:
    return f"### {_shows(found)}"


def _shows(found: LimitMap) -> str:
    return f"{AXES[found.x_axis].title} x {AXES[found.y_axis].title}, {_of(found)}"


def _of(found: LimitMap) -> str:
    return f"{engine_title(found.engine)} {found.preset}"
