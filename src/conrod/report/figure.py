"""A figure as a value: a name, what it shows in words, and how it is drawn when a file of it is wanted."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from matplotlib.figure import Figure as Canvas

from conrod.report.charts.canvas import drawing_style, svg_text

FOLDER = "figures"


@dataclass(frozen=True)
class Figure:
    """A figure of a report.

    Attributes:
        name: of its file, without suffix.
        alt: what it shows, for those who cannot see it.
        draw: makes it, as a matplotlib figure or as SVG text.
    """

    name: str
    alt: str
    draw: Callable[[], Canvas | str]

    @property
    def file(self) -> str:
        """Name of its file in the report's folder."""
        return f"{FOLDER}/{self.name}.svg"

    def svg(self) -> str:
        """The figure drawn, the same byte for byte wherever that is done."""
        with drawing_style():
            drawn = self.draw()
            return drawn if isinstance(drawn, str) else svg_text(drawn)
