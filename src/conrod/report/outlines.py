"""Outlines of a mechanism's parts, to be drawn and to tell how far it reaches: pins, cams, pitch lines."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from conrod.mechanism import GROUND, CamContact, Mechanism, Point, Pose, Revolute, to_world
from conrod.motion import Array
from conrod.rolling import Mesh, Rolling

SAMPLES = 721
RACK_REACH = 2.0  # radii of its wheel that a rack is drawn to, on either side of it


def outline(mechanism: Mechanism, poses: Mapping[str, Pose]) -> Array:
    """Points (N, 2) [m] that the mechanism reaches: its pins, its cams' outlines, its wheels."""
    points = [to_world(poses[j.b], j.point_b) for j in mechanism.joints if isinstance(j, Revolute)]
    for contact in mechanism.cam_contacts:
        points += profile(contact, poses[contact.a])
    return np.concatenate([np.array(points), *(line for mesh in mechanism.meshes for line in pitch_lines(mesh, poses))])


def profile(contact: CamContact, pose: Pose) -> list[tuple[float, float]]:
    """Points [m] of a cam's outline in a pose."""
    return [to_world(pose, (float(x), float(y))) for x, y in contact.profile.outline(SAMPLES)]


def pitch_lines(mesh: Mesh, poses: Mapping[str, Pose]) -> tuple[Array, Array]:
    """The two lines that roll on each other, each with a radius that shows its turn; (N, 2) [m]."""
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
    """A circle from the direction of the body's x-axis; with its radius in that direction."""
    turn = pose[2] + np.linspace(0.0, 2.0 * np.pi, SAMPLES)
    middle = np.array(to_world(pose, centre))
    rim = middle + radius * np.column_stack([np.cos(turn), np.sin(turn)])
    return np.vstack([middle, rim]) if spoke else rim
