"""A figure as a value: its name, a text alternative, the function that draws it, and its spots.

A spot is a place in a figure with words that a page shows there: under the pointer, or by a slider for the keyboard.
"""

from __future__ import annotations

import base64
import json
import zlib
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from itertools import zip_longest
from typing import TYPE_CHECKING, TypeAlias

from conrod.report.table import safe_svg

if TYPE_CHECKING:  # matplotlib is loaded when a figure is drawn
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure as Canvas

FOLDER = "figures"
# Shares of the figure's width and height from its upper left corner, and words; lines after the first are to be copied.
Spot: TypeAlias = tuple[float, float, str]


def no_spots(_: Canvas) -> Iterable[Spot]:
    """Return no spot, for a figure that has none."""
    return ()


@dataclass(frozen=True)
class Figure:
    """A figure of a report.

    Attributes:
        name: name of its file, without suffix.
        alt: its content in words, for readers who cannot see it.
        draw: draws it, as a matplotlib figure or as SVG text.
        spots: returns the spots of the drawn figure.
    """

    name: str
    alt: str
    draw: Callable[[], Canvas | str]
    spots: Callable[[Canvas], Iterable[Spot]] = no_spots

    @property
    def file(self) -> str:
        """Name of its file in the report's folder."""
        return f"{FOLDER}/{self.name}.svg"

    def svg(self) -> str:
        """Draw the figure as SVG, the same byte for byte on every machine."""
        from conrod.report.charts.canvas import drawing_style, svg_text

        with drawing_style():
            drawn = self.draw()
            return safe_svg(drawn if isinstance(drawn, str) else svg_text(drawn))

    def laid_out_spots(self) -> list[Spot]:
        """Draw and lay out the figure, and return its spots; a figure without spots is not drawn."""
        if self.spots is no_spots:
            return []
        from conrod.report.charts.canvas import drawing_style

        with drawing_style():
            drawn = self.draw()
            if isinstance(drawn, str):
                return []
            if (layout := drawn.get_layout_engine()) is None:
                drawn.draw_without_rendering()
            else:  # places are known without what is drawn there
                layout.execute(drawn)
            return list(self.spots(drawn))


def spots_in_axes(figure: Canvas, axes: Axes, places: Iterable[Spot]) -> list[Spot]:
    """Return spots for places in data units of some axes, without the places outside the axes."""
    width, height = figure.bbox.width, figure.bbox.height
    found = []
    for x, y, words in places:
        across, up = axes.transData.transform((x, y))
        if axes.bbox.contains(across, up):
            found.append((round(across / width, 4), round(1.0 - up / height, 4), words))
    return found


def with_spots(figure: str, spots: Sequence[Spot]) -> str:
    """Return a figure's HTML with its spots from left to right, as compressed JSON columns."""
    columns = list(zip_longest(*((x, y, *words.split(", ")) for x, y, words in sorted(spots))))
    data = base64.b64encode(zlib.compress(json.dumps(columns, separators=(",", ":")).encode(), 9)).decode()
    return f'<span class="spots">{figure}<script type="application/octet-stream">{data}</script></span>'
