"""Exact motion of a machine in space whose joints follow drive laws: assembly, branch and derivatives to jerk.

Along the motion each pose is predicted from the Taylor series of the pose before, which keeps it on the branch. All
samples are then solved at once from these knots.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from conrod.errors import InvalidInput
from conrod.exact.motion import Array, PointMotion
from conrod.exact.space import SpatialTree, displace
from conrod.exact.space.assembly import MAX_NEWTON_STEPS, RANK_TOLERANCE, Assembly, Knot
from conrod.exact.space.drive_laws import DriveLaw, quintic
from conrod.exact.space.forward_kinematics import Poses, forward_kinematics
from conrod.exact.space.loop_closure import residuals

# After a Newton step this small its square is rounding; the loops are then open by at most a share of the extent.
LAST_NEWTON_STEP, NEARLY_CLOSED = 1e-9, 1e-7
POSES, MAX_KNOTS = 48, 20_000  # knots over the duration of a law at least, and in all at most
MIN_STEP = 1e-7  # share of the duration
KNOTS_TOGETHER = 16  # at most that are closed at once: from further away Newton's method closes another pose
MAX_DEVIATION = 0.03  # of a pose from its prediction, as a share of the step
SAMPLES_TOGETHER = 2048
NO_FURTHER = "a dead centre, or its loops reach no further"


@dataclass(frozen=True, eq=False)
class SpatialMotion:
    """Exact motion at T times.

    Attributes:
        times: (T,) [s].
        coordinates: (nq, T).
        rates: rates, accelerations and jerks of all joints (3, nv, T).
        points: position, velocity, acceleration and jerk (T, 3) of all points that the drives determine.
    """

    times: Array
    coordinates: Array
    rates: Array
    points: Mapping[str, PointMotion]


class DrivenTree(Assembly):
    """A machine with its drives, and the motion tracked so far.

    Attributes:
        knots: solved poses along the motion in the order of time, made by `track_branch`.
        misfit: largest constraint violation at the knots [m], where closures contradict each other.
    """

    def __init__(self, tree: SpatialTree, laws: Mapping[str, DriveLaw], held: tuple[str, ...] = ()) -> None:
        super().__init__(tree, laws, held)
        self.knots: list[Knot] = []
        self.misfit = 0.0

    def assemble_start(self) -> Array:
        """Return the closed pose (nq, 1) at the beginning of the laws, on the branch of the tree's start.

        Raises:
            InvalidInput: the loops cannot be closed there, or the drives cannot move from there to where their laws
            begin.
        """
        start, start_laws = self.tree.start[:, None], dict[str, DriveLaw]()
        for joint, law in zip(self.driven, self.laws.values(), strict=True):
            begin, end = float(start[joint.coordinate, 0]), float(law.derivatives(np.zeros(1))[0, 0])
            start_laws[joint.name] = DriveLaw(law.text, 1.0, quintic(begin, end, 1.0))
        if any(law.derivatives(np.array([0.5]))[1, 0] for law in start_laws.values()):
            there = DrivenTree(self.tree, start_laws, self.held)
            there.track_branch(there.close_loops(start, 0.0)[0], 1.0)
            start = there.knots[-1].coordinates
        return self.close_loops(start, 0.0)[0]

    # -- along the motion --------------------------------------------------------------------------------------------

    def track_branch(self, start: Array, duration: float) -> None:
        """Track the branch of a closed pose (nq, 1) from time 0 for a duration [s].

        Raises:
            InvalidInput: the loops block it, it passes a singular pose, or its laws repeat too often.
        """
        self.knots = self.solve_knots(start, np.zeros(1))
        self.misfit = float(np.abs(residuals(forward_kinematics(self.tree, start), 0)).max(initial=0.0))
        longest = step = min(duration, *(law.duration for law in self.laws.values())) / POSES
        if duration > MAX_KNOTS * longest:
            most = f"its fastest drive repeats too often in that time: {MAX_KNOTS * longest:.3g} s at most"
            raise InvalidInput(f"{duration:g} s: {most}")
        together = 1
        while (time := self.knots[-1].time) < duration:
            times, steps = list[float](), [step]
            while len(times) < together and time < duration:
                time = duration if duration - time <= 1.001 * steps[-1] else time + steps[-1]
                times.append(time)
                steps.append(min(2.0 * steps[-1], longest))
            if following := self._next_knots(np.array(times)):
                self.knots += following
                step, together = steps[-1], min(2 * together, KNOTS_TOGETHER)
            elif together > 1:
                together = 1
            else:
                step *= 0.5
                if step < MIN_STEP * duration:
                    time = self.knots[-1].time
                    place = f"{self.describe_drives(time)}, after {time:.3g} s"
                    raise InvalidInput(f"it goes no further than {place}: {NO_FURTHER}")

    def _next_knots(self, times: Array) -> list[Knot]:
        """Return the closed poses at times (T,), if each is near its prediction from the one before; else none."""
        last = self.knots[-1]
        try:
            found, gap = self.close_loops(self._predict([last], np.zeros(len(times), dtype=int), times)[0], times)
        except InvalidInput:
            return []
        poses = forward_kinematics(self.tree, found)
        knots = self.solve_knots(found, times, poses)
        before = [last, *knots[:-1]]
        if len(knots) < len(times) or knots[0].rows.shape != last.rows.shape:
            return []
        predicted, displacement = self._predict(before, np.arange(len(times)), times)
        deviation = (self.coordinate_sizes * np.abs(found - predicted)).max(axis=0)
        travelled = (self.rate_sizes[:, None] * np.abs(displacement)).max(axis=0)
        if np.any(deviation > MAX_DEVIATION * travelled + 1e-9 * self.tree.extent):
            return []
        # Where branches meet the determinant is 0, and beyond its sign is another; at a knot it is positive.
        rows, columns = (np.array([getattr(knot, name) for knot in before]) for name in ("rows", "columns"))
        if np.any(np.linalg.det(self.reduced_jacobian(poses, rows, columns)) <= 0.0):
            return []
        self.misfit = max(self.misfit, gap)
        return knots

    def _predict(self, knots: Sequence[Knot], which: NDArray[np.intp], times: Array) -> tuple[Array, Array]:
        """Poses (nq, T) at times (T,), each by the series of one of some knots, and the displacements (nv, T)."""
        elapsed = times - np.array([knot.time for knot in knots])[which]
        displacement = _displacement(np.array([knot.rates for knot in knots])[which].transpose(1, 2, 0), elapsed)
        start = np.concatenate([knot.coordinates for knot in knots], axis=1)[:, which]
        return self.with_driven_joints(displace(self.tree, start, displacement), times), displacement

    # -- at samples --------------------------------------------------------------------------------------------------

    def motion(self, times: Array, order: int = 3) -> SpatialMotion:
        """Return the exact motion at times (T,) [s] within the tracked duration.

        Args:
            order: 2 for velocities and accelerations alone; jerks are 0 then.
        """
        parts = [
            self._solve_samples(times[k : k + SAMPLES_TOGETHER], order) for k in range(0, len(times), SAMPLES_TOGETHER)
        ]
        coordinates, series, points = (list(column) for column in zip(*parts, strict=True))
        made = {name: PointMotion(*np.concatenate([one[name] for one in points], axis=1)) for name in self.tree.points}
        return SpatialMotion(times, np.concatenate(coordinates, axis=1), np.concatenate(series, axis=2), made)

    def _solve_samples(self, times: Array, order: int) -> tuple[Array, Array, dict[str, Array]]:
        """Coordinates, rates and observed points at times (T,)."""
        coordinates, rows, columns, usual = self._predict_from_knots(times)
        if rows.shape[2]:
            coordinates = self._close_predicted(coordinates, times, rows, columns, usual)
        rates = self.rate_series(coordinates, times, rows, columns, order)
        final = forward_kinematics(self.tree, coordinates, rates)
        return (
            coordinates,
            _time_derivatives(rates),
            {name: _point_motion(final, name, len(times)) for name in self.tree.points},
        )

    def _close_predicted(self, coordinates: Array, times: Array, rows: Array, columns: Array, usual: Array) -> Array:
        """Close predicted poses (nq, T); raises InvalidInput where the loops do not close, or are singular.

        Args:
            usual: singular values (T, r) of the reduced Jacobians at the knots.
        """
        bearable = 3.0 * self.misfit + NEARLY_CLOSED * self.tree.extent
        for _ in range(MAX_NEWTON_STEPS):
            found = forward_kinematics(self.tree, coordinates)
            matrix, left = self.reduced_jacobian(found, rows, columns), residuals(found, 0)[0]
            seen = np.einsum("tmr,mt->tr", rows, left)
            step = np.zeros((self.tree.freedom, len(times)))
            step[self.free] = np.einsum("tfr,tr->ft", columns, self.solve_reduced(matrix, -seen, times))
            coordinates = displace(self.tree, coordinates, step)
            if np.abs(step).max() <= LAST_NEWTON_STEP and np.abs(left).max() <= bearable:
                # At a singular pose itself rounding decides on the sign. The determinant of many loops is small
                # wherever each is a little nearer to one than at the knot: there the least singular value tells.
                shares = np.linalg.det(matrix) / usual.prod(axis=1)
                if np.all(shares > RANK_TOLERANCE):
                    return coordinates
                least = np.linalg.svd(matrix, compute_uv=False)[:, -1] / usual[:, -1]
                if np.all((shares > 0.0) & (least > RANK_TOLERANCE)):
                    return coordinates
                raise InvalidInput(self.singular_message(float(times[int(np.argmin(shares))])))
        values = np.linalg.svd(np.nan_to_num(matrix), compute_uv=False)
        if np.any(nearly := values[:, -1] < RANK_TOLERANCE * values[:, 0]):
            raise InvalidInput(self.singular_message(float(times[int(np.argmax(nearly))])))
        worst = int(np.argmax(np.abs(left).max(axis=0)))
        stays = self.worst_closure_message(coordinates[:, worst : worst + 1])
        raise InvalidInput(f"its loops do not close {self.describe_drives(float(times[worst]))}: {stays}")

    def _predict_from_knots(self, times: Array) -> tuple[Array, Array, Array, Array]:
        """Poses (nq, T) from the series of the nearest knots.

        Returns:
            The knots' bases (T, rows, r), (T, free, r) and singular values (T, r) of their reduced Jacobians, too.
        """
        at = np.array([knot.time for knot in self.knots])
        nearest = np.abs(at[:, None] - times).argmin(axis=0)
        rows, columns = (np.array([getattr(knot, name) for knot in self.knots]) for name in ("rows", "columns"))
        values = np.array([knot.values[: rows.shape[2]] for knot in self.knots])
        return self._predict(self.knots, nearest, times)[0], rows[nearest], columns[nearest], values[nearest]


def _displacement(series: Array, elapsed: Array | float) -> Array:
    """Displacement (nv, ...) in a time by the series of rates (3, nv, ...)."""
    return np.asarray(elapsed * (series[0] + elapsed * (series[1] / 2.0 + elapsed * series[2] / 3.0)))


def _time_derivatives(series: Array) -> Array:
    """Derivatives (3, nv, T) of a series of up to three coefficients."""
    made = np.zeros((3, *series.shape[1:]))
    for k, one in enumerate(series):
        made[k] = math.factorial(k) * one
    return made


def _point_motion(found: Poses, name: str, samples: int) -> Array:
    """Position and its derivatives (4, T, 3) of an observed point."""
    made = np.zeros((4, samples, 3))
    for k, one in enumerate(found.point(found.tree.points[name])):
        made[k] = math.factorial(k) * np.broadcast_to(one, (3, samples)).T
    return made
