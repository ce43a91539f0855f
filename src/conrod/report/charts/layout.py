"""Parts that the charts of all reports share: figures laid out in inches, legends, and axes of rows and decades."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from conrod.report.charts.styles import preset_style, preset_title

# The divisors of the errors of a quantity, as labels of axes have them.
NORMS = {"position": "L", "velocity": "(ω L)", "acceleration": "(ω² L)"}
STEPS = "steps per revolution N (step of the crank angle h = 2π / N)"
MOST_STEPS = 10  # named on an axis


class Layout:
    """A figure whose parts are placed in inches from its lower left corner.

    Attributes:
        figure: that is laid out.
        width, height: of the figure [inch].
    """

    def __init__(self, width: float, height: float) -> None:
        """Return an empty figure of a width and height [inch]."""
        self.figure, self.width, self.height = Figure(figsize=(width, height)), width, height

    def axes(self, left: float, bottom: float, wide: float, tall: float) -> Axes:
        """Return new axes with their lower left corner at a place, and of a size [inch]."""
        w, h = self.width, self.height
        return self.figure.add_axes((left / w, bottom / h, wide / w, tall / h))

    def legend(self, handles: Sequence[Any], columns: int, edge: float = 0.03, **style: Any) -> None:
        """One legend for all panels, so many columns wide and `edge` [inch] below the upper edge."""
        at, columns = (0.5, 1.0 - edge / self.height), min(len(handles), columns)
        self.figure.legend(handles=handles, loc="upper center", ncol=columns, bbox_to_anchor=at, **style)


def legend_rows(handles: Sequence[Any], columns: int) -> int:
    """Return the number of rows of a legend."""
    return -(-len(handles) // columns)


def preset_handles(presets: Iterable[tuple[str, str]], **changes: Any) -> list[Line2D]:
    """Return legend entries of engines and presets, in the styles of their curves with some changes."""
    return [Line2D([], [], label=preset_title(*one), **(preset_style(*one) | changes)) for one in presets]


def rows_axis(axes: Axes, names: Sequence[str], room: float = 0.5) -> None:
    """Give the vertical axis a row for each name, from the top down."""
    axes.set_yticks(range(len(names)), names)
    axes.set_ylim(len(names) - room, room - 1.0)


def log_axis(
    axes: Axes, ends: tuple[float, float], ticks: Iterable[float] | None = None, names: Sequence[str] | None = None
) -> None:
    """Give the horizontal axis a logarithmic scale between two ends, with ticks at some values alone."""
    axes.set_xscale("log")
    axes.set_xlim(*ends)
    if ticks is not None:
        axes.set_xticks(list(ticks), names)
    axes.minorticks_off()


def steps_axis(axes: Axes, steps: Sequence[int], room: float) -> None:
    """Give the horizontal axis numbers of steps per revolution in rising order; `room` is a factor beside the ends."""
    if steps:
        shown = steps[:: -(-len(steps) // MOST_STEPS)]
        log_axis(axes, (steps[0] / room, steps[-1] * room), shown, [str(n) for n in shown])
    axes.set_xlabel(STEPS)
