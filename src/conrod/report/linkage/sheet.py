"""A sheet that a linkage or a polygon is drawn on: in points, to scale, with labels that keep clear of each other."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from conrod.exact.motion import Array
from conrod.report.drawing import machine_parts as parts

MARGIN, COLUMN = 46.0, 224.0  # around the drawing, and for the text beside it [pt]
LARGEST, LEAST = 400.0, 190.0  # of the drawing's sides [pt]
FONT, LINE = 8.5, 14.0  # [pt]
LETTER = 0.66  # widest usual letter against the font's size
NEAR, STEP, RINGS, DIRECTIONS = 4.0, 5.0, 8, 24  # where a label may be tried around its point [pt]
# What the place of a label costs: on another label, a point of it on a line, beyond a line, away from where it belongs,
# on another side or at another place than the best.
ON_LABEL, ON_LINE, BEYOND_LINE, AWAY, ASIDE = 400.0, 6.0, 40.0, 1.0, 8.0


class Sheet:
    """A drawing of places in a box, to scale.

    Attributes:
        figure, axes: its own; one unit of the axes is one point on paper.
        scale: points for each unit of the places.
    """

    def __init__(self, places: Array, lines: int = 0) -> None:
        """A sheet that holds places (N, 2), with a column for some lines of text on its right."""
        low, high = places.min(axis=0), places.max(axis=0)
        extent = float((high - low).max()) or 1.0
        self.scale = LARGEST / extent
        width, height = (max(LEAST, float(side)) for side in (high - low) * self.scale)
        height = max(height, LINE * lines + 20.0 - MARGIN)
        self._origin = 0.5 * (low + high) - 0.5 * np.array([width, height]) / self.scale
        self.width, self.height = width + 2.0 * MARGIN, height + 2.0 * MARGIN
        whole = self.width + (COLUMN if lines else 0.0)
        self.figure = Figure(figsize=(whole / 72.0, self.height / 72.0))
        self.axes = self.figure.add_axes((0.0, 0.0, 1.0, 1.0))
        self.axes.set_axis_off()
        self.axes.set_xlim(0.0, whole)
        self.axes.set_ylim(0.0, self.height)
        self._boxes: list[tuple[float, float, float, float]] = []
        self._segments: list[Array] = []
        self._labels: list[tuple[Array, str, str, Array | None]] = []

    def at(self, place: Array) -> Array:
        """A place in points from the sheet's lower left corner."""
        return np.asarray((np.asarray(place) - self._origin) * self.scale + MARGIN)

    def holds(self, place: Array) -> bool:
        """True for a place on the drawing's side of the sheet."""
        x, y = self.at(place)
        edge = 0.5 * MARGIN
        return bool(edge <= x <= self.width - edge and edge <= y <= self.height - edge)

    def keep_clear(self, start: Array, stop: Array) -> None:
        """Labels avoid a line between two points on paper."""
        self._segments.append(np.array([start, stop]))

    def keep_off(self, point: Array, radius: float) -> None:
        """Labels avoid a mark at a point on paper [pt]."""
        self._boxes.append((point[0] - radius, point[1] - radius, point[0] + radius, point[1] + radius))

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
        self._boxes.append((8.0, 6.0, max(stop, 60.0) + 6.0, 30.0))

    def column(self, title: str, rows: list[tuple[str, str]]) -> None:
        """Lines of text on the right: a name and what it is."""
        x, y = self.width + 4.0, self.height - 18.0
        self.axes.text(x, y, title, fontsize=FONT, fontweight="bold", va="center")
        aside = max(_extent(name)[0] for name, _ in rows)
        for k, (name, text) in enumerate(rows):
            line = y - LINE * (k + 1.2)
            self.axes.text(x, line, name, fontsize=FONT, va="center")
            self.axes.text(x + aside, line, text, fontsize=FONT - 0.5, va="center", color="#333333")

    def finished(self) -> Figure:
        """The figure, with its labels."""
        for points, text, colour, towards in self._labels:
            centre = self._free_place(points, text, towards)
            self.axes.text(float(centre[0]), float(centre[1]), text, color=colour, **TEXT)
        return self.figure

    def _free_place(self, points: Array, text: str, towards: Array | None) -> Array:
        """The centre of the cheapest of all places around a label's points."""
        extent = np.array(_extent(text))
        turns = np.arange(DIRECTIONS) * 2.0 * math.pi / DIRECTIONS
        k, ring, turn = (grid.ravel() for grid in np.meshgrid(range(len(points)), range(RINGS), turns, indexing="ij"))
        away, reach = np.column_stack([np.cos(turn), np.sin(turn)]), NEAR + STEP * ring
        starts = points[k] + 0.5 * NEAR * away
        centres = points[k] + away * reach[:, None] + 0.5 * away * extent
        cost = AWAY * reach + ASIDE * k + self._cost(centres - 0.5 * extent, centres + 0.5 * extent)
        # What parts a label from its point, which may lie on a line itself.
        cost += BEYOND_LINE * sum(_crossed(segment, starts, centres) for segment in self._segments)
        if towards is not None:
            cost += ASIDE * (1.0 - away @ towards)
        # Rounded, so that the last bit of a cost does not choose between two places.
        best = np.round(centres[int(np.round(cost, 6).argmin())], 2)
        self._boxes.append((*(best - 0.5 * extent), *(best + 0.5 * extent)))
        return np.asarray(best)

    def _cost(self, low: Array, high: Array) -> Array:
        """Of boxes with corners (C, 2) on other labels, on lines and off the paper; (C,)."""
        paper = np.array([self.width, self.height]) - 2.0
        cost = ON_LABEL * np.any((low < 2.0) | (high > paper), axis=1)
        for x0, y0, x1, y1 in self._boxes:
            cost = cost + ON_LABEL * np.all((low < (x1, y1)) & (high > (x0, y0)), axis=1)
        for segment in self._segments:
            cost = cost + ON_LINE * _inside(segment, low, high)
        return np.asarray(cost, dtype=float)


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


def _inside(segment: Array, low: Array, high: Array) -> Array:
    """Lengths (C,) [pt] of a segment inside boxes with corners (C, 2), by clipping it at their sides."""
    way = segment[1] - segment[0]
    enter, leave = np.zeros(len(low)), np.ones(len(low))
    for k in range(2):
        if abs(way[k]) < 1e-9:
            leave = np.where((segment[0, k] < low[:, k]) | (segment[0, k] > high[:, k]), 0.0, leave)
        else:
            ends = (np.stack([low[:, k], high[:, k]]) - segment[0, k]) / way[k]
            enter, leave = np.maximum(enter, ends.min(axis=0)), np.minimum(leave, ends.max(axis=0))
    return np.asarray(np.maximum(0.0, leave - enter) * np.linalg.norm(way))


def _crossed(segment: Array, starts: Array, stops: Array) -> NDArray[np.bool_]:
    """Crossings (C,) of a segment by ways from starts to stops, (C, 2) each."""
    way, ways = segment[1] - segment[0], stops - starts

    def side(along: Array, arm: Array) -> Array:
        return np.asarray(along[..., 0] * arm[..., 1] - along[..., 1] * arm[..., 0])

    apart = side(way, starts - segment[0]) * side(way, stops - segment[0]) < 0.0
    return np.asarray(apart & (side(ways, segment[0] - starts) * side(ways, segment[1] - starts) < 0.0))
