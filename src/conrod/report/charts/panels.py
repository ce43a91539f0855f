"""Figures of errors: panels over angle, time or steps, and an overview of all machines."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import cycle
from typing import Any, TypeAlias

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator, MultipleLocator

from conrod.exact.motion import Array
from conrod.own.tables.errors import ERRORS
from conrod.own.tables.study import TableStudy
from conrod.report.charts.canvas import (
    NORMS,
    add_legend_above,
    draw_tolerance_heads,
    round_to_grid,
    round_to_log_grid,
    set_decades,
    set_log_axis,
    set_rows,
)
from conrod.report.charts.styles import CURVE_COLOURS, curve_style, drawable_runs, label, preset_style, preset_title
from conrod.report.numbers import ROUNDING
from conrod.scenes import Scene
from conrod.studies.frame.case import QUANTITIES
from conrod.studies.frame.result import Result
from conrod.studies.free_motion.results import MotionStudy
from conrod.studies.validation.results import SceneStudy, ValidationResult

MARKERS_PER_CURVE = 12  # of a curve
HEIGHT, ROW, MARGINS = 2.8, 0.26, 1.05  # of a panel, of a machine's row, of legend and labels [inch]
MAX_ERROR_OVER_L = 10.0  # end of the scale: a run with a larger error no longer moves like the machine
STEP_AXIS_MARGIN = 1.15  # ratio of the axis's ends to the first and last number of steps
STEPS_LABEL = "steps per revolution N (step of the crank angle h = 2π / N)"
MAX_STEP_TICKS = 10  # named on an axis
MIN_SHARE_OF_LARGEST = 1e-5  # of a table's panel, below which errors are not drawn: a run may begin with none

# Abscissae (N,) and errors (N,), rounded for drawing, and arguments of `Axes.plot`.
ErrorCurve: TypeAlias = tuple[Array, Array, Mapping[str, Any]]


@dataclass(frozen=True)
class Panel:
    """Curves of errors on a logarithmic scale.

    Attributes:
        label: label of the vertical axis.
        curves: the curves.
        ends: ends of the horizontal axis.
        allowed: tolerances with the style of their curves, drawn as arrow heads at the right edge.
    """

    label: str
    curves: Sequence[ErrorCurve]
    ends: tuple[float, float]
    allowed: Sequence[tuple[float | None, Mapping[str, Any]]] = ()


def panels_figure(panels: Sequence[Panel], along: str, ticks: Callable[[Axes], None] = lambda _: None) -> Figure:
    """Draw panels above each other with one legend.

    Args:
        panels: from top to bottom.
        along: label of the horizontal axis.
        ticks: divides the horizontal axis."""
    figure = Figure(figsize=(10.5, HEIGHT * len(panels) + MARGINS))
    drawn = figure.subplots(len(panels), 1, squeeze=False)[:, 0]
    named = dict[str, Any]()
    for axes, panel in zip(drawn, panels, strict=True):
        axes.set_xlim(*panel.ends)
        draw_error_panel(axes, panel.label, panel.curves)
        draw_tolerance_heads(axes, panel.ends[1], panel.allowed)
        ticks(axes)
        handles, labels = axes.get_legend_handles_labels()
        named |= dict(zip(labels, handles, strict=True))
    if any(allowed is not None for panel in panels for allowed, _ in panel.allowed):
        look: dict[str, Any] = {"linestyle": "none", "marker": "<", "color": "#444444", "markersize": 6}
        named["tolerance"] = Line2D([], [], label="tolerance", **look)
    drawn[-1].set_xlabel(along)
    figure.align_ylabels(list(drawn))
    add_legend_above(figure, [*named.values()])
    return figure


def draw_error_panel(axes: Axes, label: str, curves: Sequence[ErrorCurve]) -> None:
    """Draw curves of errors on a logarithmic axis, with markers that do not cover each other."""
    for place, (at, values, style) in enumerate(curves):
        every = max(1, len(at) // MARKERS_PER_CURVE)
        # The curves take turns, so that no marker covers another.
        marks = slice((place * every) // len(curves), None, every)
        axes.plot(at, values, markevery=marks, **style)
    set_decades(axes, [values for _, values, _ in curves])
    axes.set_ylabel(label)


def _labelled_style(run: Result) -> dict[str, Any]:
    return curve_style(run) | {"label": label(run)}


# -- validations -------------------------------------------------------------------------------------------------------


def error_figure(study: SceneStudy) -> Figure:
    """Draw the largest error over the observed points against the crank angle."""
    runs = drawable_runs(study.results)
    ends = _crank_span(study.scene, max(run.revolutions for run in runs))
    panels = [
        Panel(
            f"{name} error / {NORMS[name]}", [_error_curve(run, name) for run in runs], ends,
            [(getattr(run.tolerance, name), curve_style(run)) for run in runs],
        )
        for name in QUANTITIES
    ]  # fmt: skip

    def ticks(axes: Axes) -> None:
        """Divide the axis by quarter turns, or a short span by a round number of degrees."""
        degrees = abs(ends[1] - ends[0])
        whole = MultipleLocator(90.0 * max(1, round(degrees / 720.0)))
        axes.xaxis.set_major_locator(whole if degrees >= 180.0 else MaxNLocator(8, steps=[1, 2, 3, 5, 10]))

    return panels_figure(panels, "crank angle [deg]", ticks)


def _crank_span(scene: Scene, revolutions: float) -> tuple[float, float]:
    """Return the crank angles [deg] at which a run begins and ends."""
    if scene.kinematics.mechanism.driver.span is None:
        return 0.0, float(np.copysign(np.degrees(2.0 * np.pi * revolutions), scene.speed))
    low, high = (float(angle) for angle in np.degrees(scene.kinematics.span))
    return (low, high) if scene.speed > 0.0 else (high, low)


def _error_curve(run: ValidationResult, name: str) -> ErrorCurve:
    """Return the largest error over all observed points against the crank angle [deg]."""
    assert run.curves is not None
    curves = [curves[name] for curves in run.curves.values()]
    error = np.max([curve.error for curve in curves], axis=0)
    return (
        round_to_grid(np.degrees(curves[0].error_angle), 360.0 * run.revolutions),
        round_to_log_grid(error),
        _labelled_style(run),
    )


def refinement_figure(study: SceneStudy) -> Figure:
    """Draw the largest error over the observed points against steps per revolution."""
    runs = [r for r in study.results if r.mode == "dynamic" and r.refinement]
    steps = sorted({p.steps_per_revolution for r in runs for p in r.refinement})
    ends = (steps[0] / STEP_AXIS_MARGIN, steps[-1] * STEP_AXIS_MARGIN)
    panels = []
    for name in QUANTITIES:
        curves = []
        for run in runs:
            stable = [(p.steps_per_revolution, e) for p in run.refinement if (e := getattr(p, name)) is not None]
            at, errors = np.array(stable, dtype=float).reshape(-1, 2).T
            curves.append((at, round_to_log_grid(errors), _labelled_style(run)))
        panels.append(Panel(f"{name} error, max / {NORMS[name]}", curves, ends))
    shown = steps[:: -(-len(steps) // MAX_STEP_TICKS)]
    return panels_figure(panels, STEPS_LABEL, lambda axes: set_log_axis(axes, ends, shown, [str(n) for n in shown]))


def overview_figure(scenes: Mapping[str, Mapping[str, Any]]) -> Figure:
    """Draw position errors in a row for each machine; failed runs are crosses at the right.

    Args:
        scenes: summaries of validations by machine.
    """
    figure = Figure(figsize=(10.5, ROW * len(scenes) + MARGINS))
    axes = figure.subplots()
    labels: dict[str, Any] = {}
    for row, summary in enumerate(scenes.values()):
        for result in summary["results"]:
            if result["mode"] != "dynamic" or result["outcome"] == "unsupported":
                continue
            style = preset_style(result["engine"], result["preset"]) | {"linestyle": "none"}
            error = result["largest"]["position"]
            if result["outcome"] == "completed" and error is not None:
                at = float(round_to_log_grid(np.array([min(error, MAX_ERROR_OVER_L)]))[0])
            else:
                at, style = MAX_ERROR_OVER_L, style | {"marker": "x", "markersize": 6.0}
            (mark,) = axes.plot([at], [row], **style, clip_on=False)
            labels.setdefault(preset_title(result["engine"], result["preset"]), mark)
            if result["outcome"] != "completed":
                labels.setdefault("did not complete", mark)
    set_log_axis(axes, (ROUNDING, MAX_ERROR_OVER_L), [10.0**k for k in range(-12, 2, 2)])
    set_rows(axes, list(scenes))
    axes.set_xlabel("largest position error / L over the run")
    for name, mark in labels.items():
        mark.set_label(name)
    add_legend_above(figure, [*labels.values()], handlelength=1.5)
    return figure


def free_motion_figure(study: MotionStudy) -> Figure:
    """Draw the errors of all completed runs of free motion over time."""
    runs = [(r, r.curves) for r in study.results if r.curves is not None]
    seconds = max(run.seconds for run, _ in runs)
    errors, energies = (
        [(round_to_grid(c.middles, seconds), round_to_log_grid(getattr(c, name)), _labelled_style(r)) for r, c in runs]
        for name in ("error", "energy")
    )
    allowed = [(run.tolerance.get("position"), curve_style(run)) for run, _ in runs]
    panels = [
        Panel("position error / L", errors, (0.0, seconds), allowed),
        Panel("energy error / largest energy", energies, (0.0, seconds)),
    ]
    return panels_figure(panels, "time [s]")


def table_figure(study: TableStudy) -> Figure:
    """Draw the largest error of each observed point of a table against revolutions."""
    # Without a crank angle the errors `position` and `total` are the same.
    named = [q for q in ERRORS if q != "position" or study.phase is not None]
    hues = dict(zip(study.errors, cycle(CURVE_COLOURS), strict=False))
    panels = []
    for quantity in named:
        curves = {point: errors[quantity] for point, errors in study.errors.items() if quantity in errors}
        if curves:
            least = max(ROUNDING, MIN_SHARE_OF_LARGEST * max(float(curve.largest.max()) for curve in curves.values()))
            lines = [
                (
                    round_to_grid(curve.at, study.revolutions), round_to_log_grid(np.maximum(curve.largest, least)),
                    {"color": hues[point], "label": point},
                )
                for point, curve in curves.items()
            ]  # fmt: skip
            head = {"color": "#444444", "markerfacecolor": "#444444"}
            title, allowed = f"{quantity} error / {NORMS.get(quantity, 'L')}", [(study.tolerance.get(quantity), head)]
            panels.append(Panel(title, lines, (0.0, study.revolutions), allowed))
    return panels_figure(panels, "revolutions since the first row")
