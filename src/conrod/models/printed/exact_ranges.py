"""Exact values of printed quantities: at the printed angles, and over the angles that are printed so."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from scipy.optimize import minimize_scalar

from conrod.exact.link_rotations import ROTATIONS, link_rotations
from conrod.exact.motion import BREAK_WIDTH, Array
from conrod.mechanism.units import REVOLUTION
from conrod.models.printed.rows import AXES, PrintedRow

MIN_EVEN_STEPS = 2  # steps between angles from which on equal ones show that the angles were chosen
EVEN_TOLERANCE = 1e-6  # of a distance between angles, by which equal ones may differ
ROUNDING_SAMPLES = 41  # angles within the rounding of a printed one that are looked at


def exact_values(rows: Sequence[PrintedRow], angles: Array) -> Array:
    """Exact values (N,) at crank angles (N,) [rad], in the printed unit; NaN beyond the machine's span.

    Args:
        rows: N of one group.
    """
    scene, (point, derivative, axis), found = rows[0].scene, rows[0].quantity, np.full(len(rows), np.nan)
    low, high = scene.mechanism().driver.span or (-np.inf, np.inf)
    there = (angles >= low - BREAK_WIDTH) & (angles <= high + BREAK_WIDTH)
    if not there.any():
        return found
    if derivative in ROTATIONS:
        kinematics = scene.kinematics
        rotations = link_rotations(kinematics, angles[there], scene.speed)[ROTATIONS.index(derivative)]
        found[there] = rotations[:, kinematics.mechanism.body_index[point]]
    else:
        vectors = getattr(scene.motion(angles[there], scene.speed).point(point), derivative)
        found[there] = np.hypot(*vectors.T) if axis == "size" else vectors[:, AXES.index(axis)]
    return in_printed_turn(rows, found * rows[0].factor)


def in_printed_turn(rows: Sequence[PrintedRow], values: Array) -> Array:
    """Values (N,) in the printed unit; links' angles are shifted by whole turns, to be next to the print."""
    if rows[0].quantity[1] != "rotation":
        return values
    turn, printed = REVOLUTION * rows[0].factor, np.array([row.number.value for row in rows])
    return np.asarray(values + turn * np.rint((printed - values) / turn))


def angle_roundings(rows: Sequence[PrintedRow]) -> Array:
    """Largest distances (N,) of angles from the printed ones [deg]; 0 where a quantity's are evenly spaced."""
    chosen = _is_even(np.array([row.degrees for row in rows]))
    return np.array([0.0 if chosen else row.rounding for row in rows])


def exact_ranges(rows: Sequence[PrintedRow]) -> Array:
    """Least and largest exact value (2, N) over the crank angles that round to the printed ones."""
    sides = np.linspace(-1.0, 1.0, ROUNDING_SAMPLES) if (by := angle_roundings(rows)).any() else np.zeros(1)
    degrees = np.array([row.degrees for row in rows]) + sides[:, None] * by
    found = exact_values(list(rows) * len(sides), np.radians(degrees.ravel())).reshape(degrees.shape)
    inside = np.isfinite(found)
    return np.array([np.where(inside, found, np.inf).min(axis=0), np.where(inside, found, -np.inf).max(axis=0)])


def nearest_in_rounding(row: PrintedRow, rounding: float) -> tuple[float, float] | None:
    """Angle [deg] within its rounding, and exact value, that reproduce a printed value; None if none does.

    Args:
        rounding: largest distance from the printed angle [deg].
    """

    def distance_from_print(degrees: float) -> float:
        value = float(exact_values([row], np.radians([degrees]))[0])
        return abs(value - row.number.value) if math.isfinite(value) else math.inf

    if not rounding:
        return None
    angles = row.degrees + rounding * np.linspace(-1.0, 1.0, ROUNDING_SAMPLES)
    found = exact_values([row] * ROUNDING_SAMPLES, np.radians(angles))
    nearest = int(np.argmin(np.where(np.isnan(found), np.inf, np.abs(found - row.number.value))))
    bounds = float(angles[max(nearest - 1, 0)]), float(angles[min(nearest + 1, ROUNDING_SAMPLES - 1)])
    best = min(
        float(angles[nearest]),
        float(minimize_scalar(distance_from_print, bounds=bounds, method="bounded").x),
        key=distance_from_print,
    )
    value = float(exact_values([row], np.radians([best]))[0])
    return (best, value) if row.number.is_rounding_of(value) else None


def _is_even(degrees: Array) -> bool:
    """True if a quantity is printed at evenly spaced angles, which are chosen and not rounded."""
    steps = np.diff(np.unique(degrees))
    return len(steps) >= MIN_EVEN_STEPS and bool(np.ptp(steps) <= EVEN_TOLERANCE * steps.max())
