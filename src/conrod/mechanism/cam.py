"""Convex disc cams of tangent circular arcs, and motion laws of followers.

The profile is given in the cam's own frame: shaft at the origin, nose on the +x axis. Every arc is stated by its
centre, its radius and the directions of its outward normals, which together cover the full turn once.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, partial

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


FAN_EDGE = 1e-12  # [rad], overlap of the normals of neighbouring arcs, against gaps by rounding


@dataclass(frozen=True)
class Arc:
    """One arc of a profile: points centre + radius (cos n, sin n) for outward normals n from `start` to `stop`."""

    centre: tuple[float, float]  # [m]
    radius: float  # [m]
    start: float  # [rad]
    stop: float  # [rad], counter-clockwise from `start`

    @property
    def extent(self) -> float:
        """Rotation of the normal along the arc [rad]."""
        return self.stop - self.start

    def point(self, normal: float) -> tuple[float, float]:
        """The point (x, y) [m] with an outward normal [rad]."""
        return (self.centre[0] + self.radius * math.cos(normal), self.centre[1] + self.radius * math.sin(normal))


@dataclass(frozen=True)
class CamProfile:
    """A closed convex profile of arcs in counter-clockwise order, each tangent to the next."""

    arcs: tuple[Arc, ...]

    @cached_property
    def _centres(self) -> Array:
        return np.array([arc.centre for arc in self.arcs])

    @cached_property
    def _radii(self) -> Array:
        return np.array([arc.radius for arc in self.arcs])

    def active_arc(self, x: Array, y: Array) -> NDArray[np.intp]:
        """Index of the arc nearest to outside points (x, y) [m] in the cam's frame; shape of x.

        A point belongs to an arc whose normals point to it. The fan of normals of a long flank reaches through the
        whole cam
        and out at the far side, where the distance is negative: so the arc of the largest distance counts.
        """
        gap = np.full((len(self.arcs), *np.shape(x)), -np.inf)
        for i, arc in enumerate(self.arcs):
            middle = 0.5 * (arc.start + arc.stop)
            dx, dy = x - arc.centre[0], y - arc.centre[1]
            off = np.abs(np.remainder(np.arctan2(dy, dx) - middle + np.pi, 2.0 * np.pi) - np.pi)
            gap[i] = np.where(off <= 0.5 * arc.extent + FAN_EDGE, np.hypot(dx, dy) - arc.radius, -np.inf)
        return np.asarray(np.argmax(gap, axis=0))

    def arc_geometry(self, index: NDArray[np.intp]) -> tuple[Array, Array, Array]:
        """Centre x, centre y and radius [m] of the arcs of the given indices."""
        return self._centres[index, 0], self._centres[index, 1], self._radii[index]

    def jumps(self, first: int, second: int) -> bool:
        """True if acceleration or jerk of a roller jumps between two arcs, because their circles differ."""
        one, other = self.arcs[first], self.arcs[second]
        return (one.centre, one.radius) != (other.centre, other.radius)

    def points(self, normals: Array) -> Array:
        """Points (N, 2) [m] of the profile with given outward normals [rad]."""
        start = self.arcs[0].start
        turned = start + np.remainder(normals - start, 2.0 * np.pi)
        stops = np.array([arc.stop for arc in self.arcs])
        index = np.minimum(np.searchsorted(stops, turned, side="left"), len(self.arcs) - 1)
        cx, cy, radius = self.arc_geometry(index)
        return np.column_stack([cx + radius * np.cos(normals), cy + radius * np.sin(normals)])

    def outline(self, count: int) -> Array:
        """Points (N, 2) [m] around the whole profile, counter-clockwise, the first one repeated at the end."""
        return self.points(np.linspace(-np.pi, np.pi, count))

    def segment_joints(self) -> tuple[Array, Array]:
        """Points (N, 2) [m] where arcs meet, and outward normals there (N, 2); empty for a single arc."""
        arcs = self.arcs if len(self.arcs) > 1 else ()
        normals = np.array([(math.cos(arc.start), math.sin(arc.start)) for arc in arcs]).reshape(-1, 2)
        centres = np.array([arc.centre for arc in arcs]).reshape(-1, 2)
        return centres + np.array([arc.radius for arc in arcs]).reshape(-1, 1) * normals, normals

    @property
    def least_radius(self) -> float:
        """Smallest radius of curvature of the profile [m]."""
        return min(arc.radius for arc in self.arcs)


def symmetric_cam(base_radius: float, flank_radius: float, nose_radius: float, centre_distance: float) -> CamProfile:
    """Build the symmetric cam of document 004, Figure 5: base circle, two flanks and a nose, all tangent.

    The flank's centre lies at flank - base from the shaft and at flank - nose from the nose's centre (internal
    tangency). At the least flank radius, (base + nose + distance) / 2, the three centres are in line and the cam is
    one circle; a smaller flank radius is replaced by the least one. Lengths in m.
    """
    to_base = flank_radius - base_radius
    to_nose = flank_radius - nose_radius
    excess = flank_radius - 0.5 * (base_radius + nose_radius + centre_distance)
    if excess <= 0.0:
        return CamProfile((Arc((to_base, 0.0), flank_radius, -math.pi, math.pi),))
    # Half-angle formula: unlike the law of cosines it keeps its digits where the triangle is nearly flat.
    beside_base = 0.5 * (centre_distance + to_nose - to_base)
    beside_nose = 0.5 * (centre_distance + to_base - to_nose)
    at_shaft = 2.0 * math.atan2(math.sqrt(excess * beside_base), math.sqrt((centre_distance + excess) * beside_nose))
    # The flank whose normals point up has its centre below the axis, the other one above.
    above = (to_base * math.cos(at_shaft), to_base * math.sin(at_shaft))
    below = (above[0], -above[1])
    nose_joint = math.atan2(above[1], centre_distance - above[0])
    base_joint = math.pi - at_shaft
    return CamProfile(
        (
            Arc((centre_distance, 0.0), nose_radius, -nose_joint, nose_joint),
            Arc(below, flank_radius, nose_joint, base_joint),
            Arc((0.0, 0.0), base_radius, base_joint, 2.0 * math.pi - base_joint),
            Arc(above, flank_radius, 2.0 * math.pi - base_joint, 2.0 * math.pi - nose_joint),
        )
    )


# -- motion laws -------------------------------------------------------------------------------------------------------

# A law is a function y(x) from y(0) = 0 to y(1) = 1 with y' = 0 at both ends. A rise by h over a cam angle b is
# s = h y(theta / b); its k-th derivative by the cam angle is h / b^k times y's.
DWELL, HARMONIC, CYCLOIDAL = "dwell", "simple-harmonic", "cycloidal"


def harmonic(x: Array, order: int) -> Array:
    """Simple-harmonic law (1 - cos(pi x)) / 2, or its k-th derivative: document 004, equations (3) to (5)."""
    wave = -0.5 * math.pi**order * np.cos(math.pi * x + 0.5 * math.pi * order)
    return np.asarray(wave + 0.5 if order == 0 else wave)


def cycloidal(x: Array, order: int) -> Array:
    """Cycloidal law x - sin(2 pi x) / (2 pi), or its k-th derivative."""
    wave = -((2.0 * math.pi) ** (order - 1)) * np.sin(2.0 * math.pi * x + 0.5 * math.pi * order)
    return np.asarray(wave + (x if order == 0 else 1.0 if order == 1 else 0.0))


def polynomial(coefficients: tuple[float, ...], x: Array, order: int) -> Array:
    """Polynomial law with y(1 - x) = 1 - y(x), or its k-th derivative.

    The upper half is computed from the lower one, where no digits are lost.
    """
    derived = np.polynomial.polynomial.polyder(coefficients, order)
    upper = x > 0.5
    lower = np.polynomial.polynomial.polyval(np.where(upper, 1.0 - x, x), derived)
    mirrored = 1.0 - lower if order == 0 else (-1.0) ** (order + 1) * lower
    return np.where(upper, mirrored, lower)


# Motion laws by name, as functions of x and the order k that give the k-th derivative of y.
LAWS: dict[str, Callable[[Array, int], Array]] = {
    DWELL: lambda x, order: np.zeros(np.shape(x)),
    HARMONIC: harmonic,
    CYCLOIDAL: cycloidal,
    # Coefficients of x^0, x^1, ...: the polynomials of least degree whose first two, or three, derivatives are 0 at the
    # ends (Norton, Design of Machinery, chapter 8).
    "3-4-5": partial(polynomial, (0.0, 0.0, 0.0, 10.0, -15.0, 6.0)),
    "4-5-6-7": partial(polynomial, (0.0, 0.0, 0.0, 0.0, 35.0, -84.0, 70.0, -20.0)),
}


@dataclass(frozen=True)
class Segment:
    """A part of a cam's rotation with one motion law."""

    law: str  # one of `LAWS`
    over: float  # [rad], cam angle
    lift: float  # [m], positive: away from the shaft

    def height(self, x: Array, order: int) -> Array:
        """Lift above the segment's start, or its derivative by the cam angle, at a share x of the segment."""
        return self.lift / self.over**order * LAWS[self.law](x, order)
