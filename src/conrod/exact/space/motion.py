"""Exact motion of a machine in space whose joints are driven by laws: assembly, branch and derivatives to jerk.

Along the motion each pose is predicted by the Taylor series of the one before it, so that it stays on the branch; all
samples are then solved at once from the poses on the way.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from conrod.errors import InvalidInput
from conrod.exact.motion import Array, PointMotion
from conrod.exact.space import SpatialTree, moved
from conrod.exact.space.assembly import NEWTON_STEPS, RANK_TOLERANCE, Assembly, Knot
from conrod.exact.space.closing import residuals
from conrod.exact.space.laws import Law, quintic
from conrod.exact.space.poses import Poses, poses

# The square of a sample's last step is rounding; before it the loops are open by no more than this share of the extent.
LAST_STEP, NEARLY = 1e-9, 1e-7
# Poses of a law's course at least, and of a way at most; the shortest step; a pose may be this share of the step off
# its prediction.
POSES, MOST_POSES, LEAST_STEP, STRAYED = 48, 20_000, 1e-7, 0.03
TOGETHER = 2048  # samples
NO_FURTHER = "a dead centre, or its loops reach no further"


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


class DrivenTree(Assembly):
    """A machine with its drives, and the way that it goes.

    Attributes:
        knots: poses on the way, in the order of time; made by `go`.
        misfit: what stays open at most at these [m], where closures contradict each other.
    """

    def __init__(self, tree: SpatialTree, laws: Mapping[str, Law], held: tuple[str, ...] = ()) -> None:
        super().__init__(tree, laws, held)
        self.knots: list[Knot] = []
        self.misfit = 0.0

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
                    place = f"{self.where(here.time)} ({here.time:.6g} s)"
                    raise InvalidInput(f"it goes no further than {place}: {NO_FURTHER}")
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
        strayed, gone = self.reach * np.abs(found - predicted), self.sweep * np.abs(way)
        if strayed.max() > STRAYED * gone.max() + 1e-9 * self.tree.extent:
            return None
        # Where branches meet the determinant is 0, and beyond its sign is another; at a knot it is positive.
        if np.linalg.det(self.reduced(poses(self.tree, found), here.rows[None], here.columns[None]))[0] <= 0.0:
            return None
        knot = self.knot(found, time)
        if knot.rows.shape != here.rows.shape:
            return None
        self.misfit = max(self.misfit, gap)
        return knot

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
        rates = self.derived(coordinates, times, rows, columns, order)
        final = poses(self.tree, coordinates, rates)
        return coordinates, _padded(rates), {name: _motion(final, name, len(times)) for name in self.tree.points}

    def _corrected(self, coordinates: Array, times: Array, rows: Array, columns: Array) -> Array:
        """Closed poses (nq, T) near predicted ones; raises InvalidInput where there is none."""
        bearable = 3.0 * self.misfit + NEARLY * self.tree.extent
        for _ in range(NEWTON_STEPS):
            found = poses(self.tree, coordinates)
            matrix, left = self.reduced(found, rows, columns), residuals(found, 0)[0]
            seen = np.einsum("tmr,mt->tr", rows, left)
            step = np.zeros((self.tree.freedom, len(times)))
            step[self.free] = np.einsum("tfr,tr->ft", columns, self.solved(matrix, -seen, times))
            coordinates = moved(self.tree, coordinates, step)
            if np.abs(step).max() <= LAST_STEP and np.abs(left).max() <= bearable:
                determinants = np.linalg.det(matrix)
                if np.all(determinants > 0.0):
                    return coordinates
                raise InvalidInput(self.singular(float(times[int(np.argmin(determinants))])))
        values = np.linalg.svd(np.nan_to_num(matrix), compute_uv=False)
        if np.any(nearly := values[:, -1] < RANK_TOLERANCE * values[:, 0]):
            raise InvalidInput(self.singular(float(times[int(np.argmax(nearly))])))
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
