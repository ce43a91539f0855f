"""Drive torque over the crank angle, exact and by engines, and its error."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MultipleLocator

from conrod.report.charts.canvas import on_grid, on_log_grid
from conrod.report.charts.panels import angle_ticks, draw_curves, error_panel, finish_panels
from conrod.report.charts.styles import EXACT, preset_style, preset_title
from conrod.studies.forces.results import ForceResult, TorqueCurve

LEAST = 1e-12


def torque_figure(results: Sequence[ForceResult]) -> Figure:
    """Torque of the last turn above, its error over the peak below, a line for each run that reports it."""
    runs = [(run, run.curve) for run in results if run.curve is not None]
    figure = Figure(figsize=(10.5, 7.4))
    above, below = figure.subplots(2, 1)
    _torques(above, runs)
    whole = max(abs(float(np.degrees(np.ptp(curve.error_angle)))) for _, curve in runs)
    errors = [
        (on_grid(np.degrees(curve.error_angle), whole), on_log_grid(np.maximum(curve.error, LEAST)), _style(run))
        for run, curve in runs
    ]
    error_panel(below, "error of the torque / exact peak", errors, tail=4)
    below.set_xlabel("crank angle [deg]; above the last turn, below the whole run")
    if whole >= 180.0:
        below.xaxis.set_major_locator(MultipleLocator(90.0))
    return finish_panels(figure, [above, below], left=0.09, bottom=0.075, hspace=0.15)


def _torques(axes: Axes, runs: list[tuple[ForceResult, TorqueCurve]]) -> None:
    _, first = runs[0]
    span = float(np.degrees(np.ptp(first.angle)))
    # A run that went wrong is not to hide the others.
    size = float(np.abs(first.exact).max()) or 1.0
    low, high = float(first.exact.min()), float(first.exact.max())
    room = 0.15 * max(high - low, 1e-3 * size)
    axes.plot(on_grid(np.degrees(first.angle), span), on_grid(first.exact, size), label="exact", **EXACT)
    torques = [(on_grid(np.degrees(c.angle), span), on_grid(c.reported, size), _style(run)) for run, c in runs]
    draw_curves(axes, torques, tail=4)
    axes.set_ylim(low - room, high + room)
    axes.xaxis.set_major_locator(angle_ticks(span, 45.0))
    axes.set_ylabel("drive torque [N m]")


def _style(run: ForceResult) -> dict[str, Any]:
    return preset_style(run.engine, run.preset) | {"label": preset_title(run.engine, run.preset)}
