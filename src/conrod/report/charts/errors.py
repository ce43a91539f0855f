"""Error of every run against the crank angle."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import Locator, MaxNLocator, MultipleLocator

from conrod.exact.motion import Array
from conrod.report.charts.canvas import legend_above, on_grid, on_log_grid, taking_turns, tolerance_heads, whole_decades
from conrod.report.charts.layout import NORMS
from conrod.report.charts.styles import completed, curve_style, label
from conrod.scenes import Scene
from conrod.studies.validation.results import QUANTITIES, Result, SceneStudy

MARKERS_PER_RUN = 12


def error_figure(study: SceneStudy) -> Figure:
    """Largest error over the observed points in each span of the crank angle, a panel for each quantity."""
    runs = completed(study.results)
    figure = Figure(figsize=(10.5, 9.0))
    panels = figure.subplots(3, 1, sharex=True)
    for axes, name in zip(panels, QUANTITIES, strict=True):
        drawn = []
        for place, run in enumerate(runs):
            angle, error = _error_curve(run, name)
            drawn.append(error)
            marks = taking_turns(len(angle), place, len(runs), MARKERS_PER_RUN, len(angle) - 4)
            axes.plot(angle, error, markevery=marks, label=label(run), **curve_style(run))
        whole_decades(axes, drawn)
        axes.set_ylabel(f"{name} error / {NORMS[name]}")
        if runs:
            begin, end = _ends(study.scene, max(run.revolutions for run in runs))
            axes.set_xlim(begin, end)
            tolerance_heads(axes, end, [(getattr(run.tolerance, name), curve_style(run)) for run in runs])
            panels[-1].xaxis.set_major_locator(_ticks(abs(end - begin)))
    panels[-1].set_xlabel("crank angle [deg]")
    handles, labels = panels[0].get_legend_handles_labels()
    handles.append(Line2D([], [], linestyle="none", marker="<", color="#444444", markersize=6))
    labels.append("tolerance")
    figure.align_ylabels(panels)
    figure.subplots_adjust(left=0.085, right=0.97, top=0.93, bottom=0.06, hspace=0.13)
    legend_above(figure, handles, labels)
    return figure


def _ends(scene: Scene, revolutions: float) -> tuple[float, float]:
    """Crank angles [deg] at which a run begins and ends; the end is on the right, also where the angle falls."""
    if scene.kinematics.mechanism.driver.span is None:
        return 0.0, float(np.copysign(np.degrees(2.0 * np.pi * revolutions), scene.speed))
    low, high = (float(angle) for angle in np.degrees(scene.kinematics.span))
    return (low, high) if scene.speed > 0.0 else (high, low)


def _ticks(degrees: float) -> Locator:
    """Quarters of a turn; of less than two of them whatever divides it well."""
    return MultipleLocator(90.0) if degrees >= 180.0 else MaxNLocator(8, steps=[1, 2, 3, 5, 10])


def _error_curve(run: Result, name: str) -> tuple[Array, Array]:
    """Crank angle [deg] and the largest error there over all observed points, on the grid that is drawn."""
    assert run.curves is not None
    curves = [curves[name] for curves in run.curves.values()]
    error = np.max([curve.error for curve in curves], axis=0)
    return on_grid(np.degrees(curves[0].error_angle), 360.0 * run.revolutions), on_log_grid(error)
