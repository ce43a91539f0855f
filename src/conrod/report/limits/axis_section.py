"""The part of a page about one axis: its charts, its boundaries, and what was refused."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from matplotlib.figure import Figure

from conrod.report import numbers
from conrod.report.charts.styles import engine_title
from conrod.report.limits import prose
from conrod.report.limits.boundaries_table import boundaries_table, refusals
from conrod.report.limits.boundary_chart import boundary_chart, preset_lanes
from conrod.report.limits.error_chart import POSITION, TORQUE, error_chart
from conrod.report.tables import paragraphs
from conrod.studies.limits.axes import AXES
from conrod.studies.limits.axis import Scale
from conrod.studies.limits.results import Walk

NEARNESS, REGULARISATION = "nearness", "regularisation"
Walks = Sequence[Walk]
# Figures of an axis that has another one than its boundaries, and what is said of it.
SPECIAL: Mapping[str, tuple[Callable[[Walks], Figure | None], str]] = {
    NEARNESS: (lambda walks: error_chart(walks, ruler=True), prose.NEARNESS),
    REGULARISATION: (lambda walks: error_chart(walks, (TORQUE, POSITION)), prose.REGULARISATION),
}


def by_axis(walks: Sequence[Walk]) -> dict[str, list[Walk]]:
    """Walks by the names of their axes, in their order."""
    found: dict[str, list[Walk]] = {}
    for walk in walks:
        found.setdefault(walk.axis, []).append(walk)
    return found


def axis_figures(axis: str, walks: Walks) -> dict[str, Figure]:
    """The figures of an axis, by what they are called beside the scene's name."""
    made = {axis: boundary_chart(preset_lanes(walks))}
    if AXES[axis].scale is Scale.LISTED:
        made = {axis: error_chart(walks)}
    if axis in SPECIAL:
        made[f"{axis}-errors"] = SPECIAL[axis][0](walks)
    return {name: figure for name, figure in made.items() if figure is not None}


def axis_section(axis: str, walks: Walks, figure: Callable[[str, str], str]) -> str:
    """The section of an axis that was walked; nothing where it was refused to all.

    Args:
        figure: the Markdown of a figure, from what it is called and what it shows; empty where there is none.
    """
    if not any(walk.probes for walk in walks):
        return ""
    title = AXES[axis].title
    special = figure(f"{axis}-errors", f"{title}: errors") if axis in SPECIAL else ""
    return paragraphs(
        f"### {title}",
        figure(axis, f"{title}: how far each engine and preset can be relied on"),
        prose.LISTED if AXES[axis].scale is Scale.LISTED else "",
        boundaries_table(walks),
        special,
        SPECIAL[axis][1] if special else "",
        _ruler(walks),
        "\n".join(f"- {text}" for text in _torques(walks)) if axis == REGULARISATION else "",
        *refusals(walks),
    )


def _ruler(walks: Walks) -> str:
    """How far the reference itself is off at worst."""
    doubted = [probe for walk in walks for probe in walk.probes if probe.reference_error is not None]
    if not doubted:
        return ""
    worst = max(doubted, key=lambda probe: probe.reference_error or 0.0)
    return f"The reference itself is off by at most {numbers.measured(worst.reference_error)} L, at {worst.text}."


def _torques(walks: Walks) -> list[str]:
    """Where the drive torque is best, and what it is at both ends."""
    said = []
    for walk in walks:
        known = [(probe.torque, probe.text) for probe in walk.probes if probe.torque is not None]
        if known:
            (first, begin), (least, where), (last, end) = (
                (numbers.measured(error), text) for error, text in (known[0], min(known), known[-1])
            )
            said.append(
                f"{engine_title(walk.engine)} `{walk.preset}`: the drive torque is off by {first} of its peak at "
                f"{begin}, by {last} at {end}, and least, by {least}, at {where}."
            )
    return said
