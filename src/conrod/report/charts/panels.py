"""Figures of errors: panels of curves above each other, on logarithmic scales."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from conrod.exact.motion import Array
from conrod.execution.result import JudgedResult
from conrod.report.charts.canvas import (
    add_legend_above,
    draw_tolerance_heads,
    set_decades,
)
from conrod.report.charts.styles import curve_style, label

MARKERS_PER_CURVE = 12  # of a curve
PANEL_HEIGHT, MARGINS = 2.8, 1.05  # of a panel, and of legend and labels [inch]

# Abscissae (N,) and errors (N,), rounded for drawing, and arguments of `Axes.plot`.
ErrorCurve: TypeAlias = tuple[Array, Array, Mapping[str, Any]]


@dataclass(frozen=True)
class Panel:
    """Curves of errors on a logarithmic scale.

    Attributes:
        label: label of the vertical axis.
        curves: the curves.
        ends: ends of the horizontal axis.
        allowed: tolerances with the style of their curves, drawn as arrow heads at the right edge.
    """

    label: str
    curves: Sequence[ErrorCurve]
    ends: tuple[float, float]
    allowed: Sequence[tuple[float | None, Mapping[str, Any]]] = ()


def panels_figure(panels: Sequence[Panel], along: str, ticks: Callable[[Axes], None] = lambda _: None) -> Figure:
    """Draw panels above each other with one legend.

    Args:
        panels: from top to bottom.
        along: label of the horizontal axis.
        ticks: divides the horizontal axis."""
    figure = Figure(figsize=(10.5, PANEL_HEIGHT * len(panels) + MARGINS))
    drawn = figure.subplots(len(panels), 1, squeeze=False)[:, 0]
    named = dict[str, Any]()
    for axes, panel in zip(drawn, panels, strict=True):
        axes.set_xlim(*panel.ends)
        draw_error_panel(axes, panel.label, panel.curves)
        draw_tolerance_heads(axes, panel.ends[1], panel.allowed)
        ticks(axes)
        handles, labels = axes.get_legend_handles_labels()
        named |= dict(zip(labels, handles, strict=True))
    if any(allowed is not None for panel in panels for allowed, _ in panel.allowed):
        look: dict[str, Any] = {"linestyle": "none", "marker": "<", "color": "#444444", "markersize": 6}
        named["tolerance"] = Line2D([], [], label="tolerance", **look)
    drawn[-1].set_xlabel(along)
    figure.align_ylabels(list(drawn))
    add_legend_above(figure, [*named.values()])
    return figure


def draw_error_panel(axes: Axes, label: str, curves: Sequence[ErrorCurve]) -> None:
    """Draw curves of errors on a logarithmic axis, with markers that do not cover each other."""
    for place, (at, values, style) in enumerate(curves):
        every = max(1, len(at) // MARKERS_PER_CURVE)
        # The curves take turns, so that no marker covers another.
        marks = slice((place * every) // len(curves), None, every)
        axes.plot(at, values, markevery=marks, **style)
    set_decades(axes, [values for _, values, _ in curves])
    axes.set_ylabel(label)


def labelled_style(run: JudgedResult) -> dict[str, Any]:
    """Return arguments of `Axes.plot` for a result's curve, with its text in the legend."""
    return curve_style(run) | {"label": label(run)}
