"""Drive torque over the crank angle, exact and by engines, and its error."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator, MultipleLocator

from conrod.report.charts.canvas import legend_above, on_grid, on_log_grid, taking_turns, whole_decades
from conrod.report.charts.styles import EXACT, preset_style, preset_title
from conrod.studies.forces.results import ForceResult, TorqueCurve

MARKERS = 12
LEAST = 1e-12


def torque_figure(results: Sequence[ForceResult]) -> Figure:
    """Torque of the last turn above, its error over the peak below, a line for each run that reports it."""
    runs = [(run, run.curve) for run in results if run.curve is not None]
    figure = Figure(figsize=(10.5, 7.4))
    above, below = figure.subplots(2, 1)
    _torques(above, runs)
    drawn = []
    whole = max(abs(float(np.degrees(np.ptp(curve.error_angle)))) for _, curve in runs)
    for place, (run, curve) in enumerate(runs):
        error = on_log_grid(np.maximum(curve.error, LEAST))
        drawn.append(error)
        below.plot(on_grid(np.degrees(curve.error_angle), whole), error, **_style(run, place, len(runs), len(error)))
    whole_decades(below, drawn)
    below.set_ylabel("error of the torque / exact peak")
    below.set_xlabel("crank angle [deg]; above the last turn, below the whole run")
    if whole >= 180.0:
        below.xaxis.set_major_locator(MultipleLocator(90.0))
    figure.align_ylabels([above, below])
    handles, labels = above.get_legend_handles_labels()
    figure.subplots_adjust(left=0.09, right=0.97, top=0.93, bottom=0.075, hspace=0.15)
    legend_above(figure, handles, labels)
    return figure


def _torques(axes: Axes, runs: list[tuple[ForceResult, TorqueCurve]]) -> None:
    _, first = runs[0]
    span = float(np.degrees(np.ptp(first.angle)))
    # A run that went wrong is not to hide the others.
    size = float(np.abs(first.exact).max()) or 1.0
    low, high = float(first.exact.min()), float(first.exact.max())
    room = 0.15 * max(high - low, 1e-3 * size)
    axes.plot(on_grid(np.degrees(first.angle), span), on_grid(first.exact, size), label="exact", **EXACT)
    for place, (run, curve) in enumerate(runs):
        angle, torque = np.degrees(curve.angle), curve.told
        style = _style(run, place, len(runs), len(angle))
        axes.plot(on_grid(angle, span), on_grid(torque, size), **style)
    axes.set_ylim(low - room, high + room)
    axes.xaxis.set_major_locator(MultipleLocator(45.0) if span >= 180.0 else MaxNLocator(8, steps=[1, 2, 3, 5, 10]))
    axes.set_ylabel("drive torque [N m]")


def _style(run: ForceResult, place: int, runs: int, samples: int) -> dict[str, Any]:
    return {
        **preset_style(run.engine, run.preset),
        "label": preset_title(run.engine, run.preset),
        "markevery": taking_turns(samples, place, runs, MARKERS, samples - 4),
    }
