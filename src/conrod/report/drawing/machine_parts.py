"""Symbols of a mechanism's drawing, and the search for room for its texts; lengths in mm."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Circle, FancyArrowPatch, Polygon
from matplotlib.path import Path
from numpy.typing import NDArray

from conrod.exact.motion import Array
from conrod.mechanism.mechanism import Point

INK, FRAME, LINK = "#222222", "#777777", "#7d97ab"
TEXT_STYLE: dict[str, Any] = {"fontsize": 8.0, "zorder": 20}
TEXT_GROUND: dict[str, Any] = {"facecolor": "white", "edgecolor": "none", "pad": 0.8, "alpha": 0.85}


def unit_vector(direction: float) -> Array:
    """Return the unit vector (2,) of a direction [rad]."""
    return np.array([math.cos(direction), math.sin(direction)])


def draw_slot(axes: Axes, ends: Array, size: float) -> None:
    """Draw a slot of a moving link between two ends (2, 2), without the frame's hatching."""
    along = (ends[1] - ends[0]) / np.linalg.norm(ends[1] - ends[0])
    left = 1.15 * size * np.array([-along[1], along[0]])
    corners = np.array([ends[0] - left, ends[1] - left, ends[1] + left, ends[0] + left])
    axes.add_patch(Polygon(corners, facecolor="white", edgecolor=LINK, linewidth=2.5, joinstyle="round", zorder=4.5))


def draw_pin(axes: Axes, centre: Point, size: float) -> None:
    """Draw a revolute joint."""
    axes.add_patch(Circle(centre, 0.35 * size, facecolor="white", edgecolor=INK, linewidth=1.2, zorder=8))


def draw_bearing(axes: Axes, centre: Point, size: float) -> None:
    """Draw a shaft's bearing on the frame: a foot with hatching under it."""
    x, y = centre
    foot = [(x, y), (x - 0.9 * size, y - 1.4 * size), (x + 0.9 * size, y - 1.4 * size)]
    axes.add_patch(Polygon(foot, facecolor="#f2f2f2", edgecolor=FRAME, linewidth=1.0, zorder=3))
    draw_hatching(axes, np.array([x - 1.5 * size, y - 1.4 * size]), np.array([x + 1.5 * size, y - 1.4 * size]), size)


def draw_hatching(axes: Axes, start: Array, stop: Array, size: float) -> None:
    """Draw a line of the fixed frame, hatched on its right as seen from start to stop."""
    along = (stop - start) / np.linalg.norm(stop - start)
    right = np.array([along[1], -along[0]])
    axes.plot(*np.array([start, stop]).T, color=FRAME, linewidth=1.0, zorder=3)
    spacing = 0.5 * size
    for k in range(int(np.linalg.norm(stop - start) / spacing) + 1):
        top = start + k * spacing * along
        axes.plot(*np.array([top, top + 0.5 * size * (right - along)]).T, color=FRAME, linewidth=0.7, zorder=3)


def draw_rails(axes: Axes, centre: Array, reach: tuple[float, float], direction: float, size: float) -> None:
    """Draw two rails from reach[0] to reach[1] along a direction [rad] through a point."""
    along = unit_vector(direction)
    left = np.array([-along[1], along[0]])
    near, far = centre + reach[0] * along, centre + reach[1] * along
    draw_hatching(axes, far + 1.15 * size * left, near + 1.15 * size * left, size)
    draw_hatching(axes, near - 1.15 * size * left, far - 1.15 * size * left, size)


def draw_slider(axes: Axes, centre: Array, direction: float, size: float) -> None:
    """Draw a block on its slide."""
    along = unit_vector(direction)
    left = np.array([-along[1], along[0]])
    corners = [centre + size * (a * 1.5 * along + b * left) for a, b in ((1, 1), (-1, 1), (-1, -1), (1, -1))]
    axes.add_patch(Polygon(corners, facecolor="#dde6ec", edgecolor=INK, linewidth=1.0, zorder=5))


def draw_arrow(axes: Axes, start: Array, stop: Array, colour: str, style: str = "-|>", width: float = 1.0) -> None:
    """Draw a straight arrow."""
    ends = (float(start[0]), float(start[1])), (float(stop[0]), float(stop[1]))
    look: dict[str, Any] = {"arrowstyle": style, "mutation_scale": 8, "color": colour, "linewidth": width}
    axes.add_patch(FancyArrowPatch(*ends, shrinkA=0, shrinkB=0, zorder=10, **look))


def draw_turn_arrow(axes: Axes, centre: Array, radius: float, start: float, stop: float, colour: str) -> None:
    """Draw an arc from one direction [rad] to another, with an arrow head at its end."""
    angles = np.linspace(start, stop, 60)
    points = centre + radius * np.column_stack([np.cos(angles), np.sin(angles)])
    axes.plot(*points[:-2].T, color=colour, linewidth=1.0, zorder=9)
    draw_arrow(axes, points[-4], points[-1], colour)


def draw_note(
    axes: Axes, at: Array, text: str, colour: str, rotation: float = 0.0, look: Mapping[str, Any] = TEXT_STYLE
) -> None:
    """Draw a text centred on a point, on a white ground, rotated by an angle [deg]."""
    x, y = at
    style = {**TEXT_STYLE, **look, "color": colour, "rotation": rotation, "bbox": TEXT_GROUND}
    axes.text(float(x), float(y), text, ha="center", va="center", **style)


# -- room for texts ----------------------------------------------------------------------------------------------------


LETTER_WIDTH, LINE_HEIGHT = 0.6, 1.5  # with its white ground, as shares of the font's size
SAMPLE_SPACING = 3.0  # between sample points of drawn texts, lines and plates [pt]
# Cost of a sample point under a text, and the share of it under a line that belongs to the text. A drawn line costs
# little, for the white ground of the text above it keeps it readable.
ON_TEXT_COST, ON_PLATE_COST, ON_LINE_COST, UNDER_LINE_SHARE = 5.0, 0.6, 1.0, 0.3
NEXT_WISH_COST = 1.0  # of the next place in the list of wishes


@dataclass(frozen=True)
class Box:
    """A rectangle in the drawing: centre (2,), half its width and height, angle [rad]."""

    centre: Array
    half: tuple[float, float]
    angle: float = 0.0

    def contains(self, points: Array) -> NDArray[np.bool_]:
        """Return True (N,) for the points (N, 2) in the rectangle."""
        cos, sin = math.cos(self.angle), math.sin(self.angle)
        own = (points - self.centre) @ np.array([[cos, -sin], [sin, cos]])
        return np.asarray((np.abs(own) <= self.half).all(axis=1))

    def samples(self, spacing: float) -> Array:
        """Return points (N, 2) all over the rectangle, its edges included."""
        x, y = (np.linspace(-half, half, 2 + int(2.0 * half / spacing)) for half in self.half)
        own = np.column_stack([grid.ravel() for grid in np.meshgrid(x, y)])
        cos, sin = math.cos(self.angle), math.sin(self.angle)
        return np.asarray(self.centre + own @ np.array([[cos, sin], [-sin, cos]]))


class Labels:
    """Sample points of the texts, lines and plates drawn so far; lengths in mm."""

    def __init__(self, point: float) -> None:
        """Start with an empty drawing; `point` is the length of one typographic point [mm]."""
        self.point, self._spacing = point, SAMPLE_SPACING * point
        self._points, self._costs = [np.empty((0, 2))], [np.empty(0)]

    def width(self, text: str, size: float) -> float:
        """Estimate the width of a text in a font size [pt]."""
        return LETTER_WIDTH * size * len(text) * self.point

    def box(self, centre: Array, text: str, size: float, angle: float = 0.0) -> Box:
        """Return the rectangle of a text, for its font size [pt], centre (2,) and angle [rad]."""
        return Box(centre, (0.5 * self.width(text, size), 0.5 * LINE_HEIGHT * size * self.point), angle)

    def add_text(self, box: Box) -> None:
        """Record a text or a symbol."""
        self._add_samples(box.samples(self._spacing), ON_TEXT_COST)

    def add_symbol(self, centre: Array, radius: float) -> None:
        """Record a symbol."""
        self.add_text(Box(centre, (radius, radius)))

    def add_plate(self, plate: Array) -> None:
        """Record a plate with corners (N, 2)."""
        low, high = plate.min(axis=0), plate.max(axis=0)
        reach = 0.5 * (high - low)
        points = Box(low + reach, (float(reach[0]), float(reach[1]))).samples(self._spacing)
        self._add_samples(points[Path(plate).contains_points(points)], ON_PLATE_COST)

    def add_line(self, line: Array) -> None:
        """Record lines from place to place (N, 2)."""
        along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
        at = np.linspace(0.0, along[-1], 2 + int(along[-1] / self._spacing))
        self._add_samples(np.column_stack([np.interp(at, along, values) for values in line.T]), ON_LINE_COST)

    def best_place(self, wishes: Sequence[tuple[Box, Sequence[Array]]]) -> int:
        """Return the index of the place that covers least, of places in the order of preference.

        Args:
            wishes: a text's rectangle and the lines (2, 2) that belong to it, for each place."""
        points, costs = np.concatenate(self._points), np.concatenate(self._costs)
        found = [
            NEXT_WISH_COST * k
            + costs[box.contains(points)].sum()
            + UNDER_LINE_SHARE * sum(costs[self._strip(line).contains(points)].sum() for line in lines)
            for k, (box, lines) in enumerate(wishes)
        ]
        return int(np.argmin(np.round(found, 6)))

    def _strip(self, line: Array) -> Box:
        """Return a narrow rectangle about a straight line (2, 2)."""
        (x, y), half = line[1] - line[0], 0.5 * self._spacing
        return Box(line.mean(axis=0), (0.5 * math.hypot(x, y), half), math.atan2(y, x))

    def _add_samples(self, points: Array, cost: float) -> None:
        """Record points (N, 2) that a text would cover, and the cost of covering each."""
        self._points.append(points)
        self._costs.append(np.full(len(points), cost))
