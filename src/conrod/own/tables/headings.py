"""Headings as tools and people write them, "C.x [mm]", "time (s)", "x_C in mm", "t_ms": the quantity and its unit."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from itertools import permutations

from conrod.errors import InvalidInput
from conrod.mechanism.units import parse_quantity

TIME, CRANK_ANGLE, CRANK_SPEED, CRANK_ACCELERATION = "time", "crank_angle", "crank_speed", "crank_acceleration"
AXES = "xy"
# Quantity -> letter in conrod's own headings, SI unit, and what others call it before or after the axis.
MOTION = {
    "position": ("", "m", ("", "pos", "position", "r")),
    "velocity": ("v", "m/s", ("v", "vel", "velocity")),
    "acceleration": ("a", "m/s^2", ("a", "acc", "acceleration")),
}
DOTS = {"position": (), "velocity": ("{}dot", "{}_dot", "d{}"), "acceleration": ("{}ddot", "{}_ddot", "dd{}", "d2{}")}
# Of the crank and the clock: SI unit and other names.
SINGLE = {
    TIME: ("s", ("t", "zeit", "timestamp")),
    CRANK_ANGLE: ("rad", ("crank", "angle", "theta", "crank_theta", "theta_crank", "crank_phi", "angle_crank")),
    CRANK_SPEED: ("rad/s", ("omega", "crank_omega", "omega_crank", "angular_speed", "angular_velocity", "crank_rate")),
    CRANK_ACCELERATION: ("rad/s^2", ("alpha", "crank_alpha", "alpha_crank", "angular_acceleration")),
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
BRACKETED = re.compile(r"(?P<name>.*\S)\s*[\[({]\s*(?P<unit>[^\])}\d\s][^\])}]*)[\])}]\s*")
BEHIND = re.compile(r"(?P<name>.*[^\W_])(\s*/\s*|\s+in\s+|\s*,\s*|_)(?P<unit>\(?[^\s_,]+\)?)\s*")
NONE = ("", "-", "1", "none")


def readings(heading: str) -> tuple[tuple[str, str], ...]:
    """Readings of a heading, pairs of a name and its unit: with the unit in brackets, or else first as a name alone."""
    whole = " ".join(heading.split())
    if bracketed := BRACKETED.fullmatch(whole):
        return ((bracketed["name"], bracketed["unit"].strip()),)
    # Without brackets it is a unit only where it is one: "x/l" has none.
    behind = BEHIND.fullmatch(whole)
    if behind and is_unit(unit := behind["unit"].strip("()")):
        return (whole, ""), (behind["name"], unit)
    return ((whole, ""),)


def with_unit(heading: str, unit: str) -> str:
    """The heading with its unit from elsewhere, empty for none; of one that has another both stand there."""
    return heading if not unit or unit in [own for _, own in readings(heading)] else f"{heading} [{unit}]"


def bare_unit(cell: str) -> str | None:
    """The unit in a cell of a row of units, with or without brackets; empty for none, None where it is no unit."""
    text = cell.strip().strip("[](){}").strip()
    if text.lower() in NONE:
        return ""
    return text if is_unit(text) else None


def is_unit(text: str) -> bool:
    """True if this is a unit of anything that may stand in a table."""
    return any(factor(text, dimension) is not None for dimension in DIMENSIONS)


@cache
def factor(unit: str, dimension: str) -> float | None:
    """Factor from a unit to SI; None where it is no unit of the dimension.

    Args:
        dimension: an SI unit, a key of `DIMENSIONS`.
    """
    written = _tidy(unit)
    # Accelerometers read in g; elsewhere that is a gram.
    written = "gravity" if dimension == "m/s^2" and written == "g" else written
    # MM and Sec are slips of the pen; single letters mean other things in capitals.
    for way in dict.fromkeys((written, written.lower() if len(written) > 1 else written)):
        try:
            return parse_quantity("unit", f"1 {way}", dimension) if way else None
        except InvalidInput:
            continue
    return None


def _tidy(unit: str) -> str:
    """A unit as `parse_quantity` takes it, from what tools write: °, m/(s²)."""
    return unit.strip().replace("°", "deg").replace("(", "").replace(")", "")


# -- quantities ------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Target:
    """One thing that a column may be.

    Attributes:
        name: as in conrod's own tables, `C.x`, `C.vx`, `crank_angle`.
        unit: SI.
        point, quantity, axis: of the observed motion; empty for the clock and the crank.
        alone: whether there is no other point, so that names without the point say enough.
    """

    name: str
    unit: str
    point: str = ""
    quantity: str = ""
    axis: int = 0
    alone: bool = False

    @cached_property
    def aliases(self) -> frozenset[str]:
        """Other names."""
        if not self.point:
            return frozenset((self.name, *SINGLE[self.name][1]))
        axis, words = AXES[self.axis], MOTION[self.quantity][2]
        named = [*((word, axis) for word in words), *((dots.format(axis),) for dots in DOTS[self.quantity])]
        every = [parts for name in named for parts in permutations((self.point, *name))]
        every += named if self.alone else []
        return frozenset("".join(parts) for parts in every)


def targets(points: Sequence[str]) -> tuple[Target, ...]:
    """All that columns may be in a table of some observed points."""
    of_points = [
        Target(f"{point}.{letter}{axis_name}", unit, point, quantity, axis, alone=len(points) == 1)
        for point in points
        for quantity, (letter, unit, _) in MOTION.items()
        for axis, axis_name in enumerate(AXES)
    ]
    return (*(Target(name, unit) for name, (unit, _) in SINGLE.items()), *of_points)


def _letters(name: str) -> str:
    return re.sub(r"[\W_]+", "", name)


# Ways in which a heading may be one of the names, the strictest first.
WAYS: tuple[Callable[[str], str], ...] = (str, _letters, lambda name: _letters(name).casefold())


def meant_by(name: str, among: Sequence[Target]) -> Target | None:
    """The one thing that a name stands for; None where it is none, or may be several.

    Upper and lower case tell things apart before they are taken for the same: `Ax` is x of a point A, `ax` an
    acceleration.
    """
    for way in WAYS:
        wanted = way(name)
        found = [t for t in among if wanted in (way(t.name), *map(way, t.aliases))]
        if found:
            return found[0] if len(found) == 1 else None
    return None
