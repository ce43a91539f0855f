"""A mechanism at a crank angle with its instant centres, beside its polygons of velocity and acceleration.

A polygon has its pole O at the origin. From it the velocity (acceleration) of each point leads to the point's small
letter, and between letters lead the relative ones of points on one link, as in document 001, chapters V and VI.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from conrod.exact.linkage import InstantQuantities
from conrod.exact.linkage.link_motion import GROUND_AT_REST
from conrod.exact.motion import Array
from conrod.mechanism.units import MM
from conrod.report.charts.canvas import drawing_style, svg_text
from conrod.report.drawing import machine_parts as parts
from conrod.report.drawing.drawing import draw_crank_angle, draw_frame_axes, draw_observed, view_at
from conrod.report.drawing.links import draw_joints, draw_links
from conrod.scenes import Scene

PAGE = (13.0, 8.0)  # [inch]
FAR_EXTENTS = 0.5  # centres farther from the mechanism than this share of its extent are not drawn
MAX_NAMES = 4  # in a label; more points or centres at one place are counted by dots
PLACE_DIGITS = 3  # decimals of places [mm] of centres that share a label
NOTE: dict[str, Any] = {
    "textcoords": "offset points",
    "parse_math": False,
    "in_layout": False,
    "bbox": parts.TEXT_GROUND,
    "zorder": 20,
}
CENTRE, WHOLE, NORMAL, TANGENTIAL, CORIOLIS = "#b3402e", "#222222", "#2a6f9c", "#2a8c6a", "#b3402e"


class PolygonVector(NamedTuple):
    """A vector of a polygon from start to end, (2,) each [m/s] or [m/s^2]."""

    start: Array
    stop: Array
    colour: str
    letter: str = ""  # of the point whose velocity or acceleration its end is


def instant_svg(scene: Scene, instant: InstantQuantities) -> str:
    """Draw a scene at a crank angle with its instant centres and polygons as SVG text."""
    with drawing_style():
        return svg_text(instant_figure(scene, instant))


def instant_figure(scene: Scene, instant: InstantQuantities) -> Figure:
    """Draw a scene at a crank angle with its instant centres and polygons."""
    figure = Figure(figsize=PAGE, layout="constrained")
    left, above, below = figure.subplot_mosaic([["m", "m", "v"], ["m", "m", "a"]]).values()
    _draw_centres(left, scene, instant)
    _draw_polygon(above, "velocities [m/s]", [*velocity_vectors(instant)])
    title = "accelerations [m/s²]\nblue normal, green tangential, red Coriolis"
    _draw_polygon(below, title, [*acceleration_vectors(instant)])
    return figure


def _draw_centres(axes: Axes, scene: Scene, instant: InstantQuantities) -> None:
    """Draw the mechanism with the centres that are near it; links have the numbers of the text under it."""
    view = view_at(scene, instant.angle, axes)
    draw_joints(view)
    draw_links(view)
    draw_observed(view)
    draw_frame_axes(view)
    draw_crank_angle(view, scene, instant.angle)
    axes.set_aspect("equal", adjustable="datalim")
    axes.autoscale_view()
    low, high = (np.array(ends) for ends in zip(axes.get_xlim(), axes.get_ylim(), strict=True))
    numbers = {name: k for k, name in enumerate(("ground", *(link.link for link in instant.links)), start=1)}
    labels: dict[tuple[float, float], list[str]] = defaultdict(list)
    for centre in instant.centres:
        if centre.place is not None:
            first, second = (numbers[link] for link in centre.links)
            x, y = (np.round(MM * centre.place, PLACE_DIGITS) + 0.0).tolist()
            labels[x, y].append(f"{first}{second}" if second < 10 else f"{first},{second}")
    reach = FAR_EXTENTS * view.extent
    for place, names in labels.items():
        if np.all(low - reach <= place) and np.all(place <= high + reach):
            axes.plot(*place, marker="x", markersize=6.0, markeredgewidth=1.6, color=CENTRE, zorder=14)
            axes.annotate(_label(names), place, (5, -11), color=CENTRE, **NOTE)
    links = ", ".join(f"{k} {name}" for name, k in numbers.items())
    axes.set_xlabel(f"x [mm]; instant centres of links {links}", parse_math=False, wrap=True)
    axes.set_ylabel("y [mm]")


def _label(names: list[str]) -> str:
    return ", ".join(names[:MAX_NAMES]) + (", ..." if len(names) > MAX_NAMES else "")


def velocity_vectors(instant: InstantQuantities) -> Iterator[PolygonVector]:
    """Vectors of the velocity polygon."""
    links = {link.link: link for link in (GROUND_AT_REST, *instant.links)}
    for one in instant.relative:
        start = links[one.link].point_velocity(one.places[1])
        yield PolygonVector(start, start + one.velocity, WHOLE, one.point.lower())
    for point in instant.points.points.values():
        yield PolygonVector(np.zeros(2), point.velocity[0], WHOLE)
    for sliding in instant.sliding:
        start = links[sliding.guide].point_velocity(sliding.place)
        yield PolygonVector(np.zeros(2), start, WHOLE)
        yield PolygonVector(start, start + sliding.velocity, TANGENTIAL, sliding.point.lower())


def acceleration_vectors(instant: InstantQuantities) -> Iterator[PolygonVector]:
    """Vectors of the acceleration polygon, normal and tangential parts about each link's first point."""
    links = {link.link: link for link in (GROUND_AT_REST, *instant.links)}
    first: dict[str, str] = {}
    for one in instant.relative:
        if first.setdefault(one.link, one.about) != one.about:
            continue
        start = links[one.link].point_acceleration(one.places[1])
        corner = start + one.normal
        yield PolygonVector(start, corner, NORMAL)
        yield PolygonVector(corner, corner + one.tangential, TANGENTIAL, one.point.lower())
    for point in instant.points.points.values():
        yield PolygonVector(np.zeros(2), point.acceleration[0], WHOLE)
    for sliding in instant.sliding:
        start = links[sliding.guide].point_acceleration(sliding.place)
        corner = start + sliding.coriolis
        yield PolygonVector(np.zeros(2), start, WHOLE)
        yield PolygonVector(start, corner, CORIOLIS)
        yield PolygonVector(corner, corner + sliding.normal, NORMAL)
        last = corner + sliding.normal
        yield PolygonVector(last, last + sliding.tangential, TANGENTIAL, sliding.point.lower())


def _draw_polygon(axes: Axes, title: str, vectors: list[PolygonVector]) -> None:
    """Draw a polygon to scale, each letter once."""
    axes.set_title(title)
    axes.margins(0.12)
    axes.set_aspect("equal", adjustable="datalim")
    size = max((float(np.linalg.norm(end)) for one in vectors for end in (one.start, one.stop)), default=0.0) or 1.0
    letters: dict[tuple[float, float], list[str]] = {(0.0, 0.0): ["O"]}
    for one in vectors:
        axes.plot(*np.array([one.start, one.stop]).T, alpha=0.0)  # arrows do not count for the limits
        if np.linalg.norm(one.stop - one.start) > 1e-6 * size:
            parts.draw_arrow(axes, one.start, one.stop, one.colour)
        x, y = (np.round(one.stop / size, PLACE_DIGITS) + 0.0).tolist()
        if one.letter and one.letter not in letters.setdefault((x, y), []):
            letters[x, y].append(one.letter)
    for (x, y), names in letters.items():
        if names:
            axes.annotate(_label(names), (x * size, y * size), (4, 5), **NOTE)
