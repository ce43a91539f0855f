"""What a table's clock is allowed where its crank has a prescribed speed: `phase`, and `total` with it."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from conrod.engines.numerics import largest_derivatives, phase_bound
from conrod.exact.motion import Array
from conrod.own.tables.columns import Column
from conrod.own.tables.headings import CRANK_ANGLE, TIME
from conrod.own.tables.samples import Exact

EPS = float(np.finfo(float).eps)
DIGITS = 17  # that tell doubles apart


def clock_limits(table: Exact, columns: tuple[Column, ...], asked: Mapping[str, float]) -> dict[str, float]:
    """Limits that follow from those asked for; none where the table has no crank angle, or the user sets `total`.

    Errors at the angle that a table says show no wrong clock. An angle at the prescribed speed is off by rounding, and
    by the digits that its column and that of the time are written with; the position at the nominal time by what
    `position` is allowed, and by what the phase moves the point.
    """
    observed, scene = table.observed, table.scene
    if observed.angle is None or not asked or "total" in asked:
        return {}
    factors = {column.target.name: column.factor for column in columns}
    nominal = table.alignment.nominal(observed, scene.speed)
    rounding = phase_bound(len(nominal), float(np.abs(nominal).max()) / (2.0 * math.pi))
    written = abs(scene.speed) * _written(observed.times, observed.times, factors[TIME])
    written += _written(observed.angle, np.unwrap(observed.angle), factors[CRANK_ANGLE])
    phase = asked.get("phase", rounding + written)
    limits = {"phase": phase}
    if "position" in asked:
        limits["total"] = asked["position"] + phase * largest_derivatives(scene.kinematics, 1)[1]
    return limits


def _written(values: Array, course: Array, factor: float) -> float:
    """Bound on the rounding of a column by the digits that it is written with, SI.

    Half of the last digit, or of a single's; no more than the column leaves equal spacing by, so that whole numbers
    at equal distances are taken at their word.

    Args:
        values, course: (T,) SI; as written, and without jumps by a turn.
        factor: of the unit that it is written in, to SI.
    """
    even = course[0] + np.arange(len(course)) * ((course[-1] - course[0]) / (len(course) - 1))
    written = np.abs(values[values != 0.0]) / factor
    if not len(written):
        return 0.0
    first = np.floor(np.log10(written))
    unknown = 2.0**-24 * written.max() if _same(written, written.astype(np.float32)) else 0.0
    for digits in range(1, DIGITS + 1):
        last = 10.0 ** (first - digits + 1)
        if digits == DIGITS or _same(written, np.rint(written / last) * last):
            unknown = max(unknown, 0.5 * float(last.max()))
            break
    return min(unknown * factor, float(np.abs(course - even).max()))


def _same(written: Array, rounded: Array) -> bool:
    return bool(np.all(np.abs(written - rounded) <= 4.0 * EPS * written))
