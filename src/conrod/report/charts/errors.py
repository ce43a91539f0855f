"""Error of every run against the crank angle."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from conrod.report.charts.canvas import on_grid, on_log_grid, tolerance_heads
from conrod.report.charts.layout import NORMS
from conrod.report.charts.panels import Curve, angle_ticks, error_panel, finish_panels
from conrod.report.charts.styles import completed, curve_style, label
from conrod.scenes import Scene
from conrod.studies.frame.measurement import QUANTITIES
from conrod.studies.validation.results import SceneStudy, ValidationResult


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
    return angle, on_log_grid(error), curve_style(run) | {"label": label(run)}
