"""The exact motion of a machine as a table: Taylor polynomials in the crank angle, on intervals between knots."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from conrod.errors import InvalidInput
from conrod.exact.kinematics import ExactReference, Kinematics
from conrod.exact.motion import QUANTITIES, Array
from conrod.mechanism.units import REVOLUTION

ORDER = 18  # of the polynomials
INTERVALS_PER_REVOLUTION = 4  # before any is halved
MAX_INTERVALS = 1024  # machines that ship have up to 84
# Intervals are halved until polynomials agree with the exact motion to `REFINING_TOLERANCE` at `REFINING_PLACES` (in
# halves of an interval from its middle); the whole table is then checked at `CHECKED_PLACES`, to `TOLERANCE`.
REFINING_PLACES, CHECKED_PLACES = (-0.98, 0.98), (-0.99, -0.4, 0.45, 0.99)
REFINING_TOLERANCE, TOLERANCE = 2e-13, 1e-12
# Within this distance [rad] of a change point, where the Jacobian is singular, rounding errors of accelerations are
# this much larger.
CHANGE_POINT_DISTANCE, CHANGE_POINT_FACTOR = 0.3, 10.0
PERIODS_TRIED = (1, 6, 60)  # revolutions searched for a repetition; motion behind gears may need several
REPEAT_TOLERANCE = 1e-10
KNOT_DIGITS = 9  # decimals of knots [rad]; the side of a break is chosen no finer (BREAK_WIDTH)


@dataclass(frozen=True)
class MotionTable:
    """Motion of Q columns by the crank angle: x, y and rotation of every body, then x and y of every observed point.

    Attributes:
        names: names (Q,) of the columns: "crank.x", "crank.y", "crank.angle", ..., "C.x", "C.y".
        scales: divisors of errors (Q,): L [m] of a point, the longest L for bodies, 1 rad for rotations.
        knots: crank angles (K + 1,) [rad] that bound the intervals, breaks among them.
        coefficients: Taylor coefficients (K, Q, ORDER + 1) [m or rad, by rad^k] about the middles of the intervals.
        turns: whole revolutions in the table, after which motion repeats; 0 for an input of one pass.
        gains: change of the columns (Q,) [m or rad] over these revolutions.
    """

    names: tuple[str, ...]
    scales: Array
    knots: Array
    coefficients: Array
    turns: int
    gains: Array

    def evaluate(self, angle: Array) -> Array:
        """Values and first two derivatives by the crank angle (3, T, Q) at angles (T,) [rad]."""
        periods = np.floor(angle / (REVOLUTION * self.turns)) if self.turns else np.zeros_like(angle)
        within = angle - periods * REVOLUTION * self.turns
        found = np.clip(np.searchsorted(self.knots, within, side="right") - 1, 0, len(self.knots) - 2)
        motion = _polynomials(self.coefficients[found], within - 0.5 * (self.knots[found] + self.knots[found + 1]))
        motion[0] += periods[:, None] * self.gains
        return motion

    def check(self, reference: ExactReference) -> None:
        """Compare the table with the exact motion between its knots and a period later; InvalidInput if it is off."""
        middles, halves = 0.5 * (self.knots[1:] + self.knots[:-1]), 0.5 * np.diff(self.knots)
        angle = np.concatenate([middles + part * halves for part in CHECKED_PLACES])
        if self.turns:
            angle = np.concatenate([angle, angle + self.turns * REVOLUTION])
        errors = _errors(reference, self.evaluate(angle), angle, self.scales)
        quantity, sample, column = np.unravel_index(int(errors.argmax()), errors.shape)
        if not errors.max() <= TOLERANCE:
            raise InvalidInput(
                f"{reference.mechanism().name} cannot be tabulated: {QUANTITIES[quantity]} of {self.names[column]} at "
                f"crank angle {math.degrees(angle[sample]):.6g} deg: polynomials and the exact motion differ by "
                f"{errors.max():.2g}; {TOLERANCE:g} is allowed"
            )


def motion_table(reference: ExactReference) -> MotionTable:
    """Tabulate a machine's exact motion, and check the table.

    Raises:
        InvalidInput: the crank cannot turn, the motion does not repeat, or polynomials do not reproduce it.
    """
    mechanism, travel = reference.mechanism(), max(reference.lengths.values())
    names = [f"{body.name}.{axis}" for body in mechanism.bodies for axis in ("x", "y", "angle")]
    names += [f"{point.name}.{axis}" for point in mechanism.observed for axis in "xy"]
    lengths = [reference.lengths[point.name] for point in mechanism.observed for _ in "xy"]
    scales = np.array([travel, travel, 1.0] * len(mechanism.bodies) + lengths)
    turns, gains = _period(reference.kinematics, scales)
    knots, coefficients = _refine_intervals(reference, _first_knots(reference.kinematics, turns), scales)
    table = MotionTable(tuple(names), scales, knots, coefficients, turns, gains)
    table.check(reference)
    return table


def _columns(kinematics: Kinematics, angle: Array, order: int) -> Array:
    """All columns and their derivatives by the crank angle (order + 1, T, Q) at angles (T,) [rad]."""
    poses = kinematics.derivatives(angle, order)
    points = kinematics.point_derivatives(poses).values()
    return np.stack([np.hstack([pose, *(point[k] for point in points)]) for k, pose in enumerate(poses)])


def _polynomials(coefficients: Array, offset: Array) -> Array:
    """Values and first two derivatives (3, T, Q) of polynomials (T, Q, ORDER + 1) at offsets (T,), by Horner's rule."""
    values, rates, seconds = np.zeros((3, *coefficients.shape[:2]))
    for coefficient in np.moveaxis(coefficients, 2, 0)[::-1]:
        seconds = seconds * offset[:, None] + rates
        rates = rates * offset[:, None] + values
        values = values * offset[:, None] + coefficient
    return np.stack([values, rates, 2.0 * seconds])


def _errors(reference: ExactReference, motion: Array, angle: Array, scales: Array) -> Array:
    """Errors (3, T, Q) of motion (3, T, Q) at 1 rad/s over the scales; points against their closed form, if known."""
    exact = _columns(reference.kinematics, angle, 2)
    points = reference.motion(angle, 1.0).points.values()
    stacked = [np.stack([point.position, point.velocity, point.acceleration]) for point in points]
    exact[..., -2 * len(stacked) :] = np.concatenate(stacked, axis=2)
    errors = np.abs(motion - exact) / scales
    errors[:, reference.kinematics.near_change(angle, CHANGE_POINT_DISTANCE)] /= CHANGE_POINT_FACTOR
    return np.asarray(errors)


def _period(kinematics: Kinematics, scales: Array) -> tuple[int, Array]:
    """Whole revolutions after which motion repeats, and the gains of the columns (Q,) over them; 0 for one pass."""
    if kinematics.mechanism.driver.span is not None:
        return 0, np.zeros_like(scales)
    angle = np.array([0.1, 1.3, 2.9, 4.4, 6.1])
    for most in PERIODS_TRIED:  # one long track is cheaper than many short ones
        ahead = (angle + REVOLUTION * np.arange(most + 1)[:, None]).ravel()
        columns = _columns(kinematics, ahead, 2).reshape(3, most + 1, len(angle), len(scales))
        for turns in range(1, most + 1):
            change = columns[:, turns] - columns[:, 0]
            gains = change[0, 0].copy()
            change[0] -= gains
            if (np.abs(change) < REPEAT_TOLERANCE * scales).all():
                # A whole turn, or none, is that exactly: rounding would add up over many turns.
                whole = REVOLUTION * np.rint(gains / REVOLUTION)
                return turns, np.where(np.abs(gains - whole) < REPEAT_TOLERANCE * scales, whole, gains)
    raise InvalidInput(
        f"{kinematics.mechanism.name} cannot be tabulated: its motion does not repeat within {PERIODS_TRIED[-1]} turns"
    )


def _first_knots(kinematics: Kinematics, turns: int) -> Array:
    """Even knots (K + 1,) [rad], with change points and angles where a roller changes to another arc or law."""
    first, last = (0.0, REVOLUTION * turns) if turns else kinematics.span
    breaks = (
        np.array([*kinematics.arc_ends, *kinematics.change_angles]) + REVOLUTION * np.arange(max(turns, 1))[:, None]
    )
    even = np.linspace(first, last, math.ceil(INTERVALS_PER_REVOLUTION * (last - first) / REVOLUTION) + 1)
    inside = breaks[(breaks > first) & (breaks < last)]
    return np.unique(np.round(np.concatenate([even, inside]), KNOT_DIGITS))


def _refine_intervals(reference: ExactReference, knots: Array, scales: Array) -> tuple[Array, Array]:
    """Halve intervals until polynomials agree; return knots (K + 1,) and coefficients (K, Q, ORDER + 1)."""
    kept: dict[float, Array] = {}  # coefficients by the left ends
    factorials = np.array([math.factorial(k) for k in range(ORDER + 1)], dtype=float)
    left, right = knots[:-1], knots[1:]
    while len(left):
        middle, half = 0.5 * (left + right), 0.5 * (right - left)
        series = np.moveaxis(_columns(reference.kinematics, middle, ORDER), 0, 2) / factorials
        offset = np.concatenate([part * half for part in REFINING_PLACES])
        angle = np.tile(middle, len(REFINING_PLACES)) + offset
        motion = _polynomials(np.tile(series, (len(REFINING_PLACES), 1, 1)), offset)
        misses = (
            _errors(reference, motion, angle, scales).max(axis=(0, 2)).reshape(len(REFINING_PLACES), -1).max(axis=0)
        )
        good = (misses <= REFINING_TOLERANCE) | (len(kept) + 2 * len(left) > MAX_INTERVALS)
        kept |= {float(left[k]): series[k] for k in np.flatnonzero(good)}
        halved = left[~good], middle[~good], right[~good]
        left, right = np.concatenate(halved[:2]), np.concatenate(halved[1:])
    places = sorted(kept)
    return np.array([*places, knots[-1]]), np.stack([kept[place] for place in places])
