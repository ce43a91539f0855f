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

    def close_loops(self, coordinates: Array, time: float) -> tuple[Array, float]:
        """Return coordinates (nq, 1) of the nearest closed pose, and the constraint violation that remains [m].

        Raises:
            InvalidInput: the loops cannot be closed.
        """
        here, before = self.with_driven_joints(coordinates, np.array([time])), math.inf
        for _ in range(MAX_NEWTON_STEPS):
            found = forward_kinematics(self.tree, here)
            left, matrix = residuals(found, 0)[0, :, 0], self.scaled_jacobian(found)
            if not (np.all(np.isfinite(left)) and np.all(np.isfinite(matrix))):
                break
            step = np.zeros((self.tree.freedom, 1))
            if matrix.size:
                step[self.free, 0] = -self.weights * np.linalg.lstsq(matrix, left, rcond=RANK_TOLERANCE)[0]
            here = displace(self.tree, here, step)
            size = float(np.abs(step).max(initial=0.0))
            if size <= CLOSED_STEP * (1.0 + np.abs(here).max()) or 0.5 * before < size < ROUNDING_STEP:
                gap = float(np.abs(residuals(forward_kinematics(self.tree, here), 0)).max(initial=0.0))
                if gap <= MAX_MISFIT * self.tree.extent:
                    return here, gap
                break
            length = float(np.abs(self.step_sizes * step).max(initial=0.0))
            if length > 0.5:  # a step this long is no correction any more
                here = displace(self.tree, here, step * (0.5 / length - 1.0))
            before = size
        raise InvalidInput(f"its loops do not close {self.describe_drives(time)}: {self.worst_closure_message(here)}")

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
        """Jacobian (rows, free) of the closures by the free rates, rotations in m of the extent."""
        return np.asarray(jacobian(found, 1)[0][:, self.free] * self.weights)

    def knot(self, coordinates: Array, time: float, poses: Poses | None = None) -> Knot:
        """Derivatives and closure bases of a closed pose (nq, 1) at a time [s]; `poses` are its bodies', if known."""
        poses = forward_kinematics(self.tree, coordinates) if poses is None else poses
        matrix = self.scaled_jacobian(poses)
        rank = 0
        rows, values, columns = np.zeros((len(matrix), 0)), np.zeros(0), np.zeros((0, len(self.free)))
        if matrix.size:
            rows, values, columns = np.linalg.svd(matrix)
            rank = int(np.sum(values > RANK_TOLERANCE * values[0]))
        basis = rows[:, :rank], self.weights[:, None] * columns[:rank].T
        rates = self.rate_series(coordinates, np.array([time]), basis[0][None], basis[1][None], poses=poses)
        return Knot(time, coordinates, rates[:, :, 0], *basis, values)

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
