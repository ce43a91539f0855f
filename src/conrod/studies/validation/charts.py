"""Figures of a validation: errors over the crank angle, over steps, and of all machines."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator, MultipleLocator

from conrod.exact.motion import QUANTITIES
from conrod.report.charts.canvas import (
    NORMS,
    add_legend_above,
    round_to_grid,
    round_to_log_grid,
    set_log_axis,
    set_rows,
)
from conrod.report.charts.panels import MARGINS, ErrorCurve, Panel, labelled_style, panels_figure
from conrod.report.charts.styles import curve_style, preset_style, preset_title
from conrod.report.numbers import ROUNDING
from conrod.scenes import Scene
from conrod.studies.validation.results import SceneStudy, ValidationResult, drawable_runs

ROW_HEIGHT = 0.26  # of a machine [inch]
MAX_ERROR_OVER_L = 10.0  # end of the scale: a run with a larger error no longer moves like the machine
HALF_MARK = 1.6  # ratio by which an axis of errors goes on beyond its last marks
STEP_AXIS_MARGIN = 1.15  # ratio of the axis's ends to the first and last number of steps
STEPS_LABEL = "steps per revolution N (step of the crank angle h = 2π / N)"
UNSUPPORTED_STYLE: dict[str, Any] = {"linestyle": "none", "marker": "_", "markersize": 8.0, "color": "#aaaaaa"}
MAX_STEP_TICKS = 10  # named on an axis


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
        labelled_style(run),
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
            curves.append((at, round_to_log_grid(errors), labelled_style(run)))
        panels.append(Panel(f"{name} error, max / {NORMS[name]}", curves, ends))
    shown = steps[:: -(-len(steps) // MAX_STEP_TICKS)]
    return panels_figure(panels, STEPS_LABEL, lambda axes: set_log_axis(axes, ends, shown, [str(n) for n in shown]))


def overview_figure(scenes: Mapping[str, Mapping[str, Any]]) -> Figure:
    """Draw position errors in a row for each machine; failed runs are crosses at the right.

    Args:
        scenes: summaries of validations by machine.
    """
    figure = Figure(figsize=(10.5, ROW_HEIGHT * len(scenes) + MARGINS))
    axes = figure.subplots()
    labels: dict[str, Any] = {}
    for row, summary in enumerate(scenes.values()):
        for result in summary["results"]:
            if result["mode"] != "dynamic":
                continue
            if result["outcome"] == "unsupported":
                (mark,) = axes.plot([MAX_ERROR_OVER_L], [row], **UNSUPPORTED_STYLE, clip_on=False)
                labels.setdefault("unsupported", mark)
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
                labels.setdefault("did not complete", Line2D([], [], **(style | {"color": "#777777"})))
    ends = ROUNDING / HALF_MARK, MAX_ERROR_OVER_L * HALF_MARK
    set_log_axis(axes, ends, [10.0**k for k in range(-12, 2, 2)])
    set_rows(axes, list(scenes))
    axes.set_xlabel("largest position error / L over the run")
    for name, mark in labels.items():
        mark.set_label(name)
    add_legend_above(figure, [*labels.values()], handlelength=1.5)
    return figure
