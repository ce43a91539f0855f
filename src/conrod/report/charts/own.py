"""A user's own model and table against the exact motion: paths with the crank held, and errors over a run."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import cycle

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MultipleLocator

from conrod.own.models.results import ModelStudy
from conrod.own.models.runs import QUANTITIES, JudgedRun
from conrod.own.tables.samples import ERRORS
from conrod.own.tables.study import TableStudy
from conrod.report.charts.canvas import NORMS, on_grid, on_log_grid, tolerance_heads
from conrod.report.charts.panels import Curve, error_panel, finish_panels
from conrod.report.charts.styles import HUES, preset_style
from conrod.report.numbers import ROUNDING

PANEL, MARGINS = 2.6, 0.9  # heights [inch]
HEAD = {"color": "#444444", "markerfacecolor": "#444444"}  # of a tolerance


def model_figure(study: ModelStudy) -> Figure:
    """Errors of the runs over the crank angle, a panel for each quantity."""
    drawn = [run for run in study.runs.values() if run.errors is not None]
    figure, panels = _stacked(len(QUANTITIES))
    for axes, quantity in zip(panels, QUANTITIES, strict=True):
        error_panel(axes, f"{quantity} / {NORMS[quantity]}", [_curve(run, quantity) for run in drawn])
        axes.set_xlim(0.0, np.copysign(360.0 * study.revolutions, study.scene.speed))
        axes.xaxis.set_major_locator(MultipleLocator(90.0 * max(1, round(study.revolutions / 2.0))))
    return _finished(figure, panels, "crank angle [deg]")


def _curve(run: JudgedRun, quantity: str) -> Curve:
    """Crank angle [deg] and the largest error over all points, the largest in each span."""
    assert run.errors is not None
    curves = [errors[quantity] for errors in run.errors.values()]
    peaks = np.max([one.largest for one in curves], axis=0)
    angles = np.degrees(curves[0].at)
    turns = float(np.ptp(angles)) or 360.0
    errors = on_log_grid(np.maximum(peaks, ROUNDING / 10.0))
    style = preset_style("mujoco", run.label) | {"label": run.label}
    return on_grid(angles - 360.0 * np.round(angles[0] / 360.0), turns), errors, style


def error_figure(study: TableStudy) -> Figure:
    """Largest error in each span of the run against the revolutions, a line for each point."""
    # Without a crank angle the error at the angle reached is that at the time.
    named = [q for q in ERRORS if q != "position" or study.crank is not None]
    shown = [q for q in named if any(q in errors for errors in study.errors.values())]
    figure, panels = _stacked(len(shown))
    for axes, quantity in zip(panels, shown, strict=True):
        of_points = {point: errors[quantity] for point, errors in study.errors.items() if quantity in errors}
        curves: list[Curve] = [
            (
                on_grid(curve.at, study.revolutions),
                on_log_grid(np.maximum(curve.largest, ROUNDING / 10.0)),
                {"label": point, "color": hue},
            )
            for (point, curve), hue in zip(of_points.items(), cycle(HUES), strict=False)
        ]
        error_panel(axes, f"{quantity} error / {NORMS.get(quantity, 'L')}", curves)
        axes.set_xlim(0.0, study.revolutions)
        tolerance_heads(axes, study.revolutions, [(study.tolerance.get(quantity), HEAD)])
    return _finished(figure, panels, "revolutions since the first row")


def _stacked(count: int) -> tuple[Figure, Sequence[Axes]]:
    """A figure of panels above each other."""
    figure = Figure(figsize=(9.0, PANEL * count + MARGINS))
    return figure, list(figure.subplots(count, 1, squeeze=False)[:, 0])


def _finished(figure: Figure, panels: Sequence[Axes], along: str) -> Figure:
    """Line up panels; the legend of the first stands above them."""
    panels[-1].set_xlabel(along)
    room = figure.get_figheight()
    return finish_panels(figure, panels, left=0.11, top=1.0 - 0.5 / room, bottom=0.55 / room)
