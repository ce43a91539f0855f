"""Printed values of a user's own: a table in CSV, each row tied to a machine, judged as the documents are.

A row's verdict rests on the other rows too: a cause is systematic where it reproduces a quantity's values as a whole,
and a misprint is a print that the values beside it contradict: its components or its size, the rows before and after.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from typing import TypeAlias

import numpy as np

from conrod.exact.motion import Array
from conrod.own.printed.judging import Case, Explanation, Neighbour, Verdict, judge
from conrod.own.printed.user_rows import Row, grouped, read_rows, values
from conrod.scenes import Scene
from conrod.scenes.catalogue import scene_named

# Rows that a value is interpolated from: more reach farther from it and spoil it if one of them is wrong.
NEAREST = (4, 2)
DECISIVE = 2.0


def _of_components(row: Row, rows: Sequence[Row]) -> Iterator[Neighbour]:
    """The size from both components, or a component from the size and the other."""
    beside = {
        other.axis: other
        for other in rows
        if other is not row and (other.derivative, other.degrees) == (row.derivative, row.degrees)
    }
    others = [beside[axis] for axis in ("x", "y", "size") if axis != row.axis and axis in beside]
    if len(others) < 2:
        return
    # In the unit of this row.
    first, second = (other.item.number.value * row.factor / other.factor for other in others)
    halves = [0.5 * other.item.number.last * row.factor / other.factor for other in others]
    text = " beside ".join(f"{other.item.quantity} = {other.item.number.text}" for other in others)
    if row.axis == "size":
        yield Neighbour(text, math.hypot(first, second), sum(halves))
    elif second > abs(first):
        # The size comes last; the sign is the print's own.
        value = math.copysign(math.sqrt(second**2 - first**2), row.item.number.value)
        yield Neighbour(text, value, (second * halves[1] + abs(first) * halves[0]) / abs(value))


def _of_rows(row: Row, rows: Sequence[Row]) -> Iterator[Neighbour]:
    """The value interpolated from the nearest rows of the same quantity, one print at each angle.

    Lagrange's polynomial through the printed values; how far it may be off is what rounding of the prints does to it,
    and what the same polynomial through the exact values leaves.
    """
    series = {o.degrees: o for o in rows if o.group == row.group and o.degrees != row.degrees}
    for count in NEAREST:
        near = sorted(sorted(series, key=lambda degrees: abs(degrees - row.degrees))[:count])
        # Only between rows on both sides: beyond the last one a polynomial knows nothing.
        if len(near) < count or not near[0] < row.degrees < near[-1]:
            continue
        some = [series[degrees] for degrees in near]
        weights = _lagrange(np.array(near), row.degrees)
        value = float(weights @ [other.item.number.value for other in some])
        rounding = float(np.abs(weights) @ [0.5 * other.item.number.last for other in some])
        curve = abs(float(weights @ [other.exact for other in some]) - row.exact)
        # A contradiction as large as what the polynomial itself may be off proves nothing.
        if abs(value - row.item.number.value) > DECISIVE * (rounding + curve):
            angles = ", ".join(f"{degrees:g}" for degrees in near)
            yield Neighbour(f"interpolation between the rows at {angles} deg", value, rounding + curve)


def _lagrange(places: Array, at: float) -> Array:
    """Weights (N,) of the values at N places in the value of their polynomial at another place."""
    apart = places[:, None] - places[None, :]
    np.fill_diagonal(apart, 1.0)
    reach = np.where(np.eye(len(places), dtype=bool), 1.0, at - places[None, :])
    return np.asarray(np.prod(reach / apart, axis=1))


# Values of pi that a document may have turned degrees into radians with.
SHORT_PI = {"3.14": 3.14, "3.142": 3.142, "3.1416": 3.1416, "3.14159": 3.14159, "22/7": 22.0 / 7.0}
# A cause is systematic where it reproduces this share of a quantity's printed values, and more of them than the exact
# motion does. One value is reproduced by something or other too easily.
SYSTEMATIC, FEWEST = 0.9, 3

# Rows of one group -> what their values would be, (N,), NaN where there is none.
Way: TypeAlias = Callable[[Sequence[Row]], Array]


def audit_table(document: str, text: str, scene_of: Callable[[str], Scene] = scene_named) -> tuple[Verdict, ...]:
    """A verdict on every row.

    Args:
        document: what the table is called in errors, and in the verdicts on rows that name no document.
        text: of the table.
        scene_of: finds the machine that a row names.

    Raises:
        InvalidInput: the table or a row cannot be used; names the row and what is wanted.
    """
    rows = read_rows(document, text, scene_of)
    beside = {id(row): some for some in grouped(rows, lambda row: (row.machine, row.point)) for row in some}
    judged = [
        (row.number, judge(case))
        for group in grouped(rows, lambda row: row.group)
        for row, case in zip(group, _cases(group, beside), strict=True)
    ]
    return tuple(verdict for _, verdict in sorted(judged, key=lambda pair: pair[0]))


def _cases(group: Sequence[Row], beside: Mapping[int, Sequence[Row]]) -> Iterator[Case]:
    """A case for each row of a group; `beside` has all rows of its point."""
    causes, slips = _systematic(group, CAUSES), _systematic(group, SLIPS)
    for place, row in enumerate(group):
        slipped = _explanations(slips, place)
        # Neighbours are asked only where the print is off: they cost more than all the rest. And where a slip runs
        # through the whole quantity they have slipped too.
        off = not any(row.item.number.is_rounding_of(value) for value in (row.exact, *(s.value for s in slipped)))
        yield Case(
            row.item,
            row.exact,
            f"exact motion of {row.item.mechanism}",
            causes=_explanations(causes, place),
            neighbours=(*_of_components(row, beside[id(row)]), *_of_rows(row, beside[id(row)])) if off else (),
            wrong_steps=slipped,
        )


def _explanations(ways: Mapping[str, Array], place: int) -> tuple[Explanation, ...]:
    """Explanations of one row; one that leads out of the machine's reach is none."""
    return tuple(Explanation(text, float(found[place])) for text, found in ways.items() if np.isfinite(found[place]))


def _turned(turn: Callable[[Array], Array]) -> Way:
    """The exact values at other angles, made from the printed ones [deg]."""
    return lambda rows: values(rows, turn(np.array([row.degrees for row in rows])))


def _scaled(factor: float) -> Way:
    return lambda rows: factor * np.array([row.exact for row in rows])


def _shifted(rows: int) -> Way:
    """The exact values that belong some rows further on, in a table of even steps."""

    def way(group: Sequence[Row]) -> Array:
        places = np.unique([row.degrees for row in group])
        if len(places) < 2:
            return np.full(len(group), np.nan)
        step = float(np.median(np.diff(places)))
        return values(group, np.radians([row.degrees + rows * step for row in group]))

    return way


CAUSES: dict[str, Way] = {
    f"pi taken as {text} for the angle": _turned(partial(np.multiply, pi / 180.0)) for text, pi in SHORT_PI.items()
}
SLIPS: dict[str, Way] = {
    "the opposite sign": _scaled(-1.0),
    "the crank angle counted in the other sense": _turned(lambda degrees: -np.radians(degrees)),
    "the crank angle counted from the opposite dead centre": _turned(lambda degrees: np.radians(degrees) + np.pi),
    "the value of the angle one step before": _shifted(-1),
    "the value of the angle one step after": _shifted(1),
    "the crank angle counted from a line 90 deg further on": _turned(lambda degrees: np.radians(degrees) + 0.5 * np.pi),
    "the crank angle counted from a line 90 deg back": _turned(lambda degrees: np.radians(degrees) - 0.5 * np.pi),
    "degrees taken for radians": _turned(lambda degrees: degrees),
    "degrees taken for radians in the speed": _scaled(180.0 / np.pi),
    **{f"a unit {10**k} times as large": _scaled(10.0**-k) for k in (1, 2, 3)},
    **{f"a unit {10**k} times as small": _scaled(10.0**k) for k in (1, 2, 3)},
}


def _systematic(rows: Sequence[Row], ways: Mapping[str, Way]) -> dict[str, Array]:
    """Those ways that reproduce a quantity's values as a whole, with what they make of each."""
    met = _met(rows, np.array([row.exact for row in rows]))
    if met == len(rows):
        return {}
    made = {text: way(rows) for text, way in ways.items()}
    return {
        text: found
        for text, found in made.items()
        if _met(rows, found) >= max(FEWEST, SYSTEMATIC * len(rows)) and _met(rows, found) > met
    }


def _met(rows: Sequence[Row], found: Array) -> int:
    """Number of printed values that are these, rounded."""
    return sum(row.item.number.is_rounding_of(float(value)) for row, value in zip(rows, found, strict=True))
