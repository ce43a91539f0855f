"""Slips in columns of links' rotations: units, the sense of rotation, and the line that angles are counted from."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

from conrod.exact.link_rotations import ROTATIONS
from conrod.mechanism.units import REVOLUTION
from conrod.models.tables.columns import rotation_column
from conrod.models.tables.errors import TableComparison
from conrod.models.tables.slides import Hypothesis

# Pairs of units that are mistaken for each other, with the ratio of their sizes; either may be taken for the other.
ANGLE_SLIPS = {("degrees", "radians"): 180.0 / math.pi, ("turns", "radians"): 1.0 / REVOLUTION}
SPEED_SLIPS = {("deg/s", "rad/s"): 180.0 / math.pi, ("rpm", "rad/s"): 30.0 / math.pi}
# In words, the quantities whose columns suffer from one slip together.
SLIPPED_TOGETHER = {
    "rotations": ROTATIONS, "angles": ROTATIONS[:1], "angular velocities": ROTATIONS[1:2],
    "angular velocities and accelerations": ROTATIONS[1:],
}  # fmt: skip


def factors_both_ways(units: Mapping[tuple[str, str], float]) -> Iterator[tuple[float, str]]:
    """Factors of wrong values where one unit is taken for another, with the slip in words."""
    for (one, other), factor in units.items():
        yield factor, f"{one} taken for {other}"
        yield 1.0 / factor, f"{other} taken for {one}"


def link_hypotheses(table: TableComparison) -> Iterator[Hypothesis]:
    """Undo slips in the columns of links' rotations; slips of all columns come first."""
    if not table.rotation_columns:
        return
    own = tuple(quantity for quantity in ROTATIONS if table.links(quantity))
    for words, slipped in SLIPPED_TOGETHER.items():
        if not set(slipped) <= set(own) and slipped != ROTATIONS:
            continue
        units = ANGLE_SLIPS if "rotation" in slipped else SPEED_SLIPS
        for factor, slip in factors_both_ways(units):
            undone = table.scale_columns(1.0 / factor, *_columns(table, slipped))
            # What is right, a slip would have made wrong.
            if all((undone.largest(one) or 0.0) <= (table.largest(one) or 0.0) for one in slipped):
                yield "link angle unit", f"links' {words} are {factor:.6g} times too large: {slip}", undone, slipped
    clockwise = table.scale_columns(-1.0, *table.rotation_columns)
    yield "link angle sense", "links' rotations are counted clockwise", clockwise, ROTATIONS
    yield from _zero_slips(table)


def _columns(table: TableComparison, quantities: Sequence[str]) -> list[str]:
    """Columns of some quantities of all links."""
    return [rotation_column(quantity, link) for quantity in quantities for link in table.links(quantity)]


def _zero_slips(table: TableComparison) -> Iterator[Hypothesis]:
    """Undo angles that are counted from another line of the link than the link's x axis."""
    offsets = {link: float(table.rotation_difference("rotation", link).mean()) for link in table.links("rotation")}
    if not offsets:
        return
    values, parts = dict(table.values), []
    for link, offset in offsets.items():
        values[rotation_column("rotation", link)] = table.values[rotation_column("rotation", link)] - offset
        parts.append(f"{link} by {math.degrees(offset):.6g} deg")
    text = f"angles are counted from other lines than the links' own x axes: {', '.join(parts)}"
    yield "link angle zero", text, replace(table, values=values), ("rotation",)
