"""The exact motion of a machine as a table: Taylor polynomials in the crank angle, on intervals between knots."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from conrod.errors import InvalidInput
from conrod.exact import ExactReference
from conrod.exact.kinematics import TURN, Kinematics
from conrod.exact.motion import Array

ORDER = 18  # of the polynomials
INTERVALS = 4  # of a turn, before any is halved
MOST_INTERVALS = 1024  # beyond them none is halved; machines that ship have up to 84
# Intervals are halved until polynomials agree with the exact motion at these places (of half an interval) to TARGET;
# at the others they are then held against it, to TOLERANCE.
ENDS, WITHIN = (-0.98, 0.98), (-0.99, -0.4, 0.45, 0.99)
TARGET, TOLERANCE = 2e-13, 1e-12
# This near [rad] to a change point, where the Jacobian is singular, accelerations of the exact motion are rounded more.
SINGULAR, ROUNDED = 0.3, 10.0
PERIODS = (1, 6, 60)  # turns within which motion is looked for to repeat, as behind gears it does not after one
REPEATED = 1e-10
DIGITS = 9  # of knots [rad]; a side of a break is chosen no finer (BREAK_WIDTH)
QUANTITIES = ("position", "velocity", "acceleration")


@dataclass(frozen=True)
class MotionTable:
    """Motion of Q columns by the crank angle: x, y and turn of every body, then x and y of every observed point.

    Attributes:
        names: of the columns (Q,): "crank.x", "crank.y", "crank.angle", ..., "C.x", "C.y".
        scales: what errors (Q,) are divided by: L [m] of a point, the longest L for bodies, 1 rad for turns.
        knots: crank angles (K + 1,) [rad] that bound the intervals, breaks among them.
        coefficients: (K, Q, ORDER + 1) [m or rad, by rad^k], about the middles of the intervals.
        turns: whole turns that the table holds, after which motion repeats; 0 for an input of one pass.
        gains: of the columns (Q,) [m or rad] over these turns.
    """

    names: tuple[str, ...]
    scales: Array
    knots: Array
    coefficients: Array
    turns: int
    gains: Array

    def evaluate(self, angle: Array) -> Array:
        """Values and first two derivatives by the crank angle (3, T, Q) at angles (T,) [rad]."""
        periods = np.floor(angle / (TURN * self.turns)) if self.turns else np.zeros_like(angle)
        within = angle - periods * TURN * self.turns
        found = np.clip(np.searchsorted(self.knots, within, side="right") - 1, 0, len(self.knots) - 2)
        motion = _polynomials(self.coefficients[found], within - 0.5 * (self.knots[found] + self.knots[found + 1]))
        motion[0] += periods[:, None] * self.gains
        return motion

    def check(self, reference: ExactReference) -> None:
        """Hold the table against the exact motion between its knots, and a period later; InvalidInput if it is off."""
        middles, halves = 0.5 * (self.knots[1:] + self.knots[:-1]), 0.5 * np.diff(self.knots)
        angle = np.concatenate([middles + part * halves for part in WITHIN])
        if self.turns:
            angle = np.concatenate([angle, angle + self.turns * TURN])
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
        InvalidInput: the crank cannot turn, the motion does not repeat, or polynomials do not meet it.
    """
    mechanism, travel = reference.mechanism(), max(reference.lengths.values())
    names = [f"{body.name}.{axis}" for body in mechanism.bodies for axis in ("x", "y", "angle")]
    names += [f"{point.name}.{axis}" for point in mechanism.observed for axis in "xy"]
    lengths = [reference.lengths[point.name] for point in mechanism.observed for _ in "xy"]
    scales = np.array([travel, travel, 1.0] * len(mechanism.bodies) + lengths)
    turns, gains = _period(reference.kinematics, scales)
    knots, coefficients = _refined(reference, _first_knots(reference.kinematics, turns), scales)
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
    """Errors (3, T, Q) over the scales of motion (3, T, Q) at one radian a second; points by the closed form if any."""
    exact = _columns(reference.kinematics, angle, 2)
    points = reference.motion(angle, 1.0).points.values()
    stacked = [np.stack([point.position, point.velocity, point.acceleration]) for point in points]
    exact[..., -2 * len(stacked) :] = np.concatenate(stacked, axis=2)
    errors = np.abs(motion - exact) / scales
    errors[:, reference.kinematics.near_change(angle, SINGULAR)] /= ROUNDED
    return np.asarray(errors)


def _period(kinematics: Kinematics, scales: Array) -> tuple[int, Array]:
    """Whole turns after which motion repeats, and the gains of the columns (Q,) over them; 0 for one pass."""
    if kinematics.mechanism.driver.span is not None:
        return 0, np.zeros_like(scales)
    angle = np.array([0.1, 1.3, 2.9, 4.4, 6.1])
    for most in PERIODS:  # the way far ahead is gone once, not turn by turn
        ahead = (angle + TURN * np.arange(most + 1)[:, None]).ravel()
        columns = _columns(kinematics, ahead, 2).reshape(3, most + 1, len(angle), len(scales))
        for turns in range(1, most + 1):
            change = columns[:, turns] - columns[:, 0]
            gains = change[0, 0].copy()
            change[0] -= gains
            if (np.abs(change) < REPEATED * scales).all():
                # A whole turn, or none, is that exactly: rounding would add up over many turns.
                whole = TURN * np.rint(gains / TURN)
                return turns, np.where(np.abs(gains - whole) < REPEATED * scales, whole, gains)
    raise InvalidInput(
        f"{kinematics.mechanism.name} cannot be tabulated: its motion does not repeat within {PERIODS[-1]} turns"
    )


def _first_knots(kinematics: Kinematics, turns: int) -> Array:
    """Knots (K + 1,) [rad], evenly apart, with change points and where a cam's roller passes to another arc or law."""
    first, last = (0.0, TURN * turns) if turns else kinematics.span
    breaks = np.array([*kinematics.arc_ends, *kinematics.change_angles]) + TURN * np.arange(max(turns, 1))[:, None]
    even = np.linspace(first, last, math.ceil(INTERVALS * (last - first) / TURN) + 1)
    inside = breaks[(breaks > first) & (breaks < last)]
    return np.unique(np.round(np.concatenate([even, inside]), DIGITS))


def _refined(reference: ExactReference, knots: Array, scales: Array) -> tuple[Array, Array]:
    """Knots (K + 1,) and coefficients (K, Q, ORDER + 1) of intervals that are halved until polynomials agree."""
    kept: dict[float, Array] = {}  # coefficients by the left ends
    factorials = np.array([math.factorial(k) for k in range(ORDER + 1)], dtype=float)
    left, right = knots[:-1], knots[1:]
    while len(left):
        middle, half = 0.5 * (left + right), 0.5 * (right - left)
        series = np.moveaxis(_columns(reference.kinematics, middle, ORDER), 0, 2) / factorials
        offset = np.concatenate([part * half for part in ENDS])
        angle = np.tile(middle, len(ENDS)) + offset
        motion = _polynomials(np.tile(series, (len(ENDS), 1, 1)), offset)
        misses = _errors(reference, motion, angle, scales).max(axis=(0, 2)).reshape(len(ENDS), -1).max(axis=0)
        good = (misses <= TARGET) | (len(kept) + 2 * len(left) > MOST_INTERVALS)
        kept |= {float(left[k]): series[k] for k in np.flatnonzero(good)}
        halved = left[~good], middle[~good], right[~good]
        left, right = np.concatenate(halved[:2]), np.concatenate(halved[1:])
    places = sorted(kept)
    return np.array([*places, knots[-1]]), np.stack([kept[place] for place in places])
