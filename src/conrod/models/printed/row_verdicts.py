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
from conrod.models.printed.rows import AXES, PrintedRow
from conrod.models.printed.verdicts import ACCEPTED_KINDS, PrintedVerdict, VerdictKind

# A cause is systematic where it reproduces this share of a quantity's printed values, and more of them than the exact
# motion does. One value is reproduced by something or other too easily.
SYSTEMATIC_SHARE, MIN_REPRODUCED = 0.9, 3
EVEN_TOLERANCE = 1e-6  # of a distance between angles, by which equal ones may differ
ROUNDING_SAMPLES = 41  # angles within the rounding of a printed one that are looked at
# Crank angles [rad] that printed ones [deg] were taken for, and the factor of the values there.
AngleSlip: TypeAlias = tuple[Callable[[Array], Array], float]
# Values of pi that a document may have turned degrees into radians with.
SHORT_PI = {"3.14": 3.14, "3.142": 3.142, "3.1416": 3.1416, "3.14159": 3.14159, "22/7": 22.0 / 7.0}
CAUSES: dict[str, AngleSlip] = {
    f"pi taken as {text} for the angle": (partial(np.multiply, pi / 180.0), 1.0) for text, pi in SHORT_PI.items()
}
SLIPS: dict[str, AngleSlip] = {
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


def exact_values(rows: Sequence[PrintedRow], angles: Array) -> Array:
    """Exact values (N,) at crank angles (N,) [rad], in the printed unit; NaN beyond the machine's span.

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


def verdicts_on(document: str, rows: Sequence[PrintedRow]) -> Iterator[PrintedVerdict]:
    """Judge the rows of a group."""
    degrees = np.array([row.degrees for row in rows])
    exact = exact_values(rows, np.radians(degrees))
    for k in np.flatnonzero(np.isnan(exact))[:1]:
        first, last = np.degrees(rows[k].scene.mechanism().driver.span or (0.0, 0.0))
        driven = f"{rows[k].fields['scene']} is driven from {first:g} to {last:g} deg"
        raise InvalidInput(f"row {rows[k].line}: angle_deg = {degrees[k]:g}: {driven}")
    met = _count_reproduced(rows, exact)
    ways = CAUSES | SLIPS if met < len(rows) else {}
    every = {text: factor * exact_values(rows, turned(degrees)) for text, (turned, factor) in ways.items()}
    needed = max(MIN_REPRODUCED, SYSTEMATIC_SHARE * len(rows), met + 1)
    made = {text: found for text, found in every.items() if _count_reproduced(rows, found) >= needed}
    chosen = _is_even(degrees)
    for k, row in enumerate(rows):
        ways_here = {text: float(found[k]) for text, found in made.items()}
        yield _verdict(document, row, float(exact[k]), ways_here, 0.0 if chosen else row.rounding)


def _is_even(degrees: Array) -> bool:
    """True if a quantity is printed at evenly spaced angles, which are chosen and not rounded."""
    steps = np.diff(np.unique(degrees))
    return len(steps) >= MIN_REPRODUCED - 1 and bool(np.ptp(steps) <= EVEN_TOLERANCE * steps.max())


def _nearest_in_rounding(row: PrintedRow, rounding: float) -> tuple[float, float] | None:
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


def _count_reproduced(rows: Sequence[PrintedRow], found: Array) -> int:
    """Count the printed values that are roundings of given values."""
    return sum(row.number.is_rounding_of(float(value)) for row, value in zip(rows, found, strict=True))


def _verdict(
    document: str, row: PrintedRow, exact: float, made: Mapping[str, float], rounding: float
) -> PrintedVerdict:
    """The most lenient verdict that the exact value, or a systematic slip of the whole column, supports.

    Args:
        rounding: largest difference of the angle from the printed one [deg].
    """
    fields, number, kind, why = (
        row.fields,
        row.number,
        VerdictKind.NOT_REPRODUCIBLE,
        f"exact motion of {row.fields['scene']}",
    )
    cause = next((text for text, value in made.items() if number.is_rounding_of(value)), None)
    if number.is_rounding_of(exact):
        kind, cause = VerdictKind.AGREES, None
    elif cause in CAUSES:
        kind = VerdictKind.EXPLAINED
    elif number.is_truncation_of(exact):
        kind, cause = VerdictKind.AFTER_ROUNDING, None
    elif cause:
        kind = VerdictKind.WRONG_STEP
    elif nearest := _nearest_in_rounding(row, rounding):
        kind = VerdictKind.AFTER_ROUNDING
        why += f"; it is {nearest[1]:.7g} at {nearest[0]:.7g} deg, which is printed as {row.condition}"
    reason = f"{cause} gives {made[cause]:.7g}; {why}" if cause else why
    if kind is VerdictKind.AFTER_ROUNDING and number.is_truncation_of(exact):
        reason += "; further digits are cut off instead of rounded"
    return PrintedVerdict(
        document, fields.get("place", ""), row.line, fields["quantity"], row.condition, fields["unit"],
        number.text, exact, (number.value - exact) / number.last, kind, reason,
        should_be=None if kind in ACCEPTED_KINDS else number.format_like(exact), cause=cause,
    )  # fmt: skip
