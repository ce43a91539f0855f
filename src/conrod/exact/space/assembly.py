"""Assembly of a machine in space with its driven joints at the places of a time, and the derivatives of a pose.

The loops are closed by Newton's method, with rows and columns that are redundant left out by singular values: redundant
closures are normal in space. Derivatives solve the closures' series, coefficient by coefficient, with one Jacobian.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from conrod.errors import InvalidInput
from conrod.exact.motion import Array
from conrod.exact.space import COORDINATES, RATES, SpatialJoint, SpatialTree, lengths, moved
from conrod.exact.space.closing import jacobian, residuals
from conrod.exact.space.laws import Law
from conrod.exact.space.poses import Poses, poses

# Singular values below this share of the largest are zero. The files of real machines have lengths of five digits,
# by which loops that are redundant contradict each other.
RANK_TOLERANCE = 1e-5
NEWTON_STEPS, CLOSED = 60, 1e-14
FINE = 1e-7  # steps of a pose that are below this, and grow, are rounding
# What a machine may stay open by, against its extent, where its closures contradict each other.
MISFIT = 1e-2


@dataclass(frozen=True, eq=False)
class Knot:
    """A pose on the way.

    Attributes:
        rates: coefficients of the rates' series (3, nv).
        rows, columns: bases of what the closures see and of what they hold (rows, r) and (free, r).
        values: singular values (n,) of the scaled Jacobian of the joints that are not driven.
    """

    time: float
    coordinates: Array
    rates: Array
    rows: Array
    columns: Array
    values: Array


class Assembly:
    """A machine with its drives, to be placed at a time.

    Attributes:
        held: joints of all kinds that stay where they are: a floating base.
        free: rates that the closures determine.
    """

    def __init__(self, tree: SpatialTree, laws: Mapping[str, Law], held: tuple[str, ...] = ()) -> None:
        by_name = {joint.name: joint for joint in tree.joints}
        self.tree, self.laws, self.held = tree, laws, held
        self.driven: tuple[SpatialJoint, ...] = tuple(by_name[name] for name in laws)
        taken = {rate for name in (*laws, *held) for rate in range(tree.freedom)[by_name[name].rates]}
        self.free = np.array([rate for rate in range(tree.freedom) if rate not in taken], dtype=int)
        # What a change of each coordinate, and of each rate, moves [m].
        self.reach = np.concatenate([[], *(lengths(tree, joint, COORDINATES) for joint in tree.joints)])[:, None]
        self.sweep = np.concatenate([[], *(lengths(tree, joint, RATES) for joint in tree.joints)])
        self.weights = 1.0 / self.sweep[self.free]
        # Of a long step: turns in rad, lengths in m, or in extents of a machine, or a unit, that is larger.
        self.stride = np.minimum(self.sweep / tree.extent, 1.0)[:, None]

    # -- poses -----------------------------------------------------------------------------------------------------

    def placed(self, coordinates: Array, times: Array) -> Array:
        """Coordinates (nq, T) with the driven joints where their laws have them."""
        made = np.array(coordinates)
        for joint, law in zip(self.driven, self.laws.values(), strict=True):
            made[joint.coordinate] = law.derivatives(times)[0]
        return made

    def closed(self, coordinates: Array, time: float) -> tuple[Array, float]:
        """Coordinates (nq, 1) of the closed pose nearest to these, and what stays open [m].

        Raises:
            InvalidInput: the loops cannot be closed.
        """
        here, before = self.placed(coordinates, np.array([time])), math.inf
        for _ in range(NEWTON_STEPS):
            found = poses(self.tree, here)
            left, matrix = residuals(found, 0)[0, :, 0], self.scaled(found)
            if not (np.all(np.isfinite(left)) and np.all(np.isfinite(matrix))):
                break
            step = np.zeros((self.tree.freedom, 1))
            if matrix.size:
                step[self.free, 0] = -self.weights * np.linalg.lstsq(matrix, left, rcond=RANK_TOLERANCE)[0]
            here = moved(self.tree, here, step)
            size = float(np.abs(step).max(initial=0.0))
            if size <= CLOSED * (1.0 + np.abs(here).max()) or 0.5 * before < size < FINE:
                gap = float(np.abs(residuals(poses(self.tree, here), 0)).max(initial=0.0))
                if gap <= MISFIT * self.tree.extent:
                    return here, gap
                break
            length = float(np.abs(self.stride * step).max(initial=0.0))
            if length > 0.5:  # a step this long is no correction any more
                here = moved(self.tree, here, step * (0.5 / length - 1.0))
            before = size
        raise InvalidInput(f"its loops do not close {self.where(time)}: {self.open_closure(here)}")

    def open_closure(self, coordinates: Array) -> str:
        """The closure that is furthest open, in words."""
        left = np.abs(residuals(poses(self.tree, coordinates), 0)[0, :, 0])
        by_name = {name: float(left[rows].max()) for name, rows in self.tree.rows.items()}
        worst = max(by_name, key=lambda name: by_name[name])
        return f"{worst} stays open by {1e3 * by_name[worst]:.3g} mm"

    def where(self, time: float) -> str:
        """The driven coordinates at a time, in words."""
        at = []
        for joint, law in zip(self.driven, self.laws.values(), strict=True):
            value = float(law.derivatives(np.array([time]))[0, 0])
            at.append(f"{joint.name} at {np.degrees(value):.5g} deg" if joint.unit == "rad" else
                      f"{joint.name} at {1e3 * value:.5g} mm")  # fmt: skip
        return f"with {', '.join(at)}" if at else "at its start pose"

    def scaled(self, found: Poses) -> Array:
        """The Jacobian of what is not driven (rows, free), its turns in m of the extent."""
        return np.asarray(jacobian(found, 1)[0][:, self.free] * self.weights)

    def knot(self, coordinates: Array, time: float) -> Knot:
        """A closed pose with its derivatives, and the bases of its closures."""
        matrix = self.scaled(poses(self.tree, coordinates))
        rank = 0
        rows, values, columns = np.zeros((len(matrix), 0)), np.zeros(0), np.zeros((0, len(self.free)))
        if matrix.size:
            rows, values, columns = np.linalg.svd(matrix)
            rank = int(np.sum(values > RANK_TOLERANCE * values[0]))
        basis = rows[:, :rank], self.weights[:, None] * columns[:rank].T
        rates = self.derived(coordinates, np.array([time]), basis[0][None], basis[1][None])
        return Knot(time, coordinates, rates[:, :, 0], *basis, values)

    def derived(self, coordinates: Array, times: Array, rows: Array, columns: Array, order: int = 3) -> Array:
        """Coefficients of the series of all rates (order, nv, T)."""
        rates = np.zeros((order, self.tree.freedom, len(times)))
        for joint, law in zip(self.driven, self.laws.values(), strict=True):
            for k, row in enumerate(law.derivatives(times)[1 : order + 1]):
                rates[k, joint.rate] = row / math.factorial(k)
        if not rows.shape[2]:
            return rates
        matrix = self.reduced(poses(self.tree, coordinates), rows, columns)
        for k in range(order):
            left = residuals(poses(self.tree, coordinates, rates[: k + 1]), k + 1)[k + 1]
            seen = (k + 1) * np.einsum("tmr,mt->tr", rows, left)
            rates[k, self.free] = np.einsum("tfr,tr->ft", columns, self.solved(matrix, -seen, times))
        return rates

    def solved(self, matrix: Array, right: Array, times: Array) -> Array:
        """Solution (T, r) of the closures' reduced equations at times (T,).

        Raises:
            InvalidInput: they are singular at one of them; names the pose.
        """
        try:
            return np.asarray(np.linalg.solve(matrix, right[:, :, None])[:, :, 0])
        except np.linalg.LinAlgError:
            worst = int(np.argmin(np.linalg.svd(matrix, compute_uv=False)[:, -1]))
            raise InvalidInput(self.singular(float(times[worst]))) from None

    def singular(self, time: float) -> str:
        """What is wrong with a pose at a time where the closures do not determine how the machine goes on, in words."""
        return f"it is singular {self.where(time)}: a change point or a dead centre, where it could go on otherwise"

    def reduced(self, found: Poses, rows: Array, columns: Array) -> Array:
        """The Jacobian in the bases of its knots (T, r, r)."""
        matrix = jacobian(found, len(rows))[:, :, self.free]
        return np.asarray(np.swapaxes(rows, 1, 2) @ matrix @ columns)

    def joints_of(self, directions: Array) -> list[str]:
        """Names of the joints that directions (free, k) move, those that move most first, six at most."""
        share = np.abs(directions).max(axis=1)
        names = [joint.name for joint in self.tree.joints for _ in range(RATES[joint.kind])]
        return list(dict.fromkeys(names[self.free[i]] for i in np.argsort(-share) if share[i] > 1e-3))[:6]
