"""A sheet that a linkage or a polygon is drawn on: in points, to scale, with labels that keep clear of each other."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from conrod.exact.linkage.state import LinkageState
from conrod.exact.motion import Array
from conrod.report.drawing import machine_parts as parts
from conrod.report.drawing.label_placement import LabelPlacement
from conrod.report.drawing.view import View

MARGIN = 46.0  # around the drawing [pt]
LARGEST, LEAST = 400.0, 190.0  # of the drawing's sides [pt]
FONT = 8.5  # [pt]
LETTER = 0.66  # widest usual letter against the font's size
SYMBOL = 8.0  # of a joint [pt]


class Sheet:
    """A drawing of places in a box, to scale.

    Attributes:
        figure, axes: its own; one unit of the axes is one point on paper.
        scale: points for each unit of the places.
        labels: texts and lines that are drawn already.
    """

    def __init__(self, places: Array) -> None:
        """A sheet that holds places (N, 2)."""
        low, high = places.min(axis=0), places.max(axis=0)
        extent = float((high - low).max()) or 1.0
        self.scale = LARGEST / extent
        width, height = (max(LEAST, float(side)) for side in (high - low) * self.scale)
        self._origin = 0.5 * (low + high) - 0.5 * np.array([width, height]) / self.scale
        self.width, self.height = width + 2.0 * MARGIN, height + 2.0 * MARGIN
        self.figure = Figure(figsize=(self.width / 72.0, self.height / 72.0))
        self.axes = self.figure.add_axes((0.0, 0.0, 1.0, 1.0))
        self.axes.set_axis_off()
        self.axes.set_xlim(0.0, self.width)
        self.axes.set_ylim(0.0, self.height)
        self.labels = LabelPlacement(1.0)
        self._labels: list[tuple[Array, str, str, Array | None]] = []

    def at(self, place: Array) -> Array:
        """A place in points from the sheet's lower left corner."""
        return np.asarray((np.asarray(place) - self._origin) * self.scale + MARGIN)

    def holds(self, place: Array) -> bool:
        """True for a place on the drawing's side of the sheet."""
        x, y = self.at(place)
        edge = 0.5 * MARGIN
        return bool(edge <= x <= self.width - edge and edge <= y <= self.height - edge)

    def view(self, state: LinkageState) -> View:
        """The mechanism of a state on this sheet, whose places are in m."""
        poses = {name: link.pose for name, link in state.links.items()}
        one = np.array([poses[body.name] for body in state.mechanism.bodies]).reshape(1, -1)
        x, y = self.at(np.zeros(2))
        return View(self.axes, state.mechanism, poses, one, SYMBOL, self.labels, self.scale, (float(x), float(y)))

    def label(self, points: Array, text: str, colour: str, towards: Array | None = None) -> None:
        """A label beside one of some points (N, 2) on paper, the first if may be; placed when the sheet is finished.

        Args:
            points: where it belongs.
            text: of the label.
            colour: of the text.
            towards: the side (2,) that it had best be on; None for any.
        """
        self._labels.append((np.atleast_2d(points), text, colour, towards))

    def scale_bar(self, unit: str, factor: float = 1.0) -> None:
        """A bar of a round length in the lower left corner; `factor` turns the places' unit into the shown one."""
        longest = 110.0 / self.scale * factor
        power = 10.0 ** math.floor(math.log10(longest))
        length = next(m for m in (5.0, 2.0, 1.0) if m * power <= longest) * power
        stop = 12.0 + length / factor * self.scale
        start, end = np.array([12.0, 12.0]), np.array([stop, 12.0])
        parts.arrow(self.axes, start, end, parts.INK, "|-|,widthA=0.25,widthB=0.25", 1.0)
        self.axes.text(0.5 * (12.0 + stop), 16.0, f"{length:g} {unit}", ha="center", va="bottom", fontsize=FONT)
        right = max(stop, 60.0) + 6.0
        self.labels.take(np.array([(8.0, 6.0), (right, 6.0), (right, 30.0), (8.0, 30.0)]))

    def finished(self) -> Figure:
        """The figure, with its labels."""
        paper = np.array([self.width, self.height])
        for points, text, colour, towards in self._labels:
            x, y = self.labels.beside(points, np.array(_extent(text)), paper, towards)
            self.axes.text(float(x), float(y), text, color=colour, **TEXT)
        return self.figure


# The white ground parts a label from thin lines under it.
TEXT: dict[str, Any] = {
    "ha": "center",
    "va": "center",
    "fontsize": FONT,
    "zorder": 30,
    "bbox": {"facecolor": "white", "edgecolor": "none", "pad": 0.4, "alpha": 0.85},
}


def mathematical(name: str) -> str:
    """The name of a vector or a centre in mathematical letters: V_B/A as V with a lower B/A."""
    if name.startswith("O") and name[1:].replace(",", "").isdigit():
        return f"$O_{{{name[1:]}}}$"
    head, _, lower = name.partition("_")
    quantity, _, upper = head.partition("^")
    # Upright letters, so that they are the mechanism's names and no products.
    lower = lower.replace(" ", r"\ ").replace("_", r"\_").replace("-", r"\text{-}")
    return f"${quantity}^{{{upper}}}_{{\\mathrm{{{lower}}}}}$" if upper else f"${quantity}_{{\\mathrm{{{lower}}}}}$"


def _extent(text: str) -> tuple[float, float]:
    """Width and height [pt] that a label needs."""
    letters = len(text.translate(str.maketrans("", "", "${}^_\\")).replace("mathrm", "").replace("text", ""))
    return LETTER * FONT * letters + 3.0, 1.25 * FONT + (3.0 if "$" in text else 0.0)
