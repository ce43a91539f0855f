"""Headings of tables, "C.x [mm]", "time (s)", "x_C": the quantity and its unit."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache

from conrod.errors import InvalidInput
from conrod.mechanism.units import parse_quantity

TIME, CRANK_ANGLE, CRANK_SPEED, CRANK_ACCELERATION = "time", "crank_angle", "crank_speed", "crank_acceleration"
AXES = "xy"
# Quantity -> letter in conrod's own headings, SI unit.
MOTION = {"position": ("", "m"), "velocity": ("v", "m/s"), "acceleration": ("a", "m/s^2")}
# Of the clock and the crank: SI unit and another name.
SINGLE = {
    TIME: ("s", "t"),
    CRANK_ANGLE: ("rad", "theta"),
    CRANK_SPEED: ("rad/s", "omega"),
    CRANK_ACCELERATION: ("rad/s^2", "alpha"),
}
# What may stand in a table, and what a user calls it. Lengths and angles each with their rates.
DIMENSIONS = {
    "s": "time",
    "m": "length",
    "m/s": "velocity",
    "m/s^2": "acceleration",
    "rad": "angle",
    "rad/s": "angular speed",
    "rad/s^2": "angular acceleration",
}
# What begins with a digit is no unit but an index: r_0[1].
BRACKETED = re.compile(r"(?P<name>.*\S)\s*[\[(]\s*(?P<unit>[^\])\d\s][^\])]*)[\])]\s*")
NONE = ("", "-", "1")


def parted(heading: str) -> tuple[str, str]:
    """The name in a heading and the unit that stands in brackets behind it, empty for none."""
    found = BRACKETED.fullmatch(" ".join(heading.split()))
    return (found["name"], found["unit"].strip()) if found else (heading.strip(), "")


def with_unit(heading: str, unit: str) -> str:
    """The heading with its unit from elsewhere, empty for none; of one that has another both stand there."""
    return heading if unit in ("", parted(heading)[1]) else f"{heading} [{unit}]"


def bare_unit(cell: str) -> str | None:
    """The unit in a cell of a row of units, with or without brackets; empty for none, None where it is no unit."""
    text = cell.strip().strip("[]()").strip()
    return "" if text in NONE else text if is_unit(text) else None


def is_unit(text: str) -> bool:
    """True if this is a unit of anything that may stand in a table."""
    return any(factor(text, dimension) is not None for dimension in DIMENSIONS)


@cache
def factor(unit: str, dimension: str) -> float | None:
    """Factor from a unit to SI; None where it is no unit of the dimension.

    Args:
        dimension: an SI unit, a key of `DIMENSIONS`.
    """
    try:
        return parse_quantity("unit", f"1 {unit.replace('°', 'deg')}", dimension) if unit.strip() else None
    except InvalidInput:
        return None


# -- quantities ------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Target:
    """One thing that a column may be.

    Attributes:
        name: as in conrod's own tables, `C.x`, `C.vx`, `crank_angle`.
        unit: SI.
        point, quantity, axis: of the observed motion; empty for the clock and the crank.
        others: names that mean it too, in letters and digits.
    """

    name: str
    unit: str
    point: str = ""
    quantity: str = ""
    axis: int = 0
    others: tuple[str, ...] = ()


def targets(points: Sequence[str]) -> tuple[Target, ...]:
    """All that columns may be in a table of some observed points; the only one needs no name there."""
    of_points = []
    for point in points:
        for quantity, (letter, unit) in MOTION.items():
            for k, axis in enumerate(AXES):
                others = (f"{letter}{axis}{_letters(point)}", *([f"{letter}{axis}"] if len(points) == 1 else []))
                of_points.append(Target(f"{point}.{letter}{axis}", unit, point, quantity, k, others))
    return (*(Target(name, unit, others=(other,)) for name, (unit, other) in SINGLE.items()), *of_points)


def meant_by(name: str, among: Sequence[Target]) -> Target | None:
    """The one thing that a name stands for; None where it is none, or may be several.

    Upper and lower case tell things apart before they are taken for the same: `Ax` is x of a point A, `ax` an
    acceleration.
    """
    if exact := [target for target in among if target.name == name]:
        return exact[0]
    for way in (str, str.casefold):
        wanted = way(_letters(name))
        found = [t for t in among if wanted in [way(one) for one in (_letters(t.name), *t.others)]]
        if found:
            return found[0] if len(found) == 1 else None
    return None


def _letters(name: str) -> str:
    return re.sub(r"[\W_]+", "", name)
