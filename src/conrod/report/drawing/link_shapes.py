"""Shapes of links: a bar through places in line, a plate around others, arms to what is only looked at."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from conrod.engines.cam_polygon import convex_hull
from conrod.exact.motion import Array

IN_LINE = 0.01  # how far places may lie off a line, of its length: less than a bar is wide
SAME = 1e-6  # how far apart places that joints share may be, of the coordinates: rounding


@dataclass(frozen=True)
class LinkShape:
    """The shape of a link, in the plane of the drawing.

    Attributes:
        corners: the two ends of a bar, the corners of a plate, counter-clockwise, or none; (C, 2).
        arms: lines from the link to places that no joint holds; each (2, 2).
    """

    corners: Array
    arms: tuple[Array, ...]

    @property
    def edges(self) -> Array:
        """The bar, or the way around the plate; (E, 2)."""
        return np.vstack([self.corners, self.corners[:1]]) if len(self.corners) > 2 else self.corners


def link_shape(held: Sequence[Array], seen: Sequence[Array] = ()) -> LinkShape:
    """The shape of a link that joints hold at some places, and that is looked at in others; each place (2,).

    A bar between joints reaches to what is looked at, or becomes a plate with it. A link that joints hold in no line is
    a plate as it is, and one that they hold at one place is none: what is looked at hangs on these by arms.
    """
    own = _distinct(held)
    if len(own) < 2:
        looked_at = _distinct([*own, *seen])[1:] if own else []
        return LinkShape(np.empty((0, 2)), tuple(_arm(own, place) for place in looked_at))
    if _in_line(own):
        return LinkShape(_spanned(_distinct([*own, *seen])), ())
    plate = _spanned(own)
    outside = [place for place in seen if len(_outside(plate, place))]
    return LinkShape(plate, tuple(_arm(own, place) for place in outside))


def _distinct(places: Sequence[Array]) -> list[Array]:
    found: list[Array] = []
    for place in places:
        near = SAME * max(1.0, float(np.abs(place).max()))
        if all(float(np.abs(place - other).max()) > near for other in found):
            found.append(place)
    return found


def _in_line(places: Sequence[Array]) -> bool:
    """True where places lie in the line through the two of them that are farthest apart."""
    ends = _ends(places)
    way = ends[1] - ends[0]
    arms = np.array(places) - ends[0]
    off = np.abs(way[0] * arms[:, 1] - way[1] * arms[:, 0]).max()
    return bool(off <= IN_LINE * (way @ way))


def _ends(places: Sequence[Array]) -> Array:
    """The two places that are farthest apart, in their order; (2, 2)."""
    points = np.array(places)
    apart = np.linalg.norm(points[:, None] - points[None], axis=2)
    return np.asarray(points[sorted(np.unravel_index(int(apart.argmax()), apart.shape))])


def _spanned(places: Sequence[Array]) -> Array:
    return _ends(places) if _in_line(places) else convex_hull(np.array(places))


def _outside(plate: Array, place: Array) -> Array:
    """The place as a corner (1, 2) of the plate with it; none (0, 2) if the plate holds it."""
    corners = convex_hull(np.array([*plate, place]))
    known = np.abs(corners[:, None] - plate[None]).max(axis=2).min(axis=1)
    return np.asarray(corners[known > SAME * max(1.0, float(np.abs(place).max()))])


def _arm(own: Sequence[Array], place: Array) -> Array:
    """From the nearest of the link's own places to another; (2, 2)."""
    return np.array([min(own, key=lambda other: float(np.linalg.norm(other - place))), place])
