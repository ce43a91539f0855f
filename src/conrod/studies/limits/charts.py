"""Figures of errors along an axis of limits; scales and marks, which maps use too."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, Literal

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import FuncFormatter, LogLocator, MultipleLocator, NullLocator

from conrod.comparison.trajectory import Outcome
from conrod.exact.motion import Array
from conrod.report import numbers
from conrod.report.charts import canvas, styles
from conrod.studies.limits.axes import AXES
from conrod.studies.limits.axis import Axis, Scale
from conrod.studies.limits.records import ROUGH_ERROR, SAFE_ERROR
from conrod.studies.limits.results import Probe, Walk

FINE_TICKS_DECADES = 4.5  # up to which one, two and five of each decade have a tick
MAX_TICKS = 13
UNDETECTED_COLOUR = "#d40000"  # of wrong and undetected runs


def axis_places(axis: Axis, values: Iterable[float]) -> Array:
    """Return places (N,) of values along an axis: value, or 1 - value on a nearness scale."""
    places = np.array(list(values), dtype=float)
    if axis.scale is Scale.LISTED:
        return canvas.round_to_grid(places, max(1.0, float(np.ptp(places))))
    logs = np.log10(1.0 - places if axis.scale is Scale.NEARNESS else places)
    return np.asarray(10.0 ** canvas.round_to_grid(logs, max(1.0, float(np.ptp(logs)))))


def axis_label(axis: Axis) -> str:
    """Return an axis's label for the places of `axis_places`."""
    return f"1 - {axis.label}" if axis.scale is Scale.NEARNESS else axis.label


def set_scale(axes: Axes, which: Literal["x", "y"], axis: Axis, begin: float, end: float, room: float = 0.0) -> None:
    """Give the x or y axis of a chart the scale of an axis of limits, with ticks.

    Args:
        axes: the chart's axes.
        which: `x` or `y`.
        axis: the axis of limits.
        begin, end: places of the first and last value.
        room: margin at both ends, as a share of the length.
    """
    if axis.listed:
        beside = room * (end - begin)
        axes.set(**{f"{which}lim": (begin - beside, end + beside)})
        if axis.label.endswith("[deg]") and end - begin >= 180.0:
            (axes.xaxis if which == "x" else axes.yaxis).set_major_locator(MultipleLocator(90.0))
    else:
        beside = (end / begin) ** room
        axes.set(**{f"{which}scale": "log", f"{which}lim": (begin / beside, end * beside)})
        drawn = axes.xaxis if which == "x" else axes.yaxis
        subs = (1.0, 2.0, 5.0) if abs(math.log10(end / begin)) < FINE_TICKS_DECADES else (1.0,)
        drawn.set_major_locator(LogLocator(subs=subs, numticks=MAX_TICKS))
        drawn.set_minor_locator(NullLocator())
        drawn.set_major_formatter(FuncFormatter(lambda value, _: numbers.quantity(value)))


def mark_style(outcome: str, undetected: bool, size: float = 4.4) -> dict[str, Any]:
    """Return arguments of `Axes.plot` for an outcome's mark; red if the run is undetected."""
    return {
        "linestyle": "none",
        "marker": styles.OUTCOME_MARKS.get(outcome, "."),
        "markersize": size,
        "markeredgewidth": 0.9,
        "color": UNDETECTED_COLOUR if undetected else "#222222",
    }


def outcome_handles(outcomes: set[str]) -> list[Line2D]:
    """Return legend entries of outcomes, in the order of `Outcome`."""
    known = [one.slug for one in Outcome if one.slug in outcomes and one.slug in styles.OUTCOME_MARKS]
    return [Line2D([], [], label=one, **mark_style(one, undetected=False, size=5.0)) for one in known]


WIDTH, PANEL, MARGINS = 9.5, 3.0, 1.0  # of a figure, of a panel, of legend and labels [inch]
LEGEND_COLUMNS = 5
SENSE_NOTE = ": safe at the left, failing at the right"
LEVEL_NOTE: dict[str, Any] = {  # beside the panel, where no curve runs
    "xycoords": ("axes fraction", "data"), "textcoords": "offset points", "xytext": (4, 0), "ha": "left",
    "va": "center", "fontsize": 7.5, "color": "#555555",
}  # fmt: skip
TITLE_HEIGHT = 0.25  # [inch]
LANE_HEIGHT = 0.17  # of failed runs of a preset [inch]
LANE_OFFSET = 0.06  # of the lowest lane above the panel [inch]
AXIS_MARGIN = 0.02  # at both ends, as a share of the length
UNDETECTED_RING: dict[str, Any] = {
    "linestyle": "none",
    "color": UNDETECTED_COLOUR,
    "zorder": 6,
    "marker": "o",
    "markersize": 11.0,
    "markerfacecolor": "none",
    "markeredgewidth": 1.3,
}


# Returns a quantity of a run, or None; and the label of its axis, with the divisor.
PanelQuantity = tuple[Callable[[Probe], float | None], str]
POSITION: PanelQuantity = (lambda probe: probe.position, "position error, max / L")
TORQUE: PanelQuantity = (lambda probe: probe.torque, "drive torque error, max / peak")


def error_chart(walks: Sequence[Walk]) -> Figure:
    """Draw torque and position errors of all runs on some walks along one axis.

    Args:
        walks: along the same axis; at least one run has errors."""
    walks = [walk for walk in walks if walk.probes]
    panels = [panel for panel in (TORQUE, POSITION) if _panel_values(walks, panel)]
    axis = AXES[walks[0].axis]
    lanes = list(dict.fromkeys((w.engine, w.preset) for w in walks if any(p.errors is None for p in w.probes)))
    handles = _legend(walks)
    figure = Figure(figsize=(WIDTH, PANEL * len(panels) + LANE_HEIGHT * len(lanes) + MARGINS + TITLE_HEIGHT))
    drawn = figure.subplots(len(panels), 1, sharex=True, squeeze=False)[:, 0]
    for axes, panel in zip(drawn, panels, strict=True):
        _draw_panel(axes, axis, walks, panel)
    _draw_failed(drawn[0], axis, walks, lanes)
    above_lanes = 72.0 * (2.0 * LANE_OFFSET + LANE_HEIGHT * len(lanes))  # [pt]
    drawn[0].set_title(f"{walks[0].scene}: {axis.title}", loc="left", pad=above_lanes, parse_math=False)
    drawn[-1].set_xlabel(f"{axis_label(axis)}{SENSE_NOTE if _have_one_sense(axis, walks) else ''}")
    canvas.add_legend_above(figure, handles, LEGEND_COLUMNS)
    return figure


def _have_one_sense(axis: Axis, walks: Sequence[Walk]) -> bool:
    """True if all walks lead the same way along an axis, from its safe end to its failing one."""
    return not axis.listed and len({walk.probes[0].value < walk.probes[-1].value for walk in walks}) == 1


def _panel_values(walks: Sequence[Walk], panel: PanelQuantity) -> list[float]:
    found = (panel[0](probe) for walk in walks for probe in walk.probes)
    return [value for value in found if value is not None]


def _draw_panel(axes: Axes, axis: Axis, walks: Sequence[Walk], panel: PanelQuantity) -> None:
    canvas.set_decades(axes, [canvas.round_to_log_grid(np.array(_panel_values(walks, panel)))])
    low, high = axes.get_ylim()
    for limit in (SAFE_ERROR, ROUGH_ERROR) if panel is POSITION else ():
        axes.axhline(limit, color="#888888", linewidth=0.8, linestyle=(0, (4, 3)), zorder=1)
        if low < limit < high:
            axes.annotate(f"{100 * limit:g} % of L", (1.0, limit), **LEVEL_NOTE)
    for walk in walks:
        # A curve is broken where a run has no value: nothing is known there.
        _plot_probes(axes, axis, walk.probes, panel, styles.preset_style(walk.engine, walk.preset) | _line_style(axis))
        _plot_probes(axes, axis, [probe for probe in walk.probes if probe.undetected], panel, UNDETECTED_RING)
    ends = [axis_places(axis, (walk.probes[0].value, walk.probes[-1].value)) for walk in walks]
    begin, end = float(np.min(ends)), float(np.max(ends))
    # From the safe end to the failing one; where walks lead both ways, as the numbers do.
    if all(last <= first for first, last in ends):
        begin, end = end, begin
    set_scale(axes, "x", axis, begin, end, AXIS_MARGIN)
    axes.set_ylabel(panel[1])


def _line_style(axis: Axis) -> dict[str, Any]:
    """Return arguments of `Axes.plot` that leave out lines between listed values."""
    return {"linestyle": "none"} if axis.listed else {}


def _plot_probes(
    axes: Axes, axis: Axis, probes: Sequence[Probe], panel: PanelQuantity, style: Mapping[str, Any]
) -> None:
    heights = np.array([panel[0](probe) for probe in probes], dtype=float)
    if not np.isnan(heights).all():
        axes.plot(axis_places(axis, (probe.value for probe in probes)), canvas.round_to_log_grid(heights), **style)


def _draw_failed(axes: Axes, axis: Axis, walks: Sequence[Walk], lanes: Sequence[tuple[str, str]]) -> None:
    """Draw marks of runs without errors above the panel, a lane for each engine and preset."""
    for lane, key in enumerate(lanes):
        up = 1.0 + (LANE_OFFSET + LANE_HEIGHT * (len(lanes) - lane - 0.5)) / PANEL
        failed = [p for w in walks if (w.engine, w.preset) == key for p in w.probes if p.errors is None]
        for end in dict.fromkeys((p.outcome, p.undetected) for p in failed):
            places = axis_places(axis, (p.value for p in failed if (p.outcome, p.undetected) == end))
            style = mark_style(*end) | {"transform": axes.get_xaxis_transform(), "clip_on": False}
            axes.plot(places, np.full(len(places), up), **style)
        where: dict[str, Any] = {"xycoords": "axes fraction", "ha": "right", "va": "center"}
        axes.annotate(styles.preset_title(*key), (-0.005, up), fontsize=7.5, **where)


def _legend(walks: Sequence[Walk]) -> list[Line2D]:
    names = dict.fromkeys((walk.engine, walk.preset) for walk in walks)
    handles = canvas.preset_handles(names, **_line_style(AXES[walks[0].axis]))
    probes = [probe for walk in walks for probe in walk.probes]
    if any(probe.undetected for probe in probes):
        handles.append(Line2D([], [], label="ring, or red mark: undetected", **UNDETECTED_RING))
    return [*handles, *outcome_handles({probe.outcome for probe in probes if probe.errors is None})]
