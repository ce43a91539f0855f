"""Assembly of a machine in space with its driven joints prescribed, and the Taylor series of a pose.

Loops are closed by Newton's method. Redundant closures are normal in space, so redundant rows and columns are dropped
by singular values. Derivatives solve the closures' series coefficient by coefficient, with one Jacobian.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from conrod.errors import InvalidInput
from conrod.exact.motion import Array
from conrod.exact.space import COORDINATES, RATES, SpatialJoint, SpatialTree, displace, unit_displacements
from conrod.exact.space.drive_laws import DriveLaw
from conrod.exact.space.forward_kinematics import Poses, forward_kinematics
from conrod.exact.space.loop_closure import jacobian, residuals

# Singular values below this share of the largest are zero. Files of real machines give lengths to five digits, so that
# redundant loops contradict each other by as much.
RANK_TOLERANCE = 1e-5
MAX_NEWTON_STEPS, CLOSED_STEP = 60, 1e-14
ROUNDING_STEP = 1e-7  # smaller Newton steps that grow are rounding
MAX_MISFIT = 1e-2  # constraint violation, over the extent, of closures that contradict each other


@dataclass(frozen=True, eq=False)
class Knot:
    """A solved pose along the motion, used to predict the poses near it.

    Attributes:
        rates: Taylor coefficients of the rates in time (3, nv).
        rows, columns: bases of the Jacobian's column space (rows, r) and of its row space (free, r).
        values: singular values (n,) of the scaled Jacobian of the joints that are not driven.
    """

    time: float
    coordinates: Array
    rates: Array
    rows: Array
    columns: Array
    values: Array


class Assembly:
    """A machine with prescribed joints, whose loops can be closed at any time.

    Attributes:
        held: joints of all kinds that do not move: a floating base.
        free: indices of the rates that the closures determine.
        coordinate_sizes, rate_sizes: displacement [m] per unit of each coordinate (nq, 1) and of each rate (nv,).
        weights: weights of the free rates, 1 / `rate_sizes`.
        step_sizes: sizes (nv, 1) in which the length of a Newton step is measured.
    """

    def __init__(self, tree: SpatialTree, laws: Mapping[str, DriveLaw], held: tuple[str, ...] = ()) -> None:
        by_name = {joint.name: joint for joint in tree.joints}
        self.tree, self.laws, self.held = tree, laws, held
        self.driven: tuple[SpatialJoint, ...] = tuple(by_name[name] for name in laws)
        taken = {rate for name in (*laws, *held) for rate in range(tree.freedom)[by_name[name].rates]}
        self.free = np.array([rate for rate in range(tree.freedom) if rate not in taken], dtype=int)
        # Displacement [m] by a unit change of each coordinate, and of each rate.
        self.coordinate_sizes = np.concatenate(
            [[], *(unit_displacements(tree, joint, COORDINATES) for joint in tree.joints)]
        )[:, None]
        self.rate_sizes = np.concatenate([[], *(unit_displacements(tree, joint, RATES) for joint in tree.joints)])
        self.weights = 1.0 / self.rate_sizes[self.free]
        # Steps are measured in rad, and in m or in extents of a machine that is larger than 1 m.
        self.step_sizes = np.minimum(self.rate_sizes / tree.extent, 1.0)[:, None]

    # -- poses -----------------------------------------------------------------------------------------------------

    def with_driven_joints(self, coordinates: Array, times: Array) -> Array:
        """Coordinates (nq, T) with the driven joints where their laws put them at times (T,) [s]."""
        made = np.array(coordinates)
        for joint, law in zip(self.driven, self.laws.values(), strict=True):
            made[joint.coordinate] = law.derivatives(times)[0]
        return made

    def close_loops(self, coordinates: Array, time: Array | float) -> tuple[Array, float]:
        """Return coordinates (nq, T) of the nearest closed poses, and the largest violation that remains [m].

        Args:
            coordinates: (nq, T).
            time: times (T,) [s], or the time of a single pose.

        Raises:
            InvalidInput: the loops cannot be closed; names the first time at which they stay open.
        """
        times = np.atleast_1d(np.asarray(time, dtype=float))
        here, largest = self.with_driven_joints(coordinates, times), 0.0
        # Poses that are not closed yet, and the sizes of their last steps.
        going, before = np.arange(len(times)), np.full(len(times), math.inf)
        for _ in range(MAX_NEWTON_STEPS):
            found = forward_kinematics(self.tree, here[:, going])
            left, matrix = _violations(found, len(going)), self.scaled_jacobians(found, len(going))
            finite = np.isfinite(left).all(axis=0) & np.isfinite(matrix).all(axis=(1, 2))
            if not finite.all():
                going = going[~finite]
                break
            step = np.zeros((self.tree.freedom, len(going)))
            if matrix.size:
                shortest = np.linalg.pinv(matrix, rcond=RANK_TOLERANCE) @ left.T[:, :, None]
                step[self.free] = -self.weights[:, None] * shortest[:, :, 0].T
            moved, size = displace(self.tree, here[:, going], step), np.abs(step).max(axis=0, initial=0.0)
            here[:, going] = moved
            ended = size <= CLOSED_STEP * (1.0 + np.abs(moved).max(axis=0))
            ended |= (0.5 * before < size) & (size < ROUNDING_STEP)
            if ended.any():
                remaining = _violations(forward_kinematics(self.tree, moved[:, ended]), int(ended.sum()))
                gaps = np.abs(remaining).max(axis=0, initial=0.0)
                if np.any(is_open := ~(gaps <= MAX_MISFIT * self.tree.extent)):
                    going = going[ended][is_open]
                    break
                largest = max(largest, float(gaps.max()))
            going, before, moved, step = going[~ended], size[~ended], moved[:, ~ended], step[:, ~ended]
            if not len(going):
                return here, largest
            length = np.abs(self.step_sizes * step).max(axis=0, initial=0.0)
            if length.max() > 0.5:  # a step this long is no correction any more
                share = np.where(length > 0.5, 0.5 / np.maximum(length, 0.5) - 1.0, 0.0)
                here[:, going] = displace(self.tree, moved, step * share)
        first = int(going[0])
        said = self.worst_closure_message(here[:, first : first + 1])
        raise InvalidInput(f"its loops do not close {self.describe_drives(float(times[first]))}: {said}")

    def worst_closure_message(self, coordinates: Array) -> str:
        """Sentence naming the closure with the largest violation."""
        left = np.abs(residuals(forward_kinematics(self.tree, coordinates), 0)[0, :, 0])
        by_name = {name: float(left[rows].max()) for name, rows in self.tree.rows.items()}
        worst = max(by_name, key=lambda name: by_name[name])
        return f"{worst} stays open by {1e3 * by_name[worst]:.3g} mm"

    def describe_drives(self, time: float) -> str:
        """Driven coordinates at a time, as a phrase of an error message."""
        at = []
        for joint, law in zip(self.driven, self.laws.values(), strict=True):
            value = float(law.derivatives(np.array([time]))[0, 0])
            at.append(f"{joint.name} at {np.degrees(value):.5g} deg" if joint.unit == "rad" else
                      f"{joint.name} at {1e3 * value:.5g} mm")  # fmt: skip
        return f"with {', '.join(at)}" if at else "at its start pose"

    def scaled_jacobian(self, found: Poses) -> Array:
        """Jacobian (rows, free) of the closures by the free rates in one pose, rotations in m of the extent."""
        return np.asarray(self.scaled_jacobians(found, 1)[0])

    def scaled_jacobians(self, found: Poses, samples: int) -> Array:
        """Jacobians (T, rows, free), as `scaled_jacobian`, in T poses."""
        return np.asarray(jacobian(found, samples)[:, :, self.free] * self.weights)

    def solve_knots(self, coordinates: Array, times: Array, poses: Poses | None = None) -> list[Knot]:
        """Derivatives and closure bases of closed poses (nq, T) at times (T,) [s]; `poses` are its bodies', if known.

        The knots end before the first at which the closures' Jacobian has another rank than at the first time.
        """
        poses = forward_kinematics(self.tree, coordinates) if poses is None else poses
        matrix = self.scaled_jacobians(poses, len(times))
        samples, height, width = matrix.shape
        rows, values, columns = np.zeros((samples, height, 0)), np.zeros((samples, 0)), np.zeros((samples, 0, width))
        ranks = np.zeros(samples, dtype=int)
        if matrix.size:
            rows, values, columns = np.linalg.svd(matrix)
            ranks = np.sum(values > RANK_TOLERANCE * values[:, :1], axis=1)
        rank = int(ranks[0])
        if (other := ranks != rank).any():
            same = int(np.argmax(other))
            return self.solve_knots(coordinates[:, :same], times[:same])
        bases = rows[:, :, :rank], self.weights[:, None] * np.swapaxes(columns[:, :rank], 1, 2)
        rates = self.rate_series(coordinates, times, *bases, poses=poses)
        return [
            Knot(float(times[k]), coordinates[:, k : k + 1], rates[:, :, k], bases[0][k], bases[1][k], values[k])
            for k in range(samples)
        ]

    def rate_series(
        self,
        coordinates: Array,
        times: Array,
        rows: Array,
        columns: Array,
        order: int = 3,
        *,
        poses: Poses | None = None,
    ) -> Array:
        """Taylor coefficients in time of all rates (order, nv, T) at closed poses (nq, T).

        Args:
            rows, columns: bases (T, rows, r) and (T, free, r) in which the closures determine the free rates.
            poses: the bodies' poses at these coordinates, if they are known.
        """
        rates = np.zeros((order, self.tree.freedom, len(times)))
        for joint, law in zip(self.driven, self.laws.values(), strict=True):
            for k, row in enumerate(law.derivatives(times)[1 : order + 1]):
                rates[k, joint.rate] = row / math.factorial(k)
        if not rows.shape[2]:
            return rates
        poses = forward_kinematics(self.tree, coordinates) if poses is None else poses
        matrix = self.reduced_jacobian(poses, rows, columns)
        for k in range(order):
            left = residuals(forward_kinematics(self.tree, coordinates, rates[: k + 1]), k + 1)[k + 1]
            seen = (k + 1) * np.einsum("tmr,mt->tr", rows, left)
            rates[k, self.free] = np.einsum("tfr,tr->ft", columns, self.solve_reduced(matrix, -seen, times))
        return rates

    def solve_reduced(self, matrix: Array, right: Array, times: Array) -> Array:
        """Solve the closures' reduced equations (T, r) at times (T,).

        Raises:
            InvalidInput: the equations are singular at a time; names the pose.
        """
        try:
            return np.asarray(np.linalg.solve(matrix, right[:, :, None])[:, :, 0])
        except np.linalg.LinAlgError:
            worst = int(np.argmin(np.linalg.svd(matrix, compute_uv=False)[:, -1]))
            raise InvalidInput(self.singular_message(float(times[worst]))) from None

    def singular_message(self, time: float) -> str:
        """Error message for a time at which the closures do not determine how the machine moves on."""
        drives = self.describe_drives(time)
        return f"it is singular {drives}: a change point or a dead centre, where it could go on otherwise"

    def reduced_jacobian(self, found: Poses, rows: Array, columns: Array) -> Array:
        """Jacobian (T, r, r) of the closures by the free rates, projected by given row and column bases."""
        matrix = jacobian(found, len(rows))[:, :, self.free]
        return np.asarray(np.swapaxes(rows, 1, 2) @ matrix @ columns)

    def most_moved_joints(self, directions: Array) -> list[str]:
        """Names of the joints that directions (free, k) move most, largest first, at most six."""
        share = np.abs(directions).max(axis=1)
        names = [joint.name for joint in self.tree.joints for _ in range(RATES[joint.kind])]
        return list(dict.fromkeys(names[self.free[i]] for i in np.argsort(-share) if share[i] > 1e-3))[:6]


def _violations(found: Poses, samples: int) -> Array:
    """Constraint violations (rows, T) of the closures in T poses [m]."""
    left = residuals(found, 0)[0]
    return np.broadcast_to(left, (len(left), samples))
