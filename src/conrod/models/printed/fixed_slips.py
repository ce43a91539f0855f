"""Slips of one size that a whole column of printed values may suffer from: of pi, sign, zero and units."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import partial
from typing import TypeAlias

import numpy as np

from conrod.exact.motion import Array
from conrod.models.printed.exact_ranges import exact_values, in_printed_turn
from conrod.models.printed.rows import PrintedRow

# A cause is systematic where it reproduces this share of a quantity's printed values, and more of them than the exact
# motion does. One value is reproduced by something or other too easily.
SYSTEMATIC_SHARE, MIN_REPRODUCED = 0.9, 3
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

# Of links' angles: angles [rad] that lines lie at, from which a document may count in place of the link's own x axis.
LINES = {"the link's angle counted from its other end": math.pi}


def fixed_causes(rows: Sequence[PrintedRow], exact: Array) -> dict[str, Array]:
    """Find the slips of one size that reproduce a quantity's values as a whole, with the values (N,) that they give.

    Args:
        exact: exact values (N,) at the printed angles.
    """
    met, degrees = count_reproduced(rows, exact), np.array([row.degrees for row in rows])
    if met == len(rows):
        return {}
    slips = {**CAUSES, **SLIPS}
    every = {text: factor * exact_values(rows, turned(degrees)) for text, (turned, factor) in slips.items()}
    if rows[0].quantity[1] == "rotation":
        every |= {text: in_printed_turn(rows, exact + line * rows[0].factor) for text, line in LINES.items()}
    needed = max(MIN_REPRODUCED, SYSTEMATIC_SHARE * len(rows), met + 1)
    return {text: found for text, found in every.items() if count_reproduced(rows, found) >= needed}


def count_reproduced(rows: Sequence[PrintedRow], found: Array) -> int:
    """Count the printed values that are roundings of given values (N,)."""
    return sum(row.number.is_rounding_of(float(value)) for row, value in zip(rows, found, strict=True))
