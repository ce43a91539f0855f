"""Errors predicted from constraint violations alone, against the measured errors: the guard of the exact motion.

A state whose joints leave a residual r open is off by J^-1 r, to first order (docs/design.md, guard 6). No reference
motion enters the prediction, so it differs from the measured error by terms of second order and rounding, or else the
exact motion is wrong, or the state is not of the machine that it is compared with.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from conrod.comparison.compare import ComparedPiece
from conrod.comparison.outcome import CHANGE_POINT_DISTANCE
from conrod.comparison.trajectory import ArrayMapper, BodyStates, BodyTracks, PointTracks
from conrod.exact.kinematics import ExactReference, Kinematics
from conrod.exact.motion import QUANTITIES, Array, Instants
from conrod.execution.case import POINTS_PREFIX

# Some 450 last digits, as the golden results are held to: closed forms, solver and elimination round differently.
ROUNDING_SHARE = 1e-13  # of the mechanism's size
# The second Newton step is the error that the first one leaves, but for the steps after it. Where each is at most a
# quarter of the one before (Newton-Kantorovich asks for half), these add a third of it, in another direction.
MAX_CONTRACTION, REMAINDER_FACTOR = 0.25, 2.0
CONVERGED_STEP = 1e-9  # over the size: after a step this small only rounding follows, and contraction says nothing
# This near [rad] to where a roller passes to another arc of its cam, an acceleration may be that of either side.
MIN_ARC_END_DISTANCE = 1e-6
CHECKED_ANGLES, ANGLE_OFFSET = (
    24,
    0.37,
)  # of the turn or the pass, at which a reference is held to its own joint equations
# Engines may compute in single precision, and a point's motion by another way than a body's: some 30 last digits.
SINGLE_PRECISION = 2e-6
Rows = NDArray[np.intp] | slice
# Worst disagreement of a measured error with the one predicted from constraint violations: their difference, the
# difference that is allowed, and the crank angle [rad].
Misfit = Mapping[str, float]


@dataclass(frozen=True)
class CorrectedStates:
    """States of the bodies after one and two Newton steps on the joint equations, at the measured crank motion.

    Attributes:
        first, second: poses, rates, accelerations (T, 3 n) up to an order, after one step and after two.
        steps: largest entry (T,) of the first and of the second step, lengths over the mechanism's size.
        changes: largest entry (T,) by which poses, rates, accelerations were changed in the end [1, 1/s, 1/s^2].
    """

    first: list[Array]
    second: list[Array]
    steps: tuple[Array, Array]
    changes: list[Array]

    @classmethod
    def from_measured(cls, kinematics: Kinematics, states: BodyStates, order: int) -> CorrectedStates:
        """Correct measured poses by Newton steps, then rates and accelerations, which enter linearly."""
        at, measured = states.instants, (states.rates, states.accelerations)[:order]
        scale = np.tile([kinematics.size, kinematics.size, 1.0], states.poses.shape[1] // 3)
        poses, factors = states.poses, kinematics.factors(states.poses)
        found, steps = list[list[Array]](), list[Array]()
        for _ in range(2):
            step = factors.solve(list(kinematics.residual([poses], at.angle).T))
            poses = poses - step
            steps.append(np.abs(step / scale).max(axis=1))
            factors, mended = kinematics.factors(poses), [poses]
            for values, crank in zip(measured, (at.rate, at.acceleration), strict=False):
                residual = kinematics.residual([*mended, values], crank)
                mended.append(values - factors.solve(list(residual.T)))
            found.append(mended)
        pairs = zip((states.poses, *measured), found[1], strict=True)
        changes = [np.abs((values - mended) / scale).max(axis=1) for values, mended in pairs]
        return cls(found[0], found[1], (steps[0], steps[1]), changes)


def correct_states(kinematics: Kinematics, bodies: BodyTracks) -> dict[str, CorrectedStates]:
    """Corrected states by quantity; one object if the engine gives all quantities at one instant."""
    found: dict[int, CorrectedStates] = {}
    for order, quantity in reversed(list(enumerate(QUANTITIES))):
        states = getattr(bodies, quantity)
        if id(states) not in found:
            found[id(states)] = CorrectedStates.from_measured(kinematics, states, order)
    return {quantity: found[id(getattr(bodies, quantity))] for quantity in QUANTITIES}


def predicted_errors(
    kinematics: Kinematics, points: Mapping[str, PointTracks], bodies: BodyTracks
) -> dict[str, dict[str, Array]]:
    """Errors (T, 2) that constraint violations cause, by point and quantity [m, m/s, m/s^2].

    A state that violates the joint equations by a residual r is off, at the crank angle actually reached, by J^-1 r to
    first order; the same holds for rates and accelerations with the equations differentiated. No reference motion
    enters. If these errors are the ones measured against the exact motion, the difference is the engine's and not the
    reference's (docs/design.md, guard 6).
    """
    exact = {q: kinematics.point_derivatives(mended.first) for q, mended in correct_states(kinematics, bodies).items()}
    return {
        name: {q: getattr(tracks, q).values - exact[q][name][k] for k, q in enumerate(QUANTITIES)}
        for name, tracks in points.items()
    }


class Prediction:
    """Recorder of errors predicted from constraint violations, and of their difference from the measured errors.

    Args:
        stride: every n-th sample is compared, the last one included.

    Attributes:
        sizes: by quantity the largest predicted error, and its largest difference from the measured one.
        misfit: by quantity the sample where the two differ most, by what is allowed there; empty where no sample has a
            prediction.
    """

    def __init__(self, scene: ExactReference, stride: int = 1) -> None:
        self._scene, self._stride = scene, stride
        self.sizes = {q: {"predicted": 0.0, "difference": 0.0} for q in QUANTITIES}
        self.misfit: dict[str, Misfit] = {}

    def add(self, piece: ComparedPiece) -> None:
        kinematics, (points, bodies) = self._scene.kinematics, self._every_nth_sample(piece)
        for k, (quantity, mended) in enumerate(correct_states(kinematics, bodies).items()):
            once, twice = map(kinematics.point_derivatives, (mended.first, mended.second))
            for name, tracks in points.items():
                norm = self._scene.lengths[name] * abs(self._scene.speed) ** k
                track, sizes = getattr(tracks, quantity), self.sizes[quantity]
                expected = track.values - once[name][k]
                off = expected - piece.exact.error(track, name, quantity)
                for key, values in (("predicted", expected), ("difference", off)):
                    sizes[key] = float(np.max(np.linalg.norm(values, axis=1) / norm, initial=sizes[key]))
                left = twice[name][k] - once[name][k]
                found = worst_misfit(self._scene, mended, k, name, off, left, track.instants.angle)
                keep_worst(self.misfit, quantity, found)
            if quantity != "acceleration":  # of bodies it may be known to second order in the step alone
                self._compare_points_with_bodies(k, quantity, points, getattr(bodies, quantity))

    def _compare_points_with_bodies(
        self, order: int, quantity: str, points: Mapping[str, PointTracks], states: BodyStates
    ) -> None:
        """Compare the measured points with the measured bodies, in single-precision tolerance."""
        kinematics, angle = self._scene.kinematics, states.instants.angle
        of_bodies = kinematics.point_derivatives([states.poses, states.rates][: order + 1])
        for name, tracks in points.items():
            norm = self._scene.lengths[name] * abs(self._scene.speed) ** order
            values, held = getattr(tracks, quantity).values, of_bodies[name][order]
            apart = np.linalg.norm(values - held, axis=1) / norm
            size = (np.linalg.norm(values, axis=1) + np.linalg.norm(held, axis=1)) / norm
            allowed = SINGLE_PRECISION * (kinematics.size / self._scene.lengths[name] + size)
            share = np.nan_to_num(apart / allowed, nan=math.inf)
            if len(share):
                at = int(np.argmax(share))
                worst = {"difference": float(apart[at]), "allowed": float(allowed[at]), "angle": float(angle[at])}
                keep_worst(self.misfit, f"{POINTS_PREFIX} {quantity}", worst)

    def _every_nth_sample(self, piece: ComparedPiece) -> tuple[Mapping[str, PointTracks], BodyTracks]:
        if self._stride == 1:
            return piece.trajectory.points, piece.bodies
        cut = ArrayMapper(
            lambda parts: parts[0][(len(parts[0]) - 1 + piece.samples_remaining) % self._stride :: self._stride]
        )
        return {name: cut(tracks) for name, tracks in piece.trajectory.points.items()}, cut(piece.bodies)


def worst_misfit(
    reference: ExactReference, mended: CorrectedStates, order: int, name: str, off: Array, left: Array, angle: Array
) -> Misfit | None:
    """Find the sample where predicted and measured errors differ most, relative to the bound; None without samples.

    Allowed at a sample, over the length L of the point and the speed^order, with the mechanism's size S, the Newton
    steps e1 and e2 over S, k = 1 / (least singular value of the scaled Jacobian), the order n of the derivative:

        2 |left| + S / L (k^n |e2|^2 / |e1| + ROUNDING k^(n + 1) (1 + turns + c))

    The first Newton step leaves an error of second order, |e1|^2 / S by the curvature of the joints' equations times k:
    it is not estimated but computed, as what the second step changes of the point (`left`). The rest of the iteration
    is at most its next step, |e2|^2 / |e1| by quadratic convergence. Each solution of the linear system enlarges
    rounding k times, as each derivative asks for one more; an angle is known to eps of itself, and so is a derivative
    that mending changes by c times its usual size.

    Args:
        order: 0 for positions, 1 for velocities, 2 for accelerations.
        name: name of the observed point.
        off: predicted less measured error (T, 2) [SI].
        left: change (T, 2) [SI] of the point by the second Newton step.
        angle: crank angles (T,) [rad].
    """
    kinematics, length = reference.kinematics, reference.lengths[name]
    norm = length * abs(reference.speed) ** order
    difference, second = np.linalg.norm(off, axis=1) / norm, np.linalg.norm(left, axis=1) / norm
    one, two = mended.steps
    rest = two * np.minimum(np.divide(two, one, out=np.zeros_like(two), where=one > 0.0), 1.0)
    changed = mended.changes[order] / abs(reference.speed) ** order
    rounding = ROUNDING_SHARE * (1.0 + np.abs(angle) / (2.0 * math.pi) + changed)

    def bound_at(rows: Rows, gain: Array | float) -> Array:
        """Bound (len(rows),) of the difference at samples, for k = gain."""
        beyond = kinematics.size / length * (gain**order * rest[rows] + gain ** (order + 1) * rounding[rows])
        return np.asarray(REMAINDER_FACTOR * second[rows] + beyond)

    bounds, kept = bound_at(slice(None), 1.0), np.ones(len(angle), dtype=bool)
    doubtful = np.flatnonzero(~(difference <= bounds))
    if len(doubtful):
        # The Jacobian's singular values take longer than all else, and can only allow more.
        poses = mended.second[0][doubtful]
        kept[doubtful] = _predictable_samples(kinematics, poses, one[doubtful], two[doubtful], angle[doubtful])
        doubtful = doubtful[kept[doubtful]]
    if len(doubtful):
        bounds[doubtful] = bound_at(doubtful, 1.0 / kinematics.conditioning(mended.second[0][doubtful]))
    if not kept.any():
        return None
    share = np.where(kept, np.nan_to_num(difference / bounds, nan=math.inf), -1.0)
    worst = int(np.argmax(share))
    return {"difference": float(difference[worst]), "allowed": float(bounds[worst]), "angle": float(angle[worst])}


def _predictable_samples(
    kinematics: Kinematics, poses: Array, one: Array, two: Array, angle: Array
) -> NDArray[np.bool_]:
    """Mask (T,) of samples where Newton iteration reaches the exact pose, with smooth derivatives.

    Not so far off that the steps do not contract, nor next to a change point, or on the branch beyond it; nor where a
    roller passes from an arc of its cam to the next, and accelerations jump.
    """
    contracts = (two <= MAX_CONTRACTION * one) | (two <= CONVERGED_STEP)
    contracts &= ~kinematics.near_change(angle, CHANGE_POINT_DISTANCE)
    with np.errstate(all="ignore"):
        contracts &= kinematics.branch(poses) == kinematics.branch_at(angle)
    for end in kinematics.arc_ends if kinematics.mechanism.cam_contacts else ():
        apart = np.abs(np.remainder(angle - end + math.pi, 2.0 * math.pi) - math.pi)
        contracts &= apart > MIN_ARC_END_DISTANCE + two
    return np.asarray(contracts)


def keep_worst(kept: dict[str, Misfit], quantity: str, found: Misfit | None) -> None:
    """Keep the larger misfit of a quantity, relative to its bound; NaN counts as the largest."""
    known = kept.get(quantity)
    if found is None or (known is not None and math.isnan(known["difference"])):
        return
    if known is None or not found["difference"] * known["allowed"] <= known["difference"] * found["allowed"]:
        kept[quantity] = found


def merged_misfit(*several: Mapping[str, Misfit]) -> dict[str, Misfit]:
    """Worst misfit of each quantity over several sets."""
    kept: dict[str, Misfit] = {}
    for misfit in several:
        for quantity, found in misfit.items():
            keep_worst(kept, quantity, found)
    return kept


def reference_misfit(reference: ExactReference) -> dict[str, Misfit]:
    """Worst misfit, by quantity, of a reference with its joint equations; no engine takes part.

    The solver's motion at some angles is taken for a measured one: mended by a Newton step, which is written apart from
    the solver's iteration, it has to be what it was, and the closed form's, where there is one.
    """
    low, high = reference.kinematics.span
    angle = low + (high - low) * (np.arange(CHECKED_ANGLES) + ANGLE_OFFSET) / CHECKED_ANGLES
    states = BodyStates(_constant_speed_instants(reference, angle), *_solver_motion(reference, angle))
    return _states_misfit(reference, states, [states.poses, states.rates, states.accelerations])


def solved_misfit(reference: ExactReference, angle: Array, poses: Array) -> dict[str, Misfit]:
    """Compare a reference with poses (T, 3n) [m, m, rad] that an engine solved at crank angles (T,) [rad]."""
    still = np.zeros_like(poses)
    return _states_misfit(reference, BodyStates(_constant_speed_instants(reference, angle), poses, still, still))


def _constant_speed_instants(reference: ExactReference, angle: Array) -> Instants:
    """Instants at crank angles (T,) [rad] of a crank at the nominal speed."""
    return Instants(angle / reference.speed, angle, np.full_like(angle, reference.speed), np.zeros_like(angle))


def _solver_motion(reference: ExactReference, angle: Array) -> list[Array]:
    """Generic solver's poses, rates and accelerations (T, 3n) at the nominal crank speed."""
    derivatives = reference.kinematics.derivatives(angle, order=2)
    return [derivative * reference.speed**k for k, derivative in enumerate(derivatives)]


def _states_misfit(reference: ExactReference, states: BodyStates, solver: Sequence[Array] = ()) -> dict[str, Misfit]:
    """Misfits between corrected states and the exact motion, and the solver's motion if given."""
    kinematics, at = reference.kinematics, states.instants
    mended = CorrectedStates.from_measured(kinematics, states, 2)
    once, twice = map(kinematics.point_derivatives, (mended.first, mended.second))
    motions = [
        {name: vars(point) for name, point in reference.motion(at.angle, at.rate, at.acceleration).points.items()}
    ]
    if solver:
        found = kinematics.point_derivatives(list(solver))
        motions.append({name: dict(zip(QUANTITIES, values, strict=True)) for name, values in found.items()})
    kept: dict[str, Misfit] = {}
    for name in once:
        for k, quantity in enumerate(QUANTITIES):
            left = twice[name][k] - once[name][k]
            for motion in motions:
                off = motion[name][quantity] - once[name][k]
                keep_worst(kept, quantity, worst_misfit(reference, mended, k, name, off, left, at.angle))
    return kept
