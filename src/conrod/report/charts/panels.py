"""Panels of runs above each other: curves that take turns with their markers, errors over whole decades."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, TypeAlias

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import Locator, MaxNLocator, MultipleLocator

from conrod.exact.motion import Array
from conrod.report.charts.canvas import legend_above, whole_decades

MARKERS = 12  # of a curve
MARGINS = {"left": 0.095, "right": 0.97, "top": 0.93, "bottom": 0.06, "hspace": 0.13}

# Places and values (N,) on the grid that is drawn, and arguments of `Axes.plot`.
Curve: TypeAlias = tuple[Array, Array, Mapping[str, Any]]


def draw_curves(axes: Axes, curves: Sequence[Curve], most: int = MARKERS, tail: int = 0) -> None:
    """Draw curves whose markers stand clear of each other.

    Args:
        most: markers of a curve, about.
        tail: last samples of a curve that get no marker.
    """
    for place, (at, values, style) in enumerate(curves):
        every = max(1, len(at) // most)
        # The curves take turns, so that no marker covers another.
        marks = slice(2 + (place * every) // len(curves), len(at) - tail if tail else None, every)
        axes.plot(at, values, markevery=marks, **style)


def error_panel(axes: Axes, label: str, curves: Sequence[Curve], most: int = MARKERS, tail: int = 0) -> None:
    """Draw curves of errors on a logarithmic axis that holds them all."""
    draw_curves(axes, curves, most, tail)
    whole_decades(axes, [values for _, values, _ in curves])
    axes.set_ylabel(label)


def finish_panels(figure: Figure, panels: Sequence[Axes], handles: Sequence[Any] = (), **margins: float) -> Figure:
    """Line up panels, and set the legend of the first above them, with some more handles that have labels."""
    own, labels = panels[0].get_legend_handles_labels()
    figure.align_ylabels(list(panels))
    figure.subplots_adjust(**(MARGINS | margins))
    legend_above(figure, [*own, *handles], [*labels, *(str(one.get_label()) for one in handles)])
    return figure


def angle_ticks(degrees: float, step: float = 90.0) -> Locator:
    """Return steps of a turn; of less than half a turn whatever divides it well."""
    return MultipleLocator(step) if degrees >= 180.0 else MaxNLocator(8, steps=[1, 2, 3, 5, 10])
