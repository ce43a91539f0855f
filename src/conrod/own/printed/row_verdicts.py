"""Verdicts on the rows of one quantity: by the exact value, a slip of the whole column, or the angle's rounding."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from typing import TypeAlias

import numpy as np
from scipy.optimize import minimize_scalar

from conrod.errors import InvalidInput
from conrod.exact.motion import BREAK_WIDTH, Array
from conrod.own.printed.rows import AXES, Row
from conrod.own.printed.verdicts import GOOD, Kind, Verdict

# A cause is systematic where it reproduces this share of a quantity's printed values, and more of them than the exact
# motion does. One value is reproduced by something or other too easily.
SYSTEMATIC, FEWEST = 0.9, 3
EVEN = 1e-6  # of a distance between angles, by which equal ones may differ
WITHIN = 41  # angles within the rounding of a printed one that are looked at
# Crank angles [rad] that printed ones [deg] were taken for, and the factor of the values there.
Way: TypeAlias = tuple[Callable[[Array], Array], float]
# Values of pi that a document may have turned degrees into radians with.
SHORT_PI = {"3.14": 3.14, "3.142": 3.142, "3.1416": 3.1416, "3.14159": 3.14159, "22/7": 22.0 / 7.0}
CAUSES: dict[str, Way] = {
    f"pi taken as {text} for the angle": (partial(np.multiply, pi / 180.0), 1.0) for text, pi in SHORT_PI.items()
}
SLIPS: dict[str, Way] = {
    "the opposite sign": (np.radians, -1.0),
    "the crank angle counted in the other sense": (lambda degrees: -np.radians(degrees), 1.0),
    "the crank angle counted from the opposite dead centre": (lambda degrees: np.radians(degrees) + np.pi, 1.0),
    "the crank angle counted from a line 90 deg further on": (lambda degrees: np.radians(degrees) + 0.5 * np.pi, 1.0),
    "the crank angle counted from a line 90 deg back": (lambda degrees: np.radians(degrees) - 0.5 * np.pi, 1.0),
    "degrees taken for radians": (lambda degrees: degrees, 1.0),
    "degrees taken for radians in the speed": (np.radians, 180.0 / np.pi),
    **{f"a unit {10**k} times as large": (np.radians, 10.0**-k) for k in (1, 2, 3)},
    **{f"a unit {10**k} times as small": (np.radians, 10.0**k) for k in (1, 2, 3)},
}


def values(rows: Sequence[Row], angles: Array) -> Array:
    """Exact values (N,) of a quantity at crank angles (N,) [rad], in the printed unit; NaN where it is not reached.

    Args:
        rows: N of one group.
    """
    scene, (point, derivative, axis), found = rows[0].scene, rows[0].quantity, np.full(len(rows), np.nan)
    low, high = scene.mechanism().driver.span or (-np.inf, np.inf)
    there = (angles >= low - BREAK_WIDTH) & (angles <= high + BREAK_WIDTH)
    if there.any():
        vectors = getattr(scene.motion(angles[there], scene.speed).point(point), derivative)
        found[there] = np.hypot(*vectors.T) if axis == "size" else vectors[:, AXES.index(axis)]
    return np.asarray(found * rows[0].factor)


def verdicts_on(document: str, rows: Sequence[Row]) -> Iterator[Verdict]:
    """Verdicts on the rows of a group."""
    degrees = np.array([row.degrees for row in rows])
    exact = values(rows, np.radians(degrees))
    for k in np.flatnonzero(np.isnan(exact))[:1]:
        first, last = np.degrees(rows[k].scene.mechanism().driver.span or (0.0, 0.0))
        driven = f"{rows[k].fields['scene']} is driven from {first:g} to {last:g} deg"
        raise InvalidInput(f"row {rows[k].line}: angle_deg = {degrees[k]:g}: {driven}")
    met = _met(rows, exact)
    ways = CAUSES | SLIPS if met < len(rows) else {}
    every = {text: factor * values(rows, turned(degrees)) for text, (turned, factor) in ways.items()}
    needed = max(FEWEST, SYSTEMATIC * len(rows), met + 1)
    made = {text: found for text, found in every.items() if _met(rows, found) >= needed}
    chosen = _is_even(degrees)
    for k, row in enumerate(rows):
        ways_here = {text: float(found[k]) for text, found in made.items()}
        yield _verdict(document, row, float(exact[k]), ways_here, 0.0 if chosen else row.rounding)


def _is_even(degrees: Array) -> bool:
    """True if a quantity is printed at equal distances of the angle, which are chosen and not rounded."""
    steps = np.diff(np.unique(degrees))
    return len(steps) >= FEWEST - 1 and bool(np.ptp(steps) <= EVEN * steps.max())


def _nearest_in_rounding(row: Row, rounding: float) -> tuple[float, float] | None:
    """Angle [deg] within its rounding, and exact value there, at which a print is reproduced; None where there is none.

    Args:
        rounding: largest distance from the printed angle [deg].
    """

    def off(degrees: float) -> float:
        value = float(values([row], np.radians([degrees]))[0])
        return abs(value - row.number.value) if math.isfinite(value) else math.inf

    if not rounding:
        return None
    angles = row.degrees + rounding * np.linspace(-1.0, 1.0, WITHIN)
    found = values([row] * WITHIN, np.radians(angles))
    nearest = int(np.argmin(np.where(np.isnan(found), np.inf, np.abs(found - row.number.value))))
    bounds = float(angles[max(nearest - 1, 0)]), float(angles[min(nearest + 1, WITHIN - 1)])
    best = min(float(angles[nearest]), float(minimize_scalar(off, bounds=bounds, method="bounded").x), key=off)
    value = float(values([row], np.radians([best]))[0])
    return (best, value) if row.number.is_rounding_of(value) else None


def _met(rows: Sequence[Row], found: Array) -> int:
    """Number of printed values that are these, rounded."""
    return sum(row.number.is_rounding_of(float(value)) for row, value in zip(rows, found, strict=True))


def _verdict(document: str, row: Row, exact: float, made: Mapping[str, float], rounding: float) -> Verdict:
    """The kindest verdict that the exact value, or what ways of the whole column make of it, supports.

    Args:
        rounding: by which the angle may be another than the printed one [deg].
    """
    fields, number, kind, why = row.fields, row.number, Kind.NOT_REPRODUCIBLE, f"exact motion of {row.fields['scene']}"
    cause = next((text for text, value in made.items() if number.is_rounding_of(value)), None)
    if number.is_rounding_of(exact):
        kind, cause = Kind.AGREES, None
    elif cause in CAUSES:
        kind = Kind.EXPLAINED
    elif number.is_cut_of(exact):
        kind, cause = Kind.AFTER_ROUNDING, None
    elif cause:
        kind = Kind.WRONG_STEP
    elif nearest := _nearest_in_rounding(row, rounding):
        kind = Kind.AFTER_ROUNDING
        why += f"; it is {nearest[1]:.7g} at {nearest[0]:.7g} deg, which is printed as {row.condition}"
    reason = f"{cause} gives {made[cause]:.7g}; {why}" if cause else why
    if kind is Kind.AFTER_ROUNDING and number.is_cut_of(exact):
        reason += "; further digits are cut off instead of rounded"
    return Verdict(
        document, fields.get("place", ""), row.line, fields["quantity"], row.condition, fields["unit"],
        number.text, exact, (number.value - exact) / number.last, kind, reason,
        should_be=None if kind in GOOD else number.like(exact), cause=cause,
    )  # fmt: skip
