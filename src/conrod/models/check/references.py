"""Exact paths that a model's points are compared with, for any lengths and assembly branches of the machine."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import lru_cache
from typing import TypeAlias

import numpy as np

from conrod.errors import InvalidInput
from conrod.exact.equations import Equations
from conrod.exact.kinematics import ExactReference, GenericReference
from conrod.exact.motion import Array
from conrod.scenes import Scene
from conrod.scenes.described_scene import DescribedScene

# Paths (P, T) of some points around the crank's axis [m], as complex numbers, at crank angles (T,).
Paths: TypeAlias = Callable[[Array], Array]

ALL_LENGTHS = "all lengths"
# Turns at which the bodies are put before they are assembled, to find the other ways of assembling them.
START_ROTATIONS = 8
NEWTON_STEPS = 60
POSE_TOLERANCE = 1e-6  # of the machine's size, and in radians


def length_names(scene: Scene) -> tuple[str, ...]:
    """Names of the parameters that are lengths, and `ALL_LENGTHS`."""
    return (*(name for name, facts in scene.parameter_facts().items() if facts.unit == "m"), ALL_LENGTHS)


def with_lengths(scene: Scene, names: Sequence[str], values: Array, *, in_fit: bool = False) -> Scene:
    """A scene with other lengths [m]; the value of `ALL_LENGTHS` is a factor on all of them.

    Args:
        in_fit: whether it only has to be exact to rounding, as `Scene.with_nearby_parameters` is.

    Raises:
        InvalidInput: a scene with these lengths cannot be assembled or cannot turn.
    """
    changed = {n: float(v) for n, v in zip(names, values, strict=True) if n != ALL_LENGTHS}
    if ALL_LENGTHS in names:
        factor = float(values[list(names).index(ALL_LENGTHS)])
        changed = {n: factor * changed.get(n, scene.parameters[n]) for n in length_names(scene) if n != ALL_LENGTHS}
    if not changed:
        return scene
    return scene.with_nearby_parameters(**changed) if in_fit else scene.with_parameters(**changed)


def length_of(scene: Scene, name: str) -> float:
    """Value of a length [m]; 1 for `ALL_LENGTHS`."""
    return 1.0 if name == ALL_LENGTHS else scene.parameters[name]


def shaft_of(reference: ExactReference) -> tuple[float, float]:
    """Position of the crank's axis in the document's frame (2,) [m]."""
    return reference.mechanism().driven_joint.point_a


def returns_after_turn(scene: Scene) -> bool:
    """True if all observed points return after each turn of the crank; false for wheels and one-pass inputs."""
    if scene.kinematics.mechanism.driver.span is not None:
        return False
    motion = scene.motion(np.array([0.0, 2.0 * np.pi]), 1.0)
    away = [np.ptp(motion.point(name).position, axis=0).max() for name in scene.lengths]
    return float(max(away)) <= POSE_TOLERANCE * scene.kinematics.size


def paths_of(reference: ExactReference, points: Sequence[str]) -> Paths:
    """A function that computes a machine's paths (P, T) around its shaft at crank angles (T,)."""
    shaft = complex(*shaft_of(reference))

    def paths(angle: Array) -> Array:
        if isinstance(reference, DescribedScene | GenericReference):
            found: Mapping[str, Sequence[Array]] = reference.kinematics.positions(angle)
        else:  # a closed form gives all derivatives at once
            motion = reference.motion(angle, 1.0)
            found = {name: list(motion.point(name).position.T) for name in points}
        return np.array([x + 1j * y - shaft for x, y in (found[name] for name in points)])

    return paths


@lru_cache(16)
def other_branches(scene: Scene) -> tuple[GenericReference, ...]:
    """Other assembly branches of a machine on which it can still turn fully."""
    mechanism, found = scene.kinematics.mechanism, list[GenericReference]()
    seen = [scene.kinematics.start[0]]
    for poses in _assembled_poses(scene):
        if any(_are_same_pose(poses, other, scene.kinematics.size) for other in seen):
            continue
        seen.append(poses)
        named = {
            b.name: (p[0], p[1], p[2]) for b, p in zip(mechanism.bodies, poses.reshape(-1, 3).tolist(), strict=True)
        }
        other = GenericReference(replace(mechanism, name=f"{mechanism.name}-otherwise", poses=named), scene.speed)
        try:
            other.kinematics.poses(np.linspace(*scene.kinematics.span, 13))
        except InvalidInput:
            continue
        found.append(other)
    return tuple(found)


def with_branch_of(reference: ExactReference, branch: GenericReference | None) -> ExactReference:
    """Return the exact motion of a machine on a given assembly branch; None keeps its present branch.

    Args:
        reference: exact motion with the lengths to keep; a `GenericReference` is returned as it is.
        branch: exact motion of the same machine, of any lengths, that starts from poses on the branch.
    """
    if branch is None or isinstance(reference, GenericReference):
        return reference
    mechanism = replace(reference.mechanism(), name=branch.described.name, poses=branch.described.poses)
    return GenericReference(mechanism, branch.speed)


def _assembled_poses(scene: Scene) -> Iterator[Array]:
    """Assembled poses (3 n,) at crank angle 0, by Newton's iteration from rotated and mirrored poses."""
    mechanism, equations = scene.kinematics.mechanism, Equations(scene.kinematics.mechanism)
    start = scene.kinematics.start[0].reshape(-1, 3)
    shaft, crank = np.array(shaft_of(scene)), mechanism.body_index[mechanism.crank]
    for turn in 2.0 * np.pi * np.arange(START_ROTATIONS) / START_ROTATIONS:
        for mirror in (1.0, -1.0):
            guess = start.copy()
            c, s = np.cos(turn), np.sin(turn)
            guess[:, :2] = shaft + ((start[:, :2] - shaft) * [1.0, mirror]) @ np.array([[c, s], [-s, c]])
            guess[:, 2] = mirror * start[:, 2] + turn
            guess[crank] = start[crank]
            try:
                yield equations.newton(guess.reshape(1, -1), np.zeros(1), NEWTON_STEPS)[0]
            except (InvalidInput, np.linalg.LinAlgError):
                continue


def _are_same_pose(one: Array, other: Array, size: float) -> bool:
    """True if two poses are equal but for whole turns."""
    apart = (one - other).reshape(-1, 3)
    turns = np.abs(np.exp(1j * apart[:, 2]) - 1.0)
    return bool(np.abs(apart[:, :2]).max() < POSE_TOLERANCE * size and turns.max() < POSE_TOLERANCE)


# -- sensitivities -----------------------------------------------------------------------------------------------------


# Of the longest length, for central differences of the exact motion: they are right to 1e-9.
DIFFERENCE_STEP = 1e-5
SENSITIVITY_ANGLES = 180


def sensitivities(scene: Scene) -> dict[str, Array]:
    """Sensitivity of each point's position around the shaft to each length: (points, angles) [m/m].

    Raises:
        InvalidInput: a length cannot be changed alone, as at a change point.
    """
    names = [name for name in length_names(scene) if name != ALL_LENGTHS]
    step = DIFFERENCE_STEP * max(abs(scene.parameters[name]) for name in names)
    angle, points = scene.kinematics.angles(SENSITIVITY_ANGLES), tuple(scene.lengths)

    def paths(name: str, by: float) -> Array:
        return paths_of(with_lengths(scene, [name], np.array([scene.parameters[name] + by])), points)(angle)

    return {name: np.abs(paths(name, step) - paths(name, -step)) / (2.0 * step) for name in names}


def uncertainty_shares(
    slopes: Mapping[str, Array], uncertainties: Mapping[str, float]
) -> tuple[float, dict[str, float]]:
    """Largest standard uncertainty of a position [m], and the share of each length in its variance.

    Args:
        uncertainties: standard uncertainties of lengths [m]; a length without one is exact.
    """
    parts = {name: (slope * uncertainties.get(name, 0.0)) ** 2 for name, slope in slopes.items()}
    variance = np.sum(list(parts.values()), axis=0)
    worst = np.unravel_index(int(variance.argmax()), variance.shape)
    whole = float(variance[worst])
    return whole**0.5, {name: float(part[worst]) / (whole or 1.0) for name, part in parts.items()}
