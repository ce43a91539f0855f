"""What a model's points are held against: exact paths around the crank's axis, for any lengths of the machine."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import lru_cache

import numpy as np

from conrod.errors import InvalidInput
from conrod.exact.kinematics import Kinematics
from conrod.exact.motion import Array, Motion
from conrod.mechanism.mechanism import Mechanism
from conrod.scenes import Scene

# Paths (P, T) of some points around the crank's axis [m], as complex numbers, at crank angles (T,).
Paths = Callable[[Array], Array]

# Turns at which the bodies are put before they are assembled, to find the other ways of assembling them.
STARTS = 8
NEWTON_STEPS = 60
ASSEMBLED = 1e-12  # of the machine's size
ALL_LENGTHS = "all lengths"


def length_names(scene: Scene) -> tuple[str, ...]:
    """Parameters that are lengths, and all of them together."""
    return (*(name for name, facts in scene.parameter_facts().items() if facts.unit == "m"), ALL_LENGTHS)


def with_lengths(scene: Scene, names: Sequence[str], values: Array) -> Scene:
    """The scene with other lengths [m]; that of all lengths is the factor that they take.

    Raises:
        InvalidInput: it cannot be assembled, or not turn.
    """
    changed = {n: float(v) for n, v in zip(names, values, strict=True) if n != ALL_LENGTHS}
    if ALL_LENGTHS in names:
        factor = float(values[list(names).index(ALL_LENGTHS)])
        changed = {n: factor * changed.get(n, scene.parameters[n]) for n in length_names(scene) if n != ALL_LENGTHS}
    return scene.with_parameters(**changed) if changed else scene


def length_of(scene: Scene, name: str) -> float:
    """Value of a length [m]; of all lengths the factor 1."""
    return 1.0 if name == ALL_LENGTHS else scene.parameters[name]


def shaft_of(mechanism: Mechanism) -> tuple[float, float]:
    """Where the crank's axis is [m], in the document's frame."""
    return mechanism.driven_joint.point_a


def paths_of(scene: Scene, points: Sequence[str]) -> Paths:
    """The closed form's."""
    shaft = complex(*shaft_of(scene.mechanism()))
    return lambda angle: around(scene.motion(angle, 1.0), points, shaft)


def paths_of_kinematics(kinematics: Kinematics, points: Sequence[str]) -> Paths:
    """The generic reference's."""
    shaft = complex(*shaft_of(kinematics.mechanism))
    return lambda angle: around(kinematics.motion(angle, 1.0), points, shaft)


def around(motion: Motion, points: Sequence[str], shaft: complex) -> Array:
    """Positions (P, T) of points around the shaft, as complex numbers."""
    positions = [motion.point(name).position for name in points]
    return np.array([p[:, 0] + 1j * p[:, 1] - shaft for p in positions])


@lru_cache(16)
def other_branches(scene: Scene) -> tuple[Kinematics, ...]:
    """The same machine assembled otherwise, where it can be, and still turns fully."""
    own, found = scene.kinematics, list[Kinematics]()
    mechanism, start = own.mechanism, own.start[0]
    seen = [start]
    for poses in _other_starts(own):
        if any(_same(poses, other, own.size) for other in seen):
            continue
        seen.append(poses)
        stacked = poses.reshape(-1, 3)
        named = {
            b.name: (float(p[0]), float(p[1]), float(p[2])) for b, p in zip(mechanism.bodies, stacked, strict=True)
        }
        try:
            other = Kinematics(replace(mechanism, name=f"{mechanism.name}-otherwise", poses=named))
            other.poses(np.linspace(0.0, 2.0 * np.pi, 13))
        except InvalidInput:
            continue
        found.append(other)
    return tuple(found)


def _other_starts(kinematics: Kinematics) -> list[Array]:
    """Assembled poses (3 n,) at crank angle 0, by Newton's iteration from poses turned and mirrored at the crank."""
    start = kinematics.start[0].reshape(-1, 3)
    shaft = np.array([*shaft_of(kinematics.mechanism), 0.0])
    crank = kinematics.mechanism.body_index[kinematics.mechanism.crank]
    found = []
    for turn in 2.0 * np.pi * np.arange(STARTS) / STARTS:
        for mirror in (1.0, -1.0):
            guess = start.copy()
            away = start[:, :2] - shaft[:2]
            c, s = np.cos(turn), np.sin(turn)
            guess[:, :2] = shaft[:2] + (away * [1.0, mirror]) @ np.array([[c, s], [-s, c]])
            guess[:, 2] = mirror * start[:, 2] + turn
            guess[crank] = start[crank]
            poses = _assembled(kinematics, guess.ravel())
            if poses is not None:
                found.append(poses)
    return found


def _assembled(kinematics: Kinematics, guess: Array) -> Array | None:
    poses, zero = guess[None].copy(), np.zeros(1)
    for _ in range(NEWTON_STEPS):
        left = kinematics.residual([poses], zero)
        jacobian = kinematics.jacobian(poses)[0]
        if not np.all(np.isfinite(jacobian)) or abs(np.linalg.det(jacobian)) == 0.0:
            return None
        step = np.linalg.solve(jacobian, left[0])
        poses = poses - step
        if np.abs(step).max() < ASSEMBLED * max(kinematics.size, 1.0):
            return np.asarray(poses[0])
    return None


def _same(one: Array, other: Array, size: float) -> bool:
    """Whether two poses are one but for whole turns."""
    apart = (one - other).reshape(-1, 3)
    turns = np.abs(np.exp(1j * apart[:, 2]) - 1.0)
    return bool(np.abs(apart[:, :2]).max() < 1e-6 * size and turns.max() < 1e-6)
