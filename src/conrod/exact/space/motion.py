"""Exact motion of a machine in space whose joints are driven by laws: assembly, branch and derivatives to jerk.

The loops are closed by Newton's method, with rows and columns that are redundant left out by singular values: redundant
closures are normal in space. Along the motion each pose is predicted by the Taylor series of the one before it, so that
it stays on the branch; all samples are then solved at once from the poses on the way. Derivatives solve the closures'
series, coefficient by coefficient, with the same Jacobian.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from conrod.errors import InvalidInput
from conrod.exact.motion import Array, PointMotion
from conrod.exact.space.closing import jacobian, residuals
from conrod.exact.space.coordinates import lengths, moved
from conrod.exact.space.laws import Law, quintic
from conrod.exact.space.poses import Poses, poses
from conrod.exact.space.tree import COORDINATES, RATES, SpatialJoint, SpatialTree

# Singular values below this share of the largest are zero. The files of real machines have lengths of five digits,
# by which loops that are redundant contradict each other.
RANK_TOLERANCE = 1e-5
NEWTON_STEPS, CLOSED = 60, 1e-14
# Steps of a pose that are below this, and grow, are rounding. The square of a sample's last step is rounding; before
# it the loops are open by no more than this share of the extent.
FINE, LAST_STEP, NEARLY = 1e-7, 1e-9, 1e-7
# Poses of a law's course at least, and of a way at most; the shortest step; a pose may be this share of the step off
# its prediction.
POSES, MOST_POSES, LEAST_STEP, STRAYED = 48, 20_000, 1e-7, 0.03
# What a machine may stay open by, against its extent, where its closures contradict each other.
MISFIT = 1e-2
TOGETHER = 2048  # samples


@dataclass(frozen=True, eq=False)
class SpatialMotion:
    """Exact motion at T times.

    Attributes:
        times: (T,) [s].
        coordinates: (nq, T).
        rates: rates, accelerations and jerks of all joints (3, nv, T).
        points: of all points that the drives determine: position, velocity, acceleration and jerk (T, 3).
    """

    times: Array
    coordinates: Array
    rates: Array
    points: Mapping[str, PointMotion]


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


class DrivenTree:
    """A machine with its drives.

    Attributes:
        held: joints of all kinds that stay where they are: a floating base.
        free: rates that the closures determine.
        knots: poses on the way, in the order of time; made by `go`.
        misfit: what stays open at most at these [m], where closures contradict each other.
    """

    def __init__(self, tree: SpatialTree, laws: Mapping[str, Law], held: tuple[str, ...] = ()) -> None:
        by_name = {joint.name: joint for joint in tree.joints}
        self.tree, self.laws, self.held = tree, laws, held
        self.driven: tuple[SpatialJoint, ...] = tuple(by_name[name] for name in laws)
        taken = {rate for name in (*laws, *held) for rate in range(tree.freedom)[by_name[name].rates]}
        self.free = np.array([rate for rate in range(tree.freedom) if rate not in taken], dtype=int)
        # What a change of each coordinate, and of each rate, moves [m].
        self._reach = np.concatenate([[], *(lengths(tree, joint, COORDINATES) for joint in tree.joints)])[:, None]
        self._sweep = np.concatenate([[], *(lengths(tree, joint, RATES) for joint in tree.joints)])
        self.weights = 1.0 / self._sweep[self.free]
        self.knots: list[Knot] = []
        self.misfit = 0.0

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
            left, matrix = residuals(found, 0)[0, :, 0], self._scaled(found)
            step = np.zeros((self.tree.freedom, 1))
            if matrix.size:
                step[self.free, 0] = -self.weights * np.linalg.lstsq(matrix, left, rcond=RANK_TOLERANCE)[0]
            here = moved(self.tree, here, step)
            if not np.all(np.isfinite(here)):
                break
            size = float(np.abs(step).max(initial=0.0))
            if size <= CLOSED * (1.0 + np.abs(here).max()) or 0.5 * before < size < FINE:
                gap = float(np.abs(residuals(poses(self.tree, here), 0)).max(initial=0.0))
                if gap <= MISFIT * self.tree.extent:
                    return here, gap
                break
            if size > 0.5:  # a step this long is no correction any more
                here = moved(self.tree, here, step * (0.5 / size - 1.0))
            before = size
        raise InvalidInput(f"its loops do not close {self.where(time)}: {self.open_closure(here)}")

    def assembled(self) -> Array:
        """Closed pose (nq, 1) that the laws begin in, on the branch of the tree's start.

        Raises:
            InvalidInput: the loops cannot be closed there, or the drives not go from there to where their laws begin.
        """
        start, ways = self.tree.start[:, None], dict[str, Law]()
        for joint, law in zip(self.driven, self.laws.values(), strict=True):
            begin, end = float(start[joint.coordinate, 0]), float(law.derivatives(np.zeros(1))[0, 0])
            ways[joint.name] = Law(law.text, 1.0, quintic(begin, end, 1.0))
        if any(way.derivatives(np.array([0.5]))[1, 0] for way in ways.values()):
            there = DrivenTree(self.tree, ways, self.held)
            there.go(there.closed(start, 0.0)[0], 1.0)
            start = there.knots[-1].coordinates
        return self.closed(start, 0.0)[0]

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

    def _scaled(self, found: Poses) -> Array:
        """The Jacobian of what is not driven (rows, free), its turns in m of the extent."""
        return np.asarray(jacobian(found, 1)[0][:, self.free] * self.weights)

    def knot(self, coordinates: Array, time: float) -> Knot:
        """A closed pose with its derivatives, and the bases of its closures."""
        matrix = self._scaled(poses(self.tree, coordinates))
        rank = 0
        rows, values, columns = np.zeros((len(matrix), 0)), np.zeros(0), np.zeros((0, len(self.free)))
        if matrix.size:
            rows, values, columns = np.linalg.svd(matrix)
            rank = int(np.sum(values > RANK_TOLERANCE * values[0]))
        basis = rows[:, :rank], self.weights[:, None] * columns[:rank].T
        rates = self._derivatives(coordinates, np.array([time]), basis[0][None], basis[1][None])
        return Knot(time, coordinates, rates[:, :, 0], *basis, values)

    def _derivatives(self, coordinates: Array, times: Array, rows: Array, columns: Array, order: int = 3) -> Array:
        """Coefficients of the series of all rates (order, nv, T)."""
        rates = np.zeros((order, self.tree.freedom, len(times)))
        for joint, law in zip(self.driven, self.laws.values(), strict=True):
            for k, row in enumerate(law.derivatives(times)[1 : order + 1]):
                rates[k, joint.rate] = row / math.factorial(k)
        if not rows.shape[2]:
            return rates
        matrix = self._reduced(poses(self.tree, coordinates), rows, columns)
        for k in range(order):
            left = residuals(poses(self.tree, coordinates, rates[: k + 1]), k + 1)[k + 1]
            seen = (k + 1) * np.einsum("tmr,mt->tr", rows, left)
            found = np.linalg.solve(matrix, -seen[:, :, None])[:, :, 0]
            rates[k, self.free] = np.einsum("tfr,tr->ft", columns, found)
        return rates

    def _reduced(self, found: Poses, rows: Array, columns: Array) -> Array:
        """The Jacobian in the bases of its knots (T, r, r)."""
        matrix = jacobian(found, len(rows))[:, :, self.free]
        return np.asarray(np.swapaxes(rows, 1, 2) @ matrix @ columns)

    # -- along the motion --------------------------------------------------------------------------------------------

    def go(self, start: Array, duration: float) -> None:
        """Follow the branch of a closed pose (nq, 1) from time 0 for a duration [s].

        Raises:
            InvalidInput: the loops let it go no further, or it is singular on the way; its laws repeat too often.
        """
        here = self.knot(start, 0.0)
        self.knots, self.misfit = [here], float(np.abs(residuals(poses(self.tree, start), 0)).max(initial=0.0))
        longest = step = min(duration, *(law.duration for law in self.laws.values())) / POSES
        if duration > MOST_POSES * longest:
            most = f"its fastest drive repeats too often in that time: {MOST_POSES * longest:.3g} s at most"
            raise InvalidInput(f"{duration:g} s: {most}")
        while here.time < duration:
            time = duration if duration - here.time <= 1.001 * step else here.time + step
            following = self._next(here, time)
            if following is None:
                step *= 0.5
                if step < LEAST_STEP * duration:
                    raise InvalidInput(self._stuck(here))
                continue
            here = following
            self.knots.append(here)
            step = min(2.0 * step, longest)

    def _next(self, here: Knot, time: float) -> Knot | None:
        """The closed pose after one, where it is near its prediction."""
        way = _way(here.rates, time - here.time)
        predicted = self.placed(moved(self.tree, here.coordinates, way[:, None]), np.array([time]))
        try:
            found, gap = self.closed(predicted, time)
        except InvalidInput:
            return None
        strayed, gone = self._reach * np.abs(found - predicted), self._sweep * np.abs(way)
        if strayed.max() > STRAYED * gone.max() + 1e-9 * self.tree.extent:
            return None
        # Where branches meet the determinant is 0, and beyond its sign is another; at a knot it is positive.
        if np.linalg.det(self._reduced(poses(self.tree, found), here.rows[None], here.columns[None]))[0] <= 0.0:
            return None
        knot = self.knot(found, time)
        if knot.rows.shape != here.rows.shape:
            return None
        self.misfit = max(self.misfit, gap)
        return knot

    def _stuck(self, here: Knot) -> str:
        """Why it goes no further."""
        rank = here.rows.shape[1]
        margin = here.values[rank - 1] / here.values[0] if rank else 1.0
        loose = self.joints_of(np.linalg.svd(here.columns)[0][:, :1] if not rank else self._weakest(here))
        return (
            f"it goes no further than {self.where(here.time)} ({here.time:.6g} s): a dead centre, or its loops reach "
            f"no further; there {', '.join(loose)} move most (singular value {margin:.1g} of the largest)"
        )

    def _weakest(self, here: Knot) -> Array:
        """The direction (free, 1) that the closures hold least."""
        matrix = self._scaled(poses(self.tree, here.coordinates))
        return np.asarray(np.linalg.svd(matrix)[2][here.rows.shape[1] - 1][:, None])

    def joints_of(self, directions: Array) -> list[str]:
        """Names of the joints that directions (free, k) move, those that move most first, six at most."""
        share = np.abs(directions).max(axis=1)
        by_size = (int(i) for i in np.argsort(-share) if share[i] > 1e-3)
        return list(dict.fromkeys(self.tree.joint_of_rate(int(self.free[i])).name for i in by_size))[:6]

    # -- at samples --------------------------------------------------------------------------------------------------

    def motion(self, times: Array, order: int = 3) -> SpatialMotion:
        """The exact motion at times (T,) [s] of the way that `go` went.

        Args:
            order: 2 for velocities and accelerations alone; jerks are 0 then.
        """
        parts = [self._solved(times[k : k + TOGETHER], order) for k in range(0, len(times), TOGETHER)]
        coordinates, series, points = (list(column) for column in zip(*parts, strict=True))
        made = {name: PointMotion(*np.concatenate([one[name] for one in points], axis=1)) for name in self.tree.points}
        return SpatialMotion(times, np.concatenate(coordinates, axis=1), np.concatenate(series, axis=2), made)

    def _solved(self, times: Array, order: int) -> tuple[Array, Array, dict[str, Array]]:
        coordinates, rows, columns = self._predicted(times)
        if rows.shape[2]:
            coordinates = self._corrected(coordinates, times, rows, columns)
        rates = self._derivatives(coordinates, times, rows, columns, order)
        final = poses(self.tree, coordinates, rates)
        return coordinates, _padded(rates), {name: _motion(final, name, len(times)) for name in self.tree.points}

    def _corrected(self, coordinates: Array, times: Array, rows: Array, columns: Array) -> Array:
        """Closed poses (nq, T) near predicted ones; raises InvalidInput where there is none."""
        bearable = 3.0 * self.misfit + NEARLY * self.tree.extent
        for _ in range(NEWTON_STEPS):
            found = poses(self.tree, coordinates)
            matrix, left = self._reduced(found, rows, columns), residuals(found, 0)[0]
            seen = np.einsum("tmr,mt->tr", rows, left)
            step = np.zeros((self.tree.freedom, len(times)))
            step[self.free] = np.einsum("tfr,tr->ft", columns, np.linalg.solve(matrix, -seen[:, :, None])[:, :, 0])
            coordinates = moved(self.tree, coordinates, step)
            if np.abs(step).max() <= LAST_STEP and np.abs(left).max() <= bearable:
                if np.all(np.linalg.det(matrix) > 0.0):
                    return coordinates
                break
        worst = int(np.argmax(np.abs(left).max(axis=0)))
        stays = self.open_closure(coordinates[:, worst : worst + 1])
        raise InvalidInput(f"its loops do not close {self.where(float(times[worst]))}: {stays}")

    def _predicted(self, times: Array) -> tuple[Array, Array, Array]:
        """Poses (nq, T) by the series of the nearest knots, and those knots' bases (T, rows, r) and (T, free, r)."""
        at = np.array([knot.time for knot in self.knots])
        nearest = np.abs(at[:, None] - times).argmin(axis=0)
        elapsed = times - at[nearest]
        ways = _way(np.array([knot.rates for knot in self.knots])[nearest].transpose(1, 2, 0), elapsed)
        start = np.concatenate([knot.coordinates for knot in self.knots], axis=1)[:, nearest]
        coordinates = self.placed(moved(self.tree, start, ways), times)
        rows, columns = (np.array([getattr(knot, name) for knot in self.knots]) for name in ("rows", "columns"))
        return coordinates, rows[nearest], columns[nearest]


def _way(series: Array, elapsed: Array | float) -> Array:
    """Movement (nv, ...) in a time by the series of rates (3, nv, ...)."""
    return np.asarray(elapsed * (series[0] + elapsed * (series[1] / 2.0 + elapsed * series[2] / 3.0)))


def _padded(series: Array) -> Array:
    """Derivatives (3, nv, T) of a series of up to three coefficients."""
    made = np.zeros((3, *series.shape[1:]))
    for k, one in enumerate(series):
        made[k] = math.factorial(k) * one
    return made


def _motion(found: Poses, name: str, samples: int) -> Array:
    """Position and its derivatives (4, T, 3) of an observed point."""
    made = np.zeros((4, samples, 3))
    for k, one in enumerate(found.point(found.tree.points[name])):
        made[k] = math.factorial(k) * np.broadcast_to(one, (3, samples)).T
    return made
