"""Quantities that columns of a table may hold, and the names under which they are recognised."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import permutations

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
        """Other names, words joined by underscores."""
        if not self.point:
            return frozenset((self.name, *SINGLE[self.name][1]))
        axis, words = AXES[self.axis], MOTION[self.quantity][2]
        named = [*((word, axis) for word in words), *((dots.format(axis),) for dots in DOTS[self.quantity])]
        every = [parts for name in named for parts in permutations((self.point, *name))]
        every += named if self.alone else []
        return frozenset("_".join(filter(None, parts)) for parts in every)


def targets(points: Sequence[str]) -> tuple[Target, ...]:
    """All that columns may be in a table of some observed points."""
    of_points = [
        Target(f"{point}.{letter}{axis_name}", unit, point, quantity, axis, alone=len(points) == 1)
        for point in points
        for quantity, (letter, unit, _) in MOTION.items()
        for axis, axis_name in enumerate(AXES)
    ]
    return (*(Target(name, unit) for name, (unit, _) in SINGLE.items()), *of_points)


def _words(name: str) -> str:
    return re.sub(r"[\W_]+", "_", name).strip("_")


# Ways in which a heading may be one of the names, the strictest first.
WAYS: tuple[Callable[[str], str], ...] = (
    lambda name: name,
    _words,
    lambda name: _words(name).replace("_", ""),
    lambda name: _words(name).casefold(),
    lambda name: _words(name).replace("_", "").casefold(),
)


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
