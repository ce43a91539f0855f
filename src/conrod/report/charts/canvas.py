"""Drawing style, axes and legends of figures that are the same, byte for byte, on every machine.

Fonts are drawn as paths: GitHub shows an SVG as an image, in which text would be set in whatever font the reader's
machine has, with other widths than those the labels were laid out for.
"""

from __future__ import annotations

import io
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any

import matplotlib.style
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.text import Text

from conrod.exact.motion import Array
from conrod.report.charts.compact import compact_svg
from conrod.report.charts.styles import preset_style, preset_title
from conrod.report.numbers import ROUNDING
from conrod.report.table import visible_text

STYLE: dict[str, Any] = {
    "svg.hashsalt": "conrod",
    "svg.fonttype": "none",
    "font.family": "DejaVu Sans",
    "mathtext.fontset": "dejavusans",
    "font.size": 9.0,
    "axes.titlesize": 10.0,
    "axes.labelsize": 9.0,
    "legend.fontsize": 8.5,
    "axes.grid": True,
    "grid.color": "#e4e4e4",
    "grid.linewidth": 0.6,
    "axes.axisbelow": True,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.edgecolor": "#666666",
    "axes.formatter.useoffset": False,
    "lines.solid_capstyle": "round",
    "legend.frameon": False,
    "figure.constrained_layout.use": True,
    # Simplification drops points by comparing floats, which the last bit of a value can decide.
    "path.simplify": False,
}

# Share of a grid step. On a grid of round numbers, round values such as degrees could lie midway between two points.
GRID_OFFSET = 0.137


@contextmanager
def drawing_style() -> Iterator[None]:
    """Draw with matplotlib's defaults and `STYLE`, not with the user's matplotlibrc."""
    with matplotlib.style.context(["default", STYLE]):
        yield


def svg_text(figure: Figure) -> str:
    """Return a figure as SVG, without date, version or digits beyond a hundredth of a point."""
    stream = io.StringIO()
    for label in figure.findobj(Text):
        if label.get_text() != (shown := visible_text(label.get_text())):
            label.set_text(shown)
    figure.savefig(stream, format="svg", metadata={"Date": None, "Creator": None})
    return "\n".join(line.rstrip() for line in compact_svg(stream.getvalue()).splitlines()) + "\n"


def round_to_grid(values: Array, span: float) -> Array:
    """Round values to 1e-4 of their axis's span, which hides their last bits."""
    step = 10.0 ** np.floor(np.log10(span * 1e-4)) if span > 0.0 else 1.0
    return np.asarray(np.rint(values / step + GRID_OFFSET) * step)


def round_to_log_grid(errors: Array) -> Array:
    """Round errors to 0.01 in their decimal logarithm, and raise smaller ones to `ROUNDING`."""
    logarithm = np.log10(np.maximum(np.asarray(errors, dtype=float), ROUNDING))
    return np.asarray(10.0 ** (np.rint(logarithm * 100.0) / 100.0))


def set_decades(axes: Axes, errors: list[Array]) -> None:
    """Give axes a log scale over whole decades that holds all errors, and shade rounding noise."""
    largest = max((float(e.max()) for e in errors if e.size), default=1.0)
    smallest = min((float(e.min()) for e in errors if e.size), default=ROUNDING)
    # A hair of tolerance keeps an error that lies on a decade from opening another one.
    top = int(np.ceil(np.log10(largest) - 1e-6))
    bottom = min(int(np.floor(np.log10(smallest) + 1e-6)), top - 2)
    floor = round(np.log10(ROUNDING))
    noise = bottom <= floor
    axes.set_yscale("log")
    # A little room at both ends, so that no marker is cut in half.
    room = 0.05 * (top - bottom)
    axes.set_ylim(10.0 ** (floor - 0.6 if noise else bottom - room), 10.0 ** (top + room))
    every = max(1, -(-(top - bottom) // 6))
    named = range(top, (floor if noise else bottom) - 1, -every)
    axes.set_yticks([10.0**k for k in named], [f"1e{k}" for k in named])
    axes.minorticks_off()
    if noise:
        axes.axhspan(10.0 ** (floor - 0.6), ROUNDING, color="#eeeeee", zorder=0, linewidth=0)
        axes.annotate(
            "rounding",
            (0.995, 10.0 ** (floor - 0.3)),
            xycoords=("axes fraction", "data"),
            ha="right",
            va="center",
            fontsize=7.5,
            color="#777777",
        )


def add_legend_above(figure: Figure, handles: Sequence[Any], columns: int = 9, **style: Any) -> None:
    """Add a legend above all panels of a figure, of at most `columns` columns."""
    columns = min(len(handles), columns)
    figure.legend(handles=handles, loc="outside upper center", ncols=columns, **{"handlelength": 3.2, **style})


def draw_tolerance_heads(axes: Axes, at: float, allowed: Sequence[tuple[float | None, Mapping[str, Any]]]) -> None:
    """Draw an arrow head at each tolerance that lies within the panel, in its curve's style."""
    low, high = axes.get_ylim()
    for tolerance, style in allowed:
        if tolerance is not None and low < tolerance < high:
            axes.plot(
                [at], round_to_log_grid(np.array([tolerance])), linestyle="none", marker="<", markersize=7,
                color=style["color"], markerfacecolor=style["markerfacecolor"], clip_on=False, zorder=6,
            )  # fmt: skip


# -- parts that the charts of all reports share ------------------------------------------------------------------------

# Divisors of the errors of each quantity, as printed in labels of axes.
NORMS = {
    "position": "L", "velocity": "(ω L)", "acceleration": "(ω² L)",
    "rotation": "range R", "angular_velocity": "(ω R)", "angular_acceleration": "(ω² R)",
}  # fmt: skip


def preset_handles(presets: Iterable[tuple[str, str]], **changes: Any) -> list[Line2D]:
    """Return legend entries of engines and presets, in the styles of their curves."""
    return [Line2D([], [], label=preset_title(*one), **(preset_style(*one) | changes)) for one in presets]


def set_rows(axes: Axes, names: Sequence[str], room: float = 0.5) -> None:
    """Give the vertical axis a row for each name, from top to bottom."""
    axes.set_yticks(range(len(names)), names)
    axes.set_ylim(len(names) - room, room - 1.0)


def set_log_axis(
    axes: Axes, ends: tuple[float, float], ticks: Iterable[float] | None = None, names: Sequence[str] | None = None
) -> None:
    """Give the horizontal axis a logarithmic scale between two ends, with given ticks."""
    axes.set_xscale("log")
    axes.set_xlim(*ends)
    if ticks is not None:
        axes.set_xticks(list(ticks), names)
    axes.minorticks_off()
