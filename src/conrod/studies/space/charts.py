"""The figure of machines in space: errors against the cost of a revolution."""

from __future__ import annotations

import math

import numpy as np
from matplotlib.figure import Figure

from conrod.exact.motion import QUANTITIES
from conrod.report.charts.canvas import add_legend_above, preset_handles, round_to_log_grid, set_decades, set_log_axis
from conrod.report.charts.styles import preset_style
from conrod.studies.space.results import SpatialResult, SpatialStudy, StepRun

WIDTH, PANEL, MARGINS = 9.0, 2.6, 1.3  # of a figure, of a panel, of legend and labels [inch]
NORMS = {"position": "L", "velocity": "largest speed", "acceleration": "largest acceleration"}


def work_precision_figure(study: SpatialStudy) -> Figure:
    """Draw errors against CPU time of a revolution relative to the cheapest run, a panel for each quantity."""
    drawn = [(one, runs) for one in study.results if (runs := timed_runs(one))]
    least = min(run.revolution_cost for _, runs in drawn for run in runs)
    figure = Figure(figsize=(WIDTH, PANEL * len(QUANTITIES) + MARGINS))
    panels = figure.subplots(len(QUANTITIES), 1, sharex=True)
    most = max(run.revolution_cost for _, runs in drawn for run in runs) / least
    decades = [10.0**k for k in range(math.ceil(math.log10(1.6 * most)))]
    for axes, quantity in zip(panels, QUANTITIES, strict=True):
        set_log_axis(axes, (1.0 / 1.6, 1.6 * most), decades, [f"{decade:g}" for decade in decades])
        curves = [(one, *_curve(runs, quantity, least)) for one, runs in drawn]
        set_decades(axes, [errors for _, _, errors in curves])
        axes.set_ylabel(f"{quantity} error / {NORMS[quantity]}")
        for one, costs, errors in curves:
            axes.plot(costs, errors, **preset_style(one.engine, one.preset))
    panels[0].set_title(f"{study.name}: {study.title}", loc="left", parse_math=False)
    panels[-1].set_xlabel("CPU time of a revolution, over that of the cheapest run")
    add_legend_above(figure, preset_handles((one.engine, one.preset) for one, _ in drawn), 3)
    return figure


def timed_runs(one: SpatialResult) -> list[StepRun]:
    """The completed runs of a result that have a cost."""
    return [run for run in one.runs if run.errors is not None and not math.isnan(run.cost)]


def _curve(runs: list[StepRun], quantity: str, least: float) -> tuple[np.ndarray, np.ndarray]:
    costs = round_to_log_grid(np.array([run.revolution_cost / least for run in runs]))
    return costs, round_to_log_grid(np.array([run.worst(quantity) for run in runs]))
