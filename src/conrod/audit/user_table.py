"""Printed values of a textbook of one's own: a table in CSV, each row tied to a machine, judged as the documents are.

A row's verdict rests on the other rows too: a cause is systematic where it reproduces a quantity's values as a whole,
and a misprint is what printed values beside it contradict.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence

from conrod.audit.judging import Case, Explanation, judge
from conrod.audit.user_neighbours import neighbours
from conrod.audit.user_rows import Row, read_rows
from conrod.audit.verdict import Verdict
from conrod.catalogue import scene_named
from conrod.scenes import Scene

# Values of pi that a document may have turned degrees into radians with.
SHORT_PI = {"3.14": 3.14, "3.142": 3.142, "3.1416": 3.1416, "3.14159": 3.14159, "22/7": 22.0 / 7.0}
# A cause is systematic where it reproduces this share of a quantity's printed values, and more of them than the exact
# motion does. One value is reproduced by something or other too easily.
SYSTEMATIC, FEWEST = 0.9, 3

Way = Callable[[Row], float]


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
    groups = _grouped(rows, lambda row: row.group)
    points = _grouped(rows, lambda row: (row.machine, row.point))
    causes = {group: _systematic(some, CAUSES) for group, some in groups.items()}
    slips = {group: _systematic(some, SLIPS) for group, some in groups.items()}
    return tuple(judge(_case(row, points[row.machine, row.point], causes[row.group], slips[row.group])) for row in rows)


def _grouped(rows: Sequence[Row], key: Callable[[Row], tuple[object, ...]]) -> dict[tuple[object, ...], list[Row]]:
    groups: dict[tuple[object, ...], list[Row]] = {}
    for row in rows:
        groups.setdefault(key(row), []).append(row)
    return groups


def _case(row: Row, beside: Sequence[Row], causes: Mapping[str, Way], slips: Mapping[str, Way]) -> Case:
    # Neighbours are asked only where the print is off: they cost more than all the rest.
    off = not row.item.number.is_rounding_of(row.exact)
    return Case(
        row.item,
        row.exact,
        f"exact motion of {row.item.mechanism}",
        causes=tuple(Explanation(text, way(row)) for text, way in causes.items()),
        neighbours=tuple(neighbours(row, beside)) if off else (),
        wrong_steps=tuple(Explanation(text, way(row)) for text, way in slips.items()),
    )


def _short_pi(pi: float) -> Way:
    return lambda row: row.value(row.degrees * pi / 180.0)


def _scaled(factor: float) -> Way:
    return lambda row: row.exact * factor


CAUSES: dict[str, Way] = {f"pi taken as {text} for the angle": _short_pi(pi) for text, pi in SHORT_PI.items()}
SLIPS: dict[str, Way] = {
    "the opposite sign": _scaled(-1.0),
    "the crank angle counted in the other sense": lambda row: row.value(-math.radians(row.degrees)),
    "the crank angle counted from the opposite dead centre": lambda row: row.value(math.radians(row.degrees) + math.pi),
    "degrees taken for radians": lambda row: row.value(row.degrees),
    "degrees taken for radians in the speed": _scaled(180.0 / math.pi),
    **{f"a unit {10**k} times as large": _scaled(10.0**-k) for k in (1, 2, 3)},
    **{f"a unit {10**k} times as small": _scaled(10.0**k) for k in (1, 2, 3)},
}


def _systematic(rows: Sequence[Row], ways: Mapping[str, Way]) -> dict[str, Way]:
    """Those ways that reproduce a quantity's values as a whole."""
    met = sum(row.item.number.is_rounding_of(row.exact) for row in rows)
    found: dict[str, Way] = {}
    if met == len(rows):
        return found
    for text, way in ways.items():
        so_many = sum(row.item.number.is_rounding_of(way(row)) for row in rows)
        if so_many >= max(FEWEST, SYSTEMATIC * len(rows)) and so_many > met:
            found[text] = way
    return found
