"""The figure of motion: the exact motion of the output point, its extremes, and samples of the runs."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import MaxNLocator, MultipleLocator

from conrod.exact.motion import Array
from conrod.report.charts.canvas import add_legend_above, round_to_grid
from conrod.report.charts.panels import MARGINS, labelled_style
from conrod.studies.validation.motion_curves import COMPONENTS, PAGE_UNITS, DrawnTurn, ExactCurve, marked_runs
from conrod.studies.validation.results import SceneStudy, ValidationResult

PANEL_HEIGHT, LOW_PANEL_HEIGHT = 1.9, 1.45  # [inch]; the lower where x and y both move
DRAWN_EVERY = 4  # exact sample, by which the drawn line is less than its own width off
ROOM, MAX_ROOM = 0.10, 0.30  # shares of the span beyond the exact motion, empty and for marks
LINE: dict[str, Any] = {"color": "#222222", "linewidth": 1.0}
DOTS: dict[str, Any] = {"color": "#222222", "linestyle": "none", "marker": "o", "markersize": 3.5, "zorder": 9}


def motion_figure(study: SceneStudy) -> Figure:
    """Draw the exact motion of the output point over a turn, with marks of samples of the runs.

    A panel for each quantity and component that moves, since the scales of x and y may be far apart.
    """
    turn, runs = DrawnTurn.from_study(study), marked_runs(study)
    shown = [(quantity, curve) for quantity, curves in turn.curves.items() for curve in curves]
    height = PANEL_HEIGHT if len(shown) == len(turn.curves) else LOW_PANEL_HEIGHT
    figure = Figure(figsize=(10.5, height * len(shown) + MARGINS))
    panels = figure.subplots(len(shown), 1, sharex=True)
    for axes, (quantity, curve) in zip(panels, shown, strict=True):
        _draw_panel(axes, turn, quantity, curve, runs)
    first, last = turn.printed_ends
    panels[0].set_xlim(first, last)
    whole = abs(last - first) >= 180.0
    panels[0].xaxis.set_major_locator(MultipleLocator(30.0) if whole else MaxNLocator(8, steps=[1, 2, 3, 5, 10]))
    panels[-1].set_xlabel("crank angle [deg]")
    figure.align_ylabels(list(panels))
    exact = [Line2D([], [], label="exact", **LINE), Line2D([], [], label="extreme", **DOTS)]
    add_legend_above(figure, exact + [Line2D([], [], **_mark_style(run)) for run in runs])
    return figure


def _mark_style(run: ValidationResult) -> dict[str, Any]:
    return labelled_style(run) | {"linestyle": "none"}


def _draw_panel(axes: Axes, turn: DrawnTurn, quantity: str, curve: ExactCurve, runs: list[ValidationResult]) -> None:
    """Draw an exact curve, its extremes, and the samples of all runs; distant samples are drawn on the edge."""
    values = np.concatenate([values for _, values in curve.pieces])
    low, high = float(values.min()), float(values.max())
    span = high - low if high - low > curve.noise else max(abs(high), 1.0)
    axes.plot(*_joined_pieces(turn, curve, span), **LINE)
    at, extreme = np.array(curve.extremes).T
    axes.plot(_degrees(turn, at), round_to_grid(extreme, span), **DOTS)
    for run in runs:
        degrees, sampled = _samples(run, turn, quantity)
        seen = np.clip(sampled[curve.component], values.min() - MAX_ROOM * span, values.max() + MAX_ROOM * span)
        low, high = float(seen.min(initial=low)), float(seen.max(initial=high))
        axes.plot(degrees, round_to_grid(seen, span), **_mark_style(run))
    axes.set_ylim(*round_to_grid(np.array([low - ROOM * span, high + ROOM * span]), 100.0 * span))
    axes.set_ylabel(f"{quantity}\n{COMPONENTS[curve.component]} [{PAGE_UNITS[quantity][0]}]")
    axes.set_title(curve.words(turn.whole), loc="left", fontsize=8.5)


def _joined_pieces(turn: DrawnTurn, curve: ExactCurve, span: float) -> tuple[Array, Array]:
    """Return crank angles [deg] and values of a curve for drawing, with a gap at each break."""
    gap = np.array([math.nan])
    drawn = []
    for angles, values in curve.pieces:
        some = np.unique(np.append(np.arange(0, len(angles), DRAWN_EVERY), len(angles) - 1))
        drawn += [(_degrees(turn, angles[some]), round_to_grid(values[some], span)), (gap, gap)]
    at, heights = zip(*drawn[:-1], strict=True)
    return np.concatenate(at), np.concatenate(heights)


def _degrees(turn: DrawnTurn, angles: Array) -> Array:
    """Return crank angles [deg] without the whole turns before, rounded for drawing."""
    return round_to_grid(np.degrees(angles - turn.whole), 360.0)


def _samples(run: ValidationResult, turn: DrawnTurn, quantity: str) -> tuple[Array, Array]:
    """Return crank angles [deg] and values (2, K) of a run's samples, in the unit of a page; none for the jerk."""
    if not run.samples or quantity not in run.samples:
        return np.empty(0), np.empty((len(COMPONENTS), 0))
    found = run.samples[quantity]
    return _degrees(turn, found.angle), PAGE_UNITS[quantity][1] * np.array([found.x, found.y])
