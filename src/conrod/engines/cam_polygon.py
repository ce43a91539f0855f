"""A cam profile as the convex polygon that engines collide, and the error that this shape has.

Every facet stands off its arc by about the same sagitta, and every vertex half a sagitta outside, so that the
polygon straddles the true curve: its normal distance to it is at most half a sagitta either way.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from conrod.cam import CamProfile
from conrod.motion import Array


@dataclass(frozen=True)
class CamPolygon:
    """A convex polygon, to be rounded by `radius`.

    Attributes:
        vertices: (N, 2) [m] in the cam's frame, counter-clockwise.
        radius: what was taken off the profile, to be added again as a rounding [m].
        facet_turns: for each arc of the profile, the turn of the normal from facet to facet [rad].
        error: bound on the normal distance between the rounded polygon and the profile [m].
    """

    vertices: Array
    radius: float
    facet_turns: tuple[float, ...]
    error: float


def cam_polygon(profile: CamProfile, vertices: int, radius: float = 0.0) -> CamPolygon:
    """The polygon of about so many vertices, inset by `radius` [m], less than the profile's least radius.

    Facets per arc are even, so that a vertex stands at the middle of the dwell: the roller then starts in contact,
    and not on a facet inside the curve with a fall ahead of it.
    """
    weights = np.array([math.sqrt(arc.radius - radius) * arc.extent for arc in profile.arcs])
    facets = 2 * np.maximum(1, np.rint(vertices * weights / weights.sum() / 2.0)).astype(int)
    turns = [arc.extent / n for arc, n in zip(profile.arcs, facets, strict=True)]
    sagittas = [(arc.radius - radius) * (1.0 - math.cos(t / 2.0)) for arc, t in zip(profile.arcs, turns, strict=True)]
    corners = []
    for i, (arc, n) in enumerate(zip(profile.arcs, facets, strict=True)):
        normals = np.linspace(arc.start, arc.stop, n, endpoint=False)
        outside = np.full(n, 0.5 * sagittas[i])
        outside[0] = 0.5 * min(sagittas[i], sagittas[i - 1])  # a joint's vertex belongs to two arcs
        reach = arc.radius - radius + outside
        corners.append(np.column_stack([np.cos(normals), np.sin(normals)]) * reach[:, None] + np.array(arc.centre))
    return CamPolygon(np.concatenate(corners), radius, tuple(turns), 0.5 * max(sagittas))
