"""A sheet that a linkage or a polygon is drawn on: in points, to scale, with labels that keep clear of each other."""

from __future__ import annotations

import itertools
import math
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from conrod.motion import Array
from conrod.report import machine_parts as parts

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
        """Whether a place is on the drawing's side of the sheet."""
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
        width, height = _extent(text)
        best, cheapest = points[0], math.inf
        for k, ring, direction in itertools.product(range(len(points)), range(RINGS), range(DIRECTIONS)):
            away, reach = parts.unit(direction * 2.0 * math.pi / DIRECTIONS), NEAR + STEP * ring
            centre = points[k] + away * reach + 0.5 * away * np.array([width, height])
            cost = AWAY * reach + self._cost(_box(centre, width, height)) + self._beyond(points[k], centre) + ASIDE * k
            if towards is not None:
                cost += ASIDE * (1.0 - float(away @ towards))
            if cost < cheapest:
                best, cheapest = centre, cost
        self._boxes.append(_box(best, width, height))
        return np.asarray(np.round(best, 2))

    def _beyond(self, point: Array, centre: Array) -> float:
        """Cost of the lines that part a label from its point, which may lie on a line itself."""
        way = centre - point
        start = point + 0.5 * NEAR * way / np.linalg.norm(way)
        return BEYOND_LINE * sum(_cross(segment, np.array([start, centre])) for segment in self._segments)

    def _cost(self, box: tuple[float, float, float, float]) -> float:
        cost = 0.0
        if box[0] < 2.0 or box[1] < 2.0 or box[2] > self.width or box[3] > self.height - 2.0:
            cost += ON_LABEL
        for other in self._boxes:
            if box[0] < other[2] and other[0] < box[2] and box[1] < other[3] and other[1] < box[3]:
                cost += ON_LABEL
        return cost + sum(ON_LINE * _inside(segment, box) for segment in self._segments)


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


def _box(centre: Array, width: float, height: float) -> tuple[float, float, float, float]:
    x, y = centre
    return (x - 0.5 * width, y - 0.5 * height, x + 0.5 * width, y + 0.5 * height)


def _inside(segment: Array, box: tuple[float, float, float, float]) -> float:
    """Length [pt] of a segment inside a box (Liang and Barsky's clipping)."""
    (x, y), (dx, dy) = segment[0], segment[1] - segment[0]
    enter, leave = 0.0, 1.0
    for rate, room in ((-dx, x - box[0]), (dx, box[2] - x), (-dy, y - box[1]), (dy, box[3] - y)):
        if rate == 0.0:
            if room < 0.0:
                return 0.0
        elif rate < 0.0:
            enter = max(enter, room / rate)
        else:
            leave = min(leave, room / rate)
    return max(0.0, leave - enter) * math.hypot(dx, dy)


def _cross(first: Array, second: Array) -> bool:
    """Whether two segments cross."""

    def side(segment: Array, point: Array) -> float:
        (x, y), (dx, dy) = point - segment[0], segment[1] - segment[0]
        return float(dx * y - dy * x)

    return all(side(one, other[0]) * side(one, other[1]) < 0.0 for one, other in ((first, second), (second, first)))
