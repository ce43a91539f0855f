"""The symbols a mechanism is drawn with: links, pins, guides, the frame's hatching, dimension lines. Lengths in mm."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Circle, FancyArrowPatch, Polygon

from conrod.exact.motion import Array
from conrod.mechanism.mechanism import Point
from conrod.report.drawing.dimensions import Length, Radius
from conrod.report.drawing.link_shapes import LinkShape

INK, FRAME, LINK, DIMENSION = "#222222", "#777777", "#7d97ab", "#8a2b2b"
TEXT: dict[str, Any] = {"fontsize": 8.0, "zorder": 20}
HALO: dict[str, Any] = {"facecolor": "white", "edgecolor": "none", "pad": 0.8, "alpha": 0.85}


def unit(direction: float) -> Array:
    """The unit vector of a direction [rad]."""
    return np.array([math.cos(direction), math.sin(direction)])


def body(axes: Axes, shape: LinkShape, width: float) -> None:
    """A link as a bar, or as a plate with its edges, of a line width [pt]; and its arms."""
    if len(shape.corners) > 2:
        axes.add_patch(Polygon(shape.corners, facecolor=LINK, alpha=0.3, edgecolor="none", zorder=3))
    if len(shape.edges):
        axes.plot(*shape.edges.T, color=LINK, linewidth=width, alpha=0.75, zorder=4)
    for line in shape.arms:
        arm(axes, line)


def arm(axes: Axes, line: Array) -> None:
    """A thin line (2, 2) from a link to a place that no joint holds."""
    axes.plot(*line.T, color=LINK, linewidth=1.5, alpha=0.75, zorder=3)


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
    axes.add_patch(
        FancyArrowPatch(
            (float(start[0]), float(start[1])),
            (float(stop[0]), float(stop[1])),
            arrowstyle=style,
            mutation_scale=8,
            shrinkA=0,
            shrinkB=0,
            color=colour,
            linewidth=width,
            zorder=10,
        )
    )


def turn_arrow(axes: Axes, centre: Array, radius: float, start: float, stop: float, colour: str) -> None:
    """An arc from one direction [rad] to another, with an arrow head at its end."""
    angles = np.linspace(start, stop, 60)
    points = centre + radius * np.column_stack([np.cos(angles), np.sin(angles)])
    axes.plot(*points[:-2].T, color=colour, linewidth=1.0, zorder=9)
    arrow(axes, points[-4], points[-1], colour)


def note(axes: Axes, at: Array, text: str, colour: str, turned: float = 0.0, ground: bool = True) -> None:
    """A text centred on a point, on a white ground or none; turned by an angle [deg]."""
    axes.text(
        float(at[0]),
        float(at[1]),
        text,
        color=colour,
        ha="center",
        va="center",
        rotation=turned,
        bbox=HALO if ground else None,
        **TEXT,
    )


def length_line(axes: Axes, dimension: Length, start: Array, stop: Array, extent: float) -> None:
    """A dimension line with its two extension lines."""
    line, *extensions = length_lines(dimension, start, stop, extent)
    for extension in extensions:
        axes.plot(*extension.T, color=DIMENSION, linewidth=0.6, zorder=6)
    arrow(axes, line[0], line[1], DIMENSION, "<|-|>", 0.8)
    middle, turned = length_text(dimension, start, stop, extent)
    note(axes, middle, dimension.text, DIMENSION, turned)


def length_lines(dimension: Length, start: Array, stop: Array, extent: float) -> list[Array]:
    """A dimension line and its two extension lines, each (2, 2)."""
    shift = dimension.aside * extent * _left(start, stop)
    origin = stop if dimension.stop_from is None else 1e3 * np.array(dimension.stop_from)
    extensions = [np.array([seen_from, end + 1.15 * shift]) for end, seen_from in ((start, start), (stop, origin))]
    return [np.array([start + shift, stop + shift]), *extensions]


def length_text(dimension: Length, start: Array, stop: Array, extent: float) -> tuple[Array, float]:
    """Centre of the text on a dimension line, and its angle [deg]."""
    aside = (dimension.aside + math.copysign(0.03, dimension.aside)) * extent * _left(start, stop)
    along = stop - start
    return start + dimension.text_at * along + aside, _readable(math.degrees(math.atan2(along[1], along[0])))


def _left(start: Array, stop: Array) -> Array:
    along = (stop - start) / np.linalg.norm(stop - start)
    return np.array([-along[1], along[0]])


def radius_line(axes: Axes, dimension: Radius, centre: Array, radius: float) -> None:
    """A radius arrow from a marked centre."""
    direction = unit(dimension.direction)
    axes.plot(*centre, marker="+", color=DIMENSION, markersize=7, markeredgewidth=0.9, zorder=9)
    arrow(axes, centre, centre + radius * direction, DIMENSION, "-|>", 0.8)
    if dimension.text_at > 1.0:
        outside = centre + dimension.text_at * radius * direction
        axes.annotate(
            dimension.text,
            (float(outside[0]), float(outside[1])),
            color=DIMENSION,
            ha="left" if direction[0] >= 0.0 else "right",
            va="center",
            **TEXT,
        )
    else:
        turned = _readable(math.degrees(dimension.direction))
        note(axes, centre + dimension.text_at * radius * direction, dimension.text, DIMENSION, turned)


def _readable(degrees: float) -> float:
    """The same line, read from the left or from below."""
    turned = (degrees + 180.0) % 360.0 - 180.0
    return turned - 180.0 if turned > 90.0 else turned + 180.0 if turned <= -90.0 else turned
