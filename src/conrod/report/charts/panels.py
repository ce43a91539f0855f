"""Panels of runs above each other: errors over the crank angle, and of free motion over time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, TypeAlias

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import Locator, MaxNLocator, MultipleLocator

from conrod.exact.motion import Array
from conrod.report.charts.canvas import NORMS, legend_above, on_grid, on_log_grid, tolerance_heads, whole_decades
from conrod.report.charts.styles import completed, curve_style, label
from conrod.scenes import Scene
from conrod.studies.frame.measurement import QUANTITIES
from conrod.studies.frame.result import Result
from conrod.studies.free_motion.results import MotionStudy
from conrod.studies.validation.results import SceneStudy, ValidationResult

MARKERS = 12  # of a curve
MARGINS = {"left": 0.095, "right": 0.97, "top": 0.93, "bottom": 0.06, "hspace": 0.13}

# Places and values (N,) on the grid that is drawn, and arguments of `Axes.plot`.
Curve: TypeAlias = tuple[Array, Array, Mapping[str, Any]]


def draw_curves(axes: Axes, curves: Sequence[Curve], most: int = MARKERS, tail: int = 0) -> None:
    """Draw curves whose markers stand clear of each other.

    Args:
        most: markers of a curve, about.
        tail: last samples of a curve that get no marker.
    """
    for place, (at, values, style) in enumerate(curves):
        every = max(1, len(at) // most)
        # The curves take turns, so that no marker covers another.
        marks = slice(2 + (place * every) // len(curves), len(at) - tail if tail else None, every)
        axes.plot(at, values, markevery=marks, **style)


def error_panel(axes: Axes, label: str, curves: Sequence[Curve], most: int = MARKERS, tail: int = 0) -> None:
    """Draw curves of errors on a logarithmic axis that holds them all."""
    draw_curves(axes, curves, most, tail)
    whole_decades(axes, [values for _, values, _ in curves])
    axes.set_ylabel(label)


def finish_panels(figure: Figure, panels: Sequence[Axes], handles: Sequence[Any] = (), **margins: float) -> Figure:
    """Line up panels, and set the legend of the first above them, with some more handles that have labels."""
    own, labels = panels[0].get_legend_handles_labels()
    figure.align_ylabels(list(panels))
    figure.subplots_adjust(**(MARGINS | margins))
    legend_above(figure, [*own, *handles], [*labels, *(str(one.get_label()) for one in handles)])
    return figure


def angle_ticks(degrees: float, step: float = 90.0) -> Locator:
    """Return steps of a turn; of less than half a turn whatever divides it well."""
    return MultipleLocator(step) if degrees >= 180.0 else MaxNLocator(8, steps=[1, 2, 3, 5, 10])


def _labelled(run: Result) -> dict[str, Any]:
    return curve_style(run) | {"label": label(run)}


def error_figure(study: SceneStudy) -> Figure:
    """Largest error over the observed points in each span of the crank angle, a panel for each quantity."""
    runs = completed(study.results)
    figure = Figure(figsize=(10.5, 9.0))
    panels = figure.subplots(3, 1, sharex=True)
    for axes, name in zip(panels, QUANTITIES, strict=True):
        error_panel(axes, f"{name} error / {NORMS[name]}", [_error_curve(run, name) for run in runs], tail=4)
        if runs:
            begin, end = _ends(study.scene, max(run.revolutions for run in runs))
            axes.set_xlim(begin, end)
            tolerance_heads(axes, end, [(getattr(run.tolerance, name), curve_style(run)) for run in runs])
            panels[-1].xaxis.set_major_locator(angle_ticks(abs(end - begin)))
    panels[-1].set_xlabel("crank angle [deg]")
    head = Line2D([], [], linestyle="none", marker="<", color="#444444", markersize=6, label="tolerance")
    return finish_panels(figure, panels, [head], left=0.085)


def _ends(scene: Scene, revolutions: float) -> tuple[float, float]:
    """Crank angles [deg] at which a run begins and ends; the end is on the right, also where the angle falls."""
    if scene.kinematics.mechanism.driver.span is None:
        return 0.0, float(np.copysign(np.degrees(2.0 * np.pi * revolutions), scene.speed))
    low, high = (float(angle) for angle in np.degrees(scene.kinematics.span))
    return (low, high) if scene.speed > 0.0 else (high, low)


def _error_curve(run: ValidationResult, name: str) -> Curve:
    """Crank angle [deg] and the largest error there over all observed points, on the grid that is drawn."""
    assert run.curves is not None
    curves = [curves[name] for curves in run.curves.values()]
    error = np.max([curve.error for curve in curves], axis=0)
    angle = on_grid(np.degrees(curves[0].error_angle), 360.0 * run.revolutions)
    return angle, on_log_grid(error), _labelled(run)


def free_motion_figure(study: MotionStudy) -> Figure:
    """Errors of all runs that completed, over time."""
    figure = Figure(figsize=(10.5, 6.4))
    above, below = figure.subplots(2, 1, sharex=True)
    runs = [(r, r.curves) for r in study.results if r.curves is not None]
    seconds = max(run.seconds for run, _ in runs)
    errors = [(on_grid(c.middles, seconds), on_log_grid(c.error), _labelled(r)) for r, c in runs]
    error_panel(above, "position error / L", errors)
    energies = [(on_grid(c.middles, seconds), on_log_grid(c.energy), curve_style(r)) for r, c in runs]
    error_panel(below, "energy error / largest energy", energies)
    tolerance_heads(above, seconds, [(run.tolerance.get("position"), curve_style(run)) for run, _ in runs])
    below.set_xlabel("time [s]")
    below.set_xlim(0.0, seconds)
    return finish_panels(figure, [above, below], left=0.09, bottom=0.085)
