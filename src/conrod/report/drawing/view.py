"""A mechanism to be drawn at a crank angle, and outlines of its slides, cams and wheels."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import ArrayLike

from conrod.exact.motion import Array
from conrod.mechanism.mechanism import (
    GROUND,
    CamContact,
    Mechanism,
    Mesh,
    Point,
    Pose,
    Revolute,
    Rolling,
    to_world,
)
from conrod.mechanism.slide import Slide
from conrod.mechanism.units import MM
from conrod.report.drawing.machine_parts import Labels


@dataclass(frozen=True)
class View:
    """A mechanism at a crank angle, to be drawn in mm.

    Attributes:
        axes: axes to draw on.
        mechanism: the mechanism.
        poses: poses of the bodies and the ground [m, m, rad].
        turn: stacked poses over a turn or a pass, (T, 3 n) [m, m, rad]; or only one pose, (1, 3 n).
        size: size of a symbol [mm].
        labels: texts and lines that are drawn already.
        extent: width or height of the mechanism, whichever is larger [mm].
        paths: paths of the observed points over a turn or a pass, (T, 2) [mm].
        discs: radii [m] of the bodies that are discs about their centre of gravity.
    """

    axes: Axes
    mechanism: Mechanism
    poses: Mapping[str, Pose]
    turn: Array
    size: float
    labels: Labels
    extent: float
    paths: Mapping[str, Array]
    discs: Mapping[str, float]

    def axes_of(self, *bodies: str) -> Axes:
        """Return the axes on which parts of some bodies are drawn."""
        return self.axes

    def to_drawing(self, places: ArrayLike) -> Array:
        """Convert places (..., 2) from [m] to the drawing's [mm]."""
        return MM * np.asarray(places, dtype=float)

    def place_of(self, body: str, point: Point) -> Array:
        """Return the place (2,) [mm] of a point in a body's frame [m]."""
        return self.to_drawing(to_world(self.poses[body], point))

    def poses_over_turn(self, body: str) -> Array:
        """Return poses (T, 3) [m, m, rad] of a body or the ground over a turn or a pass."""
        if body == GROUND:
            return np.zeros((len(self.turn), 3))
        k = self.mechanism.body_index[body]
        return self.turn[:, 3 * k : 3 * k + 3]


def slide_displacements(slide: Slide, guides: Array, movings: Array) -> Array:
    """Return displacements (T,) [m] of a block along its guide, from both bodies' poses (T, 3)."""
    cos, sin = np.cos(movings[:, 2]), np.sin(movings[:, 2])
    x, y = slide.point
    block = movings[:, :2] + np.column_stack([cos * x - sin * y, sin * x + cos * y])
    turns = guides[:, 2] + slide.direction
    return np.asarray(((block - guides[:, :2]) * np.column_stack([np.cos(turns), np.sin(turns)])).sum(axis=1))


OUTLINE_SAMPLES = 721
RACK_REACH = 2.0  # wheel radii; length of a rack on either side of its wheel


def reached_points(mechanism: Mechanism, poses: Mapping[str, Pose], discs: Mapping[str, float]) -> Array:
    """Return points (N, 2) [m] of the pins, cams, wheels and discs of some radii [m], which bound the mechanism."""
    points = [to_world(poses[j.b], j.point_b) for j in mechanism.joints if isinstance(j, Revolute)]
    for contact in mechanism.cam_contacts:
        points += cam_outline(contact, poses[contact.a])
    for name, radius in discs.items():
        x, y = to_world(poses[name], mechanism.body(name).centre_of_gravity)
        points += [(x - radius, y - radius), (x + radius, y + radius)]
    return np.concatenate([np.array(points), *(line for mesh in mechanism.meshes for line in pitch_lines(mesh, poses))])


def cam_outline(contact: CamContact, pose: Pose) -> list[tuple[float, float]]:
    """Return points [m] of a cam's outline in a pose."""
    return [to_world(pose, (float(x), float(y))) for x, y in contact.profile.outline(OUTLINE_SAMPLES)]


def pitch_lines(mesh: Mesh, poses: Mapping[str, Pose]) -> tuple[Array, Array]:
    """Return two pitch lines (N, 2) [m], each with a radius that shows its rotation."""
    if isinstance(mesh, Rolling):
        return (
            _circle(poses[mesh.a], mesh.point_a, abs(mesh.radius_a), spoke=mesh.radius_a > 0.0 and mesh.a != GROUND),
            _circle(poses[mesh.b], mesh.point_b, abs(mesh.radius_b), spoke=mesh.radius_b > 0.0 and mesh.b != GROUND),
        )
    centre = np.array(to_world(poses[mesh.a], mesh.point_a))
    turn = poses[mesh.b][2] + mesh.direction
    along = np.array([math.cos(turn), math.sin(turn)])
    line = np.array(to_world(poses[mesh.b], mesh.point_b))
    foot = line + ((centre - line) @ along) * along
    reach = RACK_REACH * mesh.radius * along
    wheel = _circle(poses[mesh.a], mesh.point_a, mesh.radius, spoke=True)
    return wheel, np.array([foot - reach, foot + reach])


def _circle(pose: Pose, centre: Point, radius: float, spoke: bool) -> Array:
    """Return a circle (N, 2) [m] of a body, with a radius along the body's x-axis if `spoke`."""
    turn = pose[2] + np.linspace(0.0, 2.0 * np.pi, OUTLINE_SAMPLES)
    middle = np.array(to_world(pose, centre))
    rim = middle + radius * np.column_stack([np.cos(turn), np.sin(turn)])
    return np.vstack([middle, rim]) if spoke else rim
