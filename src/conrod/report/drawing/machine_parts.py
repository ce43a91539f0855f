"""The symbols a mechanism is drawn with: pins, guides, the frame's hatching, arrows, notes. Lengths in mm."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Circle, FancyArrowPatch, Polygon

from conrod.exact.motion import Array
from conrod.mechanism.mechanism import Point

INK, FRAME, LINK = "#222222", "#777777", "#7d97ab"
TEXT: dict[str, Any] = {"fontsize": 8.0, "zorder": 20}
HALO: dict[str, Any] = {"facecolor": "white", "edgecolor": "none", "pad": 0.8, "alpha": 0.85}


def unit(direction: float) -> Array:
    """The unit vector of a direction [rad]."""
    return np.array([math.cos(direction), math.sin(direction)])


def slot(axes: Axes, ends: Array, size: float) -> None:
    """A slot of a moving link between two ends (2, 2): its sides, without the frame's hatching."""
    along = (ends[1] - ends[0]) / np.linalg.norm(ends[1] - ends[0])
    left = 1.15 * size * np.array([-along[1], along[0]])
    corners = np.array([ends[0] - left, ends[1] - left, ends[1] + left, ends[0] + left])
    axes.add_patch(Polygon(corners, facecolor="white", edgecolor=LINK, linewidth=2.5, joinstyle="round", zorder=4.5))


def pin(axes: Axes, centre: Point, size: float) -> None:
    """A revolute joint."""
    axes.add_patch(Circle(centre, 0.35 * size, facecolor="white", edgecolor=INK, linewidth=1.2, zorder=8))


def bearing(axes: Axes, centre: Point, size: float) -> None:
    """A shaft's bearing on the frame: a foot with hatching under it."""
    x, y = centre
    foot = [(x, y), (x - 0.9 * size, y - 1.4 * size), (x + 0.9 * size, y - 1.4 * size)]
    axes.add_patch(Polygon(foot, facecolor="#f2f2f2", edgecolor=FRAME, linewidth=1.0, zorder=3))
    hatching(axes, np.array([x - 1.5 * size, y - 1.4 * size]), np.array([x + 1.5 * size, y - 1.4 * size]), size)


def hatching(axes: Axes, start: Array, stop: Array, size: float) -> None:
    """A line of the fixed frame, hatched on its right as seen from start to stop."""
    along = (stop - start) / np.linalg.norm(stop - start)
    right = np.array([along[1], -along[0]])
    axes.plot(*np.array([start, stop]).T, color=FRAME, linewidth=1.0, zorder=3)
    spacing = 0.5 * size
    for k in range(int(np.linalg.norm(stop - start) / spacing) + 1):
        top = start + k * spacing * along
        axes.plot(*np.array([top, top + 0.5 * size * (right - along)]).T, color=FRAME, linewidth=0.7, zorder=3)


def guide(axes: Axes, centre: Array, reach: tuple[float, float], direction: float, size: float) -> None:
    """A slide's two rails from reach[0] to reach[1] along a direction [rad] through a point."""
    along = unit(direction)
    left = np.array([-along[1], along[0]])
    near, far = centre + reach[0] * along, centre + reach[1] * along
    hatching(axes, far + 1.15 * size * left, near + 1.15 * size * left, size)
    hatching(axes, near - 1.15 * size * left, far - 1.15 * size * left, size)


def slider(axes: Axes, centre: Array, direction: float, size: float) -> None:
    """A block on its slide."""
    along = unit(direction)
    left = np.array([-along[1], along[0]])
    corners = [centre + size * (a * 1.5 * along + b * left) for a, b in ((1, 1), (-1, 1), (-1, -1), (1, -1))]
    axes.add_patch(Polygon(corners, facecolor="#dde6ec", edgecolor=INK, linewidth=1.0, zorder=5))


def arrow(axes: Axes, start: Array, stop: Array, colour: str, style: str = "-|>", width: float = 1.0) -> None:
    """A straight arrow."""
    ends = (float(start[0]), float(start[1])), (float(stop[0]), float(stop[1]))
    look: dict[str, Any] = {"arrowstyle": style, "mutation_scale": 8, "color": colour, "linewidth": width}
    axes.add_patch(FancyArrowPatch(*ends, shrinkA=0, shrinkB=0, zorder=10, **look))


def turn_arrow(axes: Axes, centre: Array, radius: float, start: float, stop: float, colour: str) -> None:
    """An arc from one direction [rad] to another, with an arrow head at its end."""
    angles = np.linspace(start, stop, 60)
    points = centre + radius * np.column_stack([np.cos(angles), np.sin(angles)])
    axes.plot(*points[:-2].T, color=colour, linewidth=1.0, zorder=9)
    arrow(axes, points[-4], points[-1], colour)


def note(axes: Axes, at: Array, text: str, colour: str, turned: float = 0.0, look: Mapping[str, Any] = TEXT) -> None:
    """A text centred on a point, on a white ground; turned by an angle [deg]."""
    x, y = at
    style = {**TEXT, **look, "color": colour, "rotation": turned, "bbox": HALO}
    axes.text(float(x), float(y), text, ha="center", va="center", **style)
