"""The strip above a work-precision diagram: runs that did not complete, a lane for each way of ending.

The work-precision diagram: error against cost, every cell of the grid in it.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from conrod.report import numbers
from conrod.report.charts.canvas import on_log_grid, whole_decades
from conrod.report.charts.errors import NORMS
from conrod.report.charts.styles import colour, engine_title, preset_style
from conrod.report.sweep.choice import preset_curves
from conrod.report.sweep.diagram_names import name_curves, name_points
from conrod.report.sweep.placing import (
    FRONT_OF_ALL,
    Placed,
    dot_style,
    drawn_costs,
    drawn_errors,
    front_style,
    placed_points,
    reference_seconds,
)
from conrod.runs.trajectory import Outcome
from conrod.studies.frame.measurement import QUANTITIES
from conrod.studies.sweep.results import SweepStudy

# A marker for each way in which runs end that do not complete; any other end gets the last one.
MARKERS = {
    Outcome.DIVERGED.slug: "x",
    Outcome.EXPLODED.slug: "*",
    Outcome.OPENED.slug: "v",
    Outcome.FLIPPED.slug: ">",
    Outcome.LOCKED.slug: "s",
    Outcome.RESET.slug: "P",
    Outcome.TIMED_OUT.slug: "h",
}
OTHER = "X"
APART = (0.0, 0.24, -0.24)  # runs of one cost, in lanes


def ends_of(placed: Sequence[Placed]) -> tuple[str, ...]:
    """The ways in which runs ended that did not complete, in the order of the outcomes."""
    found = {p.point.measurement.outcome for p in placed if not p.point.completed}
    known = [outcome.slug for outcome in Outcome if outcome.slug in found]
    return (*known, *sorted(found.difference(known)))


def draw_strip(axes: Axes, placed: Sequence[Placed], ends: Sequence[str]) -> None:
    """A marker for each run, in the lane of its end."""
    for lane, end in enumerate(ends):
        failed = [p for p in placed if p.point.measurement.outcome == end]
        for k, one in enumerate(failed):
            axes.plot(
                on_log_grid(np.array([one.cost])),
                [lane + APART[k % len(APART)]],
                linestyle="none",
                marker=MARKERS.get(end, OTHER),
                markersize=4.0,
                color=colour(one.point.engine),
                alpha=0.7,
                markeredgewidth=0.6,
            )
    axes.set_ylim(len(ends) - 0.4, -0.6)
    axes.set_yticks(range(len(ends)), ends)
    axes.yaxis.tick_right()
    axes.tick_params(axis="y", length=0, labelsize=8.0)
    axes.tick_params(axis="x", length=0, labelbottom=False)
    axes.set_ylabel("did not\ncomplete", fontsize=8.0)
    axes.set_facecolor("#f6f6f6")
    for side in ("left", "bottom"):
        axes.spines[side].set_visible(False)


WIDTH, PANEL_HEIGHT, LANE_HEIGHT = 10.5, 4.9, 0.26  # [inch]
LEFT, RIGHT, TOP, GAP, BOTTOM = 0.85, 1.2, 1.05, 0.3, 1.5  # margins [inch]
PANEL_WIDTH = WIDTH - LEFT - RIGHT
POINT = 1.0 / 72.0  # [inch]
OUTWARD = (40.0, 80.0, 120.0)  # of the axes in steps of the reference loops [pt]


def work_precision_figure(study: SweepStudy) -> Figure | None:
    """Error against CPU time for each quantity, runs that did not complete in a strip above; None without timings."""
    placed = placed_points(study)
    if not placed:
        return None
    ends = ends_of(placed)
    strip = LANE_HEIGHT * len(ends) + (GAP if ends else 0.0)
    height = TOP + strip + len(QUANTITIES) * (PANEL_HEIGHT + GAP) + BOTTOM
    figure = Figure(figsize=(WIDTH, height))
    limits = _cost_limits(placed)
    if ends:
        axes = _axes(figure, height - TOP, strip - GAP, height)
        draw_strip(axes, placed, ends)
        _cost_axis(axes, limits)
    for k, quantity in enumerate(QUANTITIES):
        axes = _axes(figure, height - TOP - strip - k * (PANEL_HEIGHT + GAP), PANEL_HEIGHT, height)
        _cost_axis(axes, limits)
        _draw_panel(axes, study, placed, quantity)
        if quantity == QUANTITIES[-1]:
            axes.set_xlabel("CPU time of a simulated revolution", labelpad=2.0)
            _reference_axes(axes, study, limits)
        else:
            axes.tick_params(axis="x", labelbottom=False)
    handles = _legend(study, placed)
    at = (0.5, 1.0 - 0.05 / height)
    figure.legend(handles=handles, loc="upper center", ncol=3, bbox_to_anchor=at, handlelength=3.4, columnspacing=3.0)
    return figure


def _axes(figure: Figure, top: float, tall: float, height: float) -> Axes:
    """Axes whose upper edge is so far from the figure's lower one [inch]."""
    return figure.add_axes((LEFT / WIDTH, (top - tall) / height, PANEL_WIDTH / WIDTH, tall / height))


# -- axes --------------------------------------------------------------------------------------------------------------


def _cost_limits(placed: Sequence[Placed]) -> tuple[float, float]:
    costs = on_log_grid(np.array([p.cost for p in placed]))
    return float(costs.min()) / 1.6, float(costs.max()) * 1.6


def _cost_axis(axes: Axes, limits: tuple[float, float]) -> None:
    """A logarithmic axis of CPU time, with its decades in words."""
    axes.set_xscale("log")
    axes.set_xlim(*limits)
    decades = [10.0**k for k in _decades(limits)]
    axes.set_xticks(decades, [_decade_of_time(value) for value in decades])
    axes.minorticks_off()


def _decades(limits: tuple[float, float]) -> range:
    return range(int(np.ceil(np.log10(limits[0]))), int(np.floor(np.log10(limits[1]))) + 1)


def _decade_of_time(seconds: float) -> str:
    unit, factor = ("µs", 1e6) if seconds < 0.9e-3 else ("ms", 1e3) if seconds < 0.9 else ("s", 1.0)
    return f"{seconds * factor:.0f} {unit}"


def _reference_axes(axes: Axes, study: SweepStudy, limits: tuple[float, float]) -> None:
    """The same axis in steps of each engine's reference loop: a figure that carries to other machines."""
    for engine, outward in zip(study.engines, OUTWARD, strict=False):
        step = reference_seconds(study, engine)
        if step is None:
            continue
        other = axes.twiny()
        own = (limits[0] / step, limits[1] / step)
        other.set_xscale("log")
        other.set_xlim(*own)
        other.set_xticks([10.0**k for k in _decades(own)], [_decade_of_steps(k) for k in _decades(own)])
        other.minorticks_off()
        other.grid(visible=False)
        other.xaxis.set_ticks_position("bottom")
        other.xaxis.set_label_position("bottom")
        other.spines["bottom"].set_position(("outward", outward))
        other.spines["bottom"].set_edgecolor(colour(engine))
        other.tick_params(axis="x", colors=colour(engine), labelsize=8.0)
        title = f"{engine_title(engine)}: the same cost in steps of its reference loop"
        other.set_xlabel(f"{title} ({numbers.duration(step)} each)", color=colour(engine), fontsize=8.0, labelpad=1.0)


def _decade_of_steps(exponent: int) -> str:
    return f"{10.0**exponent:.0f}" if 0 <= exponent < 4 else f"1e{exponent}"


# -- panels ------------------------------------------------------------------------------------------------------------


def _draw_panel(axes: Axes, study: SweepStudy, placed: Sequence[Placed], quantity: str) -> None:
    completed = [p for p in placed if p.point.completed]
    whole_decades(axes, [drawn_errors([p.point for p in completed], quantity)])
    axes.set_ylabel(f"{quantity} error, max / {NORMS[quantity]}")
    overall = study.front(quantity)
    axes.plot(drawn_costs(overall), drawn_errors(overall, quantity), **FRONT_OF_ALL)
    for engine in study.engines:
        others = [p for p in completed if p.point.engine == engine and p.point.preset is None]
        _plot(axes, others, quantity, **dot_style(engine))
        front = study.front(quantity, engine)
        axes.plot(drawn_costs(front), drawn_errors(front, quantity), **front_style(engine))
    costs = {p.point.label: p.cost for p in placed}
    curves = [[p for p in curve.points if p.completed and p.label in costs] for curve in preset_curves(study)]
    for curve in (points for points in curves if points):
        at = on_log_grid(np.array([costs[p.label] for p in curve]))
        axes.plot(at, drawn_errors(curve, quantity), **preset_style(curve[0].engine, curve[0].preset))
    name_points(axes, study, completed, quantity, (PANEL_WIDTH / POINT, PANEL_HEIGHT / POINT))
    name_curves(axes, study, costs, quantity)


def _plot(axes: Axes, placed: Sequence[Placed], quantity: str, **style: Any) -> None:
    at = on_log_grid(np.array([p.cost for p in placed]))
    axes.plot(at, drawn_errors([p.point for p in placed], quantity), **style)


def _legend(study: SweepStudy, placed: Sequence[Placed]) -> list[Line2D]:
    handles = [
        Line2D([], [], label=f"{engine_title(c.engine)} {c.preset}", **preset_style(c.engine, c.preset))
        for c in preset_curves(study)
    ]
    timed = [engine for engine in study.engines if any(p.point.engine == engine for p in placed)]
    for engine in timed:
        style = dot_style(engine) | {"alpha": 0.5, "markersize": 4.0}
        handles.append(Line2D([], [], label=f"{engine_title(engine)}, other settings", **style))
    for engine in timed:
        label = f"best of {engine_title(engine)} (Pareto front)"
        handles.append(Line2D([], [], label=label, **front_style(engine)))
    handles.append(Line2D([], [], label="best of all engines", **FRONT_OF_ALL))
    return handles
