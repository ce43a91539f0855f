"""A user's own model and table against the exact motion: paths with the crank held, and errors over a run."""

from __future__ import annotations

from itertools import cycle

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MultipleLocator

from conrod.own.models.results import EXACT_SOLVER, OWN, ModelStudy
from conrod.own.models.runs import QUANTITIES, JudgedRun
from conrod.own.tables.samples import ERRORS
from conrod.own.tables.study import TableStudy
from conrod.report.charts.canvas import NORMS, on_grid, on_log_grid, whole_decades
from conrod.report.charts.panels import Curve, error_panel
from conrod.report.charts.styles import HUES, colour, preset_style
from conrod.report.numbers import ROUNDING

MARKERS = 10
LEAST = 1e-5  # of the largest error of a panel: what is below leaves the panel
PANEL, MARGINS = 2.7, 1.3  # heights [inch]
LEGEND = {"fontsize": 7.5, "columnspacing": 1.2, "handlelength": 1.7}


def model_figure(study: ModelStudy) -> Figure:
    """Distance from the exact paths, and below it the errors of the runs, a panel for each quantity."""
    # The model's own run is drawn without what the drive adds to it.
    runs = [study.own, *(run for label, run in study.runs.items() if label not in (OWN, EXACT_SOLVER))]
    drawn = [run for run in runs if run is not None and run.errors is not None]
    count = 1 + (len(QUANTITIES) if drawn else 0)
    figure = Figure(figsize=(9.0, 2.6 * count + 0.6))
    panels = figure.subplots(count, 1, squeeze=False)[:, 0]
    _paths(panels[0], study)
    for axes, quantity in zip(panels[1:], QUANTITIES, strict=False):
        _errors(axes, study, drawn, quantity)
    if drawn:
        panels[-1].set_xlabel("crank angle of the run [deg]")
        handles, labels = panels[1].get_legend_handles_labels()
        panels[1].legend(handles, labels, loc="lower center", ncol=len(labels), bbox_to_anchor=(0.5, 1.0))
    figure.align_ylabels(panels)
    room = 2.6 * count + 0.6
    figure.subplots_adjust(left=0.11, right=0.97, top=1.0 - 0.35 / room, bottom=0.55 / room, hspace=0.42)
    return figure


def _paths(axes: Axes, study: ModelStudy) -> None:
    identity = study.identity
    degrees = np.degrees(np.remainder(identity.angle, 2.0 * np.pi))
    order = np.argsort(degrees)
    off, held = identity.off[order], study.kinematic_tolerance
    axes.plot(on_grid(degrees[order], 360.0), on_log_grid(off), color=colour("mujoco"), linewidth=1.4)
    axes.axhline(held, color="#444444", linewidth=0.9, dashes=(4, 3))
    axes.annotate("held to", (3.0, held), va="bottom", fontsize=8.0, color="#444444")
    whole_decades(axes, [np.maximum(off, ROUNDING), np.array([held])])
    axes.set_xlim(0.0, 360.0)
    axes.xaxis.set_major_locator(MultipleLocator(60.0))
    axes.set_ylabel("off the path / L")
    axes.set_title("crank held: distance from the exact path", loc="left")
    axes.set_xlabel("crank angle [deg]")


def _errors(axes: Axes, study: ModelStudy, runs: list[JudgedRun], quantity: str) -> None:
    curves = [_curve(run, quantity, OWN if run is study.own else run.label) for run in runs]
    error_panel(axes, f"{quantity} / {NORMS[quantity]}", curves, MARKERS)
    axes.set_xlim(0.0, np.copysign(360.0 * study.revolutions, study.scene.speed))
    axes.xaxis.set_major_locator(MultipleLocator(90.0 * max(1, round(study.revolutions / 2.0))))


def _curve(run: JudgedRun, quantity: str, label: str) -> Curve:
    """Crank angle [deg] and the largest error over all points, the largest in each span."""
    assert run.errors is not None
    curves = [errors[quantity] for errors in run.errors.values()]
    peaks = np.max([one.largest for one in curves], axis=0)
    angles = np.degrees(curves[0].at)
    turns = float(np.ptp(angles)) or 360.0
    errors = on_log_grid(np.maximum(peaks, ROUNDING / 10.0))
    style = preset_style("mujoco", label) | {"label": label}
    return on_grid(angles - 360.0 * np.round(angles[0] / 360.0), turns), errors, style


# -- tables ------------------------------------------------------------------------------------------------------------


def error_figure(study: TableStudy) -> Figure:
    """Largest error in each span of the run against the revolutions, a line for each point."""
    # Without a crank angle the error at the angle reached is that at the time.
    named = [q for q in ERRORS if q != "position" or study.crank is not None]
    shown = [q for q in named if any(q in errors for errors in study.errors.values())]
    figure = Figure(figsize=(10.5, PANEL * len(shown) + MARGINS))
    panels = figure.subplots(len(shown), 1, sharex=True, squeeze=False)[:, 0]
    for axes, quantity in zip(panels, shown, strict=True):
        drawn = []
        curves = {point: errors[quantity] for point, errors in study.errors.items() if quantity in errors}
        for (point, curve), hue in zip(curves.items(), cycle(HUES), strict=False):
            drawn.append(on_log_grid(curve.largest))
            axes.plot(on_grid(curve.at, study.revolutions), drawn[-1], label=point, color=hue)
        # A run that starts without error, or crosses zero, does not squeeze the rest together.
        least = LEAST * max(float(error.max()) for error in drawn)
        whole_decades(axes, [np.maximum(error, least) for error in drawn])
        axes.set_ylabel(f"{quantity} error / {NORMS.get(quantity, 'L')}")
        axes.set_xlim(0.0, study.revolutions)
        low, high = axes.get_ylim()
        allowed = study.tolerance.get(quantity)
        if allowed is not None and low < allowed < high:
            level = float(on_log_grid(np.array([allowed]))[0])
            axes.axhline(level, color="#444444", linewidth=0.9, linestyle=":", label="tolerance")
        axes.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncol=6, borderaxespad=0.2, **LEGEND)
    panels[-1].set_xlabel("revolutions since the first row")
    figure.align_ylabels(list(panels))
    height = figure.get_figheight()
    figure.subplots_adjust(left=0.085, right=0.975, top=1.0 - 0.5 / height, bottom=0.6 / height, hspace=0.2)
    return figure
