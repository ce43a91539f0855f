"""Allowed clock errors of a table whose crank has a prescribed speed: rounding, and the digits that are written."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from conrod.engines.numerics import largest_derivatives, phase_bound
from conrod.exact.motion import Array
from conrod.models.tables.columns import CRANK_ANGLE, TIME
from conrod.models.tables.errors import TableComparison
from conrod.models.tables.reading import Reading

EPS = float(np.finfo(float).eps)
DOUBLE_DIGITS = 17  # that tell doubles apart
# Distances that are whole multiples of one show that rows are missing where most are that one, or it is so many times
# the rounding of the digits: numbers of few digits are multiples of the last one whatever they were.
MAX_GAP_SHARE, MIN_SPACING_DIGITS = 0.25, 3.0
SPACING_QUANTILE = 0.1  # share of the distances that are no larger than the one that rows are taken to be apart


def clock_limits(table: TableComparison, reading: Reading, asked: Mapping[str, float]) -> dict[str, float]:
    """Allowed `phase` and `total` that follow from the tolerances given; empty without a crank angle.

    Errors at the angle that a table says show no wrong clock. An angle at the prescribed speed is off by rounding, and
    by the digits that its column and that of the time are written with; the position at the nominal time by what
    `position` is allowed, and by what the phase moves the point.
    """
    values, scene, nominal = reading.values, table.scene, table.nominal_angle
    if CRANK_ANGLE not in values or not asked or "total" in asked:
        return {}
    factors = {column.name: column.factor for column in reading.columns}
    rounding = phase_bound(len(nominal), float(np.abs(nominal).max()) / (2.0 * math.pi))
    written = abs(scene.speed) * _digit_rounding(values[TIME], values[TIME], factors[TIME])
    written += _digit_rounding(values[CRANK_ANGLE], nominal + table.phases, factors[CRANK_ANGLE])
    phase = asked.get("phase", rounding + written)
    limits = {"phase": phase}
    if "position" in asked:
        limits["total"] = asked["position"] + phase * largest_derivatives(scene.kinematics, 1)[1]
    return limits


def _digit_rounding(values: Array, course: Array, factor: float) -> float:
    """Bound on the rounding of a column by the digits that it is written with, SI.

    Half of the last digit, or of a single's; no more than the column leaves equal spacing by, so that whole numbers
    at equal distances are taken at their word, also where some rows are missing between them.

    Args:
        values, course: (T,) SI; as written, and without jumps by a turn.
        factor: factor from the unit of the column to SI.
    """
    written = np.abs(values[values != 0.0]) / factor
    if not len(written):
        return 0.0
    first = np.floor(np.log10(written))
    unknown = 2.0**-24 * written.max() if _are_equal_to_rounding(written, written.astype(np.float32)) else 0.0
    for digits in range(1, DOUBLE_DIGITS + 1):
        last = 10.0 ** (first - digits + 1)
        if digits == DOUBLE_DIGITS or _are_equal_to_rounding(written, np.rint(written / last) * last):
            unknown = max(unknown, 0.5 * float(last.max()))
            break
    place = _row_numbers(course, unknown * factor)
    even = course[0] + place * ((course[-1] - course[0]) / place[-1])
    return min(unknown * factor, float(np.abs(course - even).max()))


def _row_numbers(course: Array, unknown: float) -> Array:
    """Number each row (T,) from 0, counting missing rows: distances are multiples of a small one.

    Args:
        unknown: bound on the rounding of the digits, in the unit of the course.
    """
    distances = np.diff(course)
    apart = float(np.quantile(np.abs(distances), SPACING_QUANTILE, method="lower"))
    counts = np.maximum(np.rint(np.abs(distances) / apart), 1.0) if apart else np.ones_like(distances)
    if apart < MIN_SPACING_DIGITS * unknown and np.mean(counts > 1.0) > MAX_GAP_SHARE:
        counts = np.ones_like(distances)
    return np.concatenate([[0.0], np.cumsum(counts)])


def _are_equal_to_rounding(written: Array, rounded: Array) -> bool:
    """True if two arrays of numbers are equal but for double rounding."""
    return bool(np.all(np.abs(written - rounded) <= 4.0 * EPS * written))
