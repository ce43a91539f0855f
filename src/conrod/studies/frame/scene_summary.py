"""Summary of a scene before any engine runs, as `conrod show` prints it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from conrod.exact.motion import Array
from conrod.scenes import Scene

SAMPLES = 3600
HALVINGS = 60
AT_REST = 1e-6  # speed of a point at rest, against its stroke and the crank's speed
STANDING = 1e-12  # likewise, of a dwell
# Of omega^2 L: both sides of a break are taken so near to it that a continuous acceleration differs by less.
SEEN = 1e-6


@dataclass(frozen=True)
class DeadCentre:
    """A crank angle [rad] where the output point turns back, and its place (x, y) [m]."""

    angle: float
    place: tuple[float, float]


def stroke(scene: Scene) -> float:
    """Travel [m] of the output point."""
    return scene.lengths[scene.output]


def dead_centres(scene: Scene) -> tuple[DeadCentre, ...]:
    """Dead centres, where the output point comes to rest and turns back, by bisection on the exact motion.

    A dwell is no dead centre: the follower of a cam rests there, and turns back at the nose alone. Nor is the end of a
    coupler point's curve, which it passes without a rest.
    """
    span = scene.mechanism().driver.span
    step = 2.0 * np.pi / SAMPLES
    # Off by a third of a step, so that no sample falls on a dead centre itself.
    turn = np.asarray((np.arange(SAMPLES + 1) - 1.0 / 3.0) * step, dtype=float)
    angles = turn if span is None else np.linspace(*span, SAMPLES)
    along = _direction(scene)
    speeds = _speed(scene, angles, along)
    # What a solver's rounding moves in a dwell turns nowhere back.
    speeds[np.abs(speeds) <= STANDING * stroke(scene)] = 0.0
    found = np.flatnonzero(speeds[:-1] * speeds[1:] < 0.0)
    if not found.size:
        return ()
    low, high, sign = angles[found], angles[found + 1], np.sign(speeds[found])
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        before = np.sign(_speed(scene, middle, along)) == sign
        low, high = np.where(before, middle, low), np.where(before, high, middle)
    found_motion = scene.motion(low, 1.0).point(scene.output)
    resting = np.linalg.norm(found_motion.velocity, axis=1) <= AT_REST * stroke(scene)
    centres = [
        DeadCentre(_once_around(float(angle)) if span is None else float(angle), (float(x), float(y)))
        for angle, (x, y) in zip(low[resting], found_motion.position[resting], strict=True)
    ]
    return tuple(sorted(centres, key=lambda centre: centre.angle))


def jumps(scene: Scene) -> tuple[tuple[float, str], ...]:
    """Each crank angle [rad] where an observed point's motion jumps, with the lowest derivative that does."""
    if not (angles := scene.break_angles()):
        return ()
    before, after = scene.beside_breaks()
    jump = np.zeros(len(angles))
    for name, length in scene.lengths.items():
        gap = np.linalg.norm(after.point(name).acceleration - before.point(name).acceleration, axis=1)
        jump = np.maximum(jump, gap / (length * scene.speed**2))
    named = ("acceleration" if size > SEEN else "jerk" for size in jump)
    return tuple(sorted(zip(angles, named, strict=True)))


def _once_around(angle: float) -> float:
    """An angle in [0, 2 pi), with rounding just below zero taken for zero."""
    turned = angle % (2.0 * np.pi)
    return 0.0 if 2.0 * np.pi - turned < 1e-9 else turned


def _direction(scene: Scene) -> Array:
    span = scene.mechanism().driver.span
    turn = np.linspace(*(span or (0.0, 2.0 * np.pi)), SAMPLES, endpoint=span is not None)
    place = scene.motion(turn, scene.speed).point(scene.output).position
    way = place[np.argmax(np.linalg.norm(place - place[0], axis=1))] - place[0]
    return np.asarray(way / np.linalg.norm(way))


def _speed(scene: Scene, angles: Array, along: Array) -> Array:
    # Per unit of crank speed, so that its sign does not depend on the sense of rotation.
    return np.asarray(scene.motion(angles, 1.0).point(scene.output).velocity @ along)
