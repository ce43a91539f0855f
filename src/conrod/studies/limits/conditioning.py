"""Error of the exact motion itself: the closed form in double precision against fifty digits.

Near a change point a rounding error of a length is magnified in the motion, by 1 / sqrt(2 (1 - nearness)) in position.
The fifty digits never see the closed form: they are the joint equations of the mechanism, solved from its
double-precision poses on by correcting what fifty digits of residual leave (iterative refinement; Higham, Accuracy and
Stability of Numerical Algorithms, 2nd ed., chapter 12).

Both are evaluated at crank angles that are double-precision numbers, so rounding of the angle is no part of it.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache
from typing import Any, TypeAlias

import mpmath
import numpy as np
from numpy.typing import NDArray

from conrod.exact.equations import Equations
from conrod.exact.joint_equations import pose_jets
from conrod.exact.motion import Array
from conrod.scenes import Scene

DIGITS = 50
# A correction so small (lengths against the mechanism's size) is the last: what it leaves is smaller by many digits.
ENOUGH = 1e-30
MOST_CORRECTIONS = 20
# Crank angles: some all around, and some ever closer to the poses of worst condition, on both sides.
AROUND, CLOSER, SAMPLES = 8, 8, 720
NARROW, WIDE = 1e-9, 0.3  # [rad], from a pose of worst condition
# What every reference is good to, machines far from any change point included; not reported.
USUAL = 1e-13
SCENES_KEPT = 256

Digits: TypeAlias = NDArray[Any]  # an array of objects, the numbers with fifty digits


def reference_error(scene: Scene) -> float | None:
    """Return the position error of a scene's reference, normalised; None where that is no more than usual."""
    off = closed_form_error(scene)
    return off if off > USUAL else None


@lru_cache(SCENES_KEPT)
def closed_form_error(scene: Scene) -> float:
    """Position error of the closed form, over L: of the worst observed point at the worst of some dozens of angles.

    Raises:
        ArithmeticError: fifty digits are not reached, which is so at a change point itself.
    """
    angles = worst_angles(scene)
    exact, closed = fifty_digits(scene, angles), scene.motion(angles, 1.0)
    worst = 0.0
    for name, length in scene.lengths.items():
        off = (closed.point(name).position.astype(object) - exact[name]).astype(float)
        worst = max(worst, float(np.linalg.norm(off, axis=1).max()) / length)
    return worst


def worst_angles(scene: Scene) -> Array:
    """Crank angles [rad] of one turn, most of them where the linkage comes closest to gaining a freedom."""
    turn = np.linspace(0.0, 2.0 * np.pi, SAMPLES, endpoint=False)
    offsets = np.concatenate([[0.0], np.geomspace(NARROW, WIDE, CLOSER)])
    near = [centre + sign * offsets for centre in _worst_poses(scene, turn) for sign in (-1.0, 1.0)]
    # Off the even samples, and off the quarters of a turn, where a closed form may be exact by chance.
    around = (np.arange(AROUND) + 0.4) * 2.0 * np.pi / AROUND
    return np.unique(np.remainder(np.concatenate([around, *near]), 2.0 * np.pi))


def _worst_poses(scene: Scene, turn: Array) -> list[float]:
    """Angles [rad] at which the condition of the joint equations is worst of all around them, to 1e-12 or so."""

    def condition(angle: Array) -> Array:
        return scene.kinematics.conditioning(scene.kinematics.poses(angle))

    values = condition(turn)
    least = np.flatnonzero((values < np.roll(values, 1)) & (values <= np.roll(values, -1)))
    centres, width = turn[least], np.full(len(least), turn[1])
    while len(centres) and width[0] > NARROW / 10.0:
        tried = centres[:, None] + width[:, None] * np.linspace(-1.0, 1.0, 9)
        best = condition(tried.ravel()).reshape(tried.shape).argmin(axis=1)
        centres, width = tried[np.arange(len(centres)), best], 0.25 * width
    return [float(centre) for centre in centres]


def fifty_digits(scene: Scene, angle: Array) -> Mapping[str, Digits]:
    """Observed points (T, 2) [m] at crank angles (T,), of the mechanism's own equations.

    Raises:
        ArithmeticError: the corrections do not become small.
    """
    kinematics = scene.kinematics
    equations, number = Equations(kinematics.mechanism), _numbers()
    poses = kinematics.poses(angle)
    arcs = equations.arcs(poses, "right")
    factors, exact_angle, exact = equations.elimination(poses, arcs), _exact(angle, number), _exact(poses, number)
    for _ in range(MOST_CORRECTIONS):
        # The correction has few digits, and needs no more: the next residual shows what it left.
        step = factors.solve([np.asarray(r, dtype=float) for r in equations.residual([exact], exact_angle, arcs)])
        exact = exact - step
        if np.abs(step).max() <= ENOUGH * equations.size:
            break
    else:
        raise ArithmeticError(f"{equations.mechanism.name}: no fifty digits after {MOST_CORRECTIONS} corrections")
    bodies = pose_jets(kinematics.mechanism, [exact])
    return {
        observed.name: np.column_stack(
            [np.broadcast_to(p.coefficients[0], len(angle)) for p in bodies[observed.body].point(observed.point)]
        )
        for observed in kinematics.mechanism.observed
    }


def _numbers() -> Any:
    """The class of numbers with fifty digits, of a context of its own, which numpy can take sines and roots of."""
    context = mpmath.mp.clone()
    context.dps = DIGITS
    for function in ("sin", "cos", "sqrt"):  # numpy asks an object for a method of its function's name
        setattr(context.mpf, function, lambda value, function=function: getattr(context, function)(value))
    return context.mpf


def _exact(values: Array, number: Any) -> Digits:
    exact: Digits = np.array([number(float(v)) for v in values.ravel()], dtype=object).reshape(values.shape)
    return exact
