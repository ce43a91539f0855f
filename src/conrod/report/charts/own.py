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
from conrod.report.charts.canvas import NORMS, on_grid, on_log_grid, tolerance_heads, whole_decades
from conrod.report.charts.panels import Curve, error_panel
from conrod.report.charts.styles import HUES, colour, preset_style
from conrod.report.numbers import ROUNDING

PANEL, MARGINS = 2.6, 0.9  # heights [inch]
HEAD = {"color": "#444444", "markerfacecolor": "#444444"}  # of a tolerance


def model_figure(study: ModelStudy) -> Figure:
    """Distance from the exact paths, and below it the errors of the runs, a panel for each quantity."""
    drawn = [run for run in study.runs.values() if run.errors is not None]
    figure, panels = _stacked(1 + (len(QUANTITIES) if drawn else 0))
    _paths(panels[0], study)
    for axes, quantity in zip(panels[1:], QUANTITIES, strict=False):
        error_panel(axes, f"{quantity} / {NORMS[quantity]}", [_curve(run, quantity) for run in drawn])
        axes.set_xlim(0.0, np.copysign(360.0 * study.revolutions, study.scene.speed))
        axes.xaxis.set_major_locator(MultipleLocator(90.0 * max(1, round(study.revolutions / 2.0))))
    return _finished(figure, panels, panels[1 if drawn else 0], "crank angle [deg]")


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
    return _finished(figure, panels, panels[0], "revolutions since the first row")


def _stacked(count: int) -> tuple[Figure, Sequence[Axes]]:
    """A figure of panels above each other."""
    figure = Figure(figsize=(9.0, PANEL * count + MARGINS))
    return figure, list(figure.subplots(count, 1, squeeze=False)[:, 0])


def _finished(figure: Figure, panels: Sequence[Axes], named: Axes, along: str) -> Figure:
    """Line up panels; the legend of one stands above it."""
    panels[-1].set_xlabel(along)
    handles, labels = named.get_legend_handles_labels()
    if handles:
        named.legend(handles, labels, loc="lower right", ncol=len(labels), bbox_to_anchor=(1.0, 1.0))
    figure.align_ylabels(list(panels))
    room = figure.get_figheight()
    figure.subplots_adjust(left=0.11, right=0.97, top=1.0 - 0.5 / room, bottom=0.55 / room, hspace=0.42)
    return figure
