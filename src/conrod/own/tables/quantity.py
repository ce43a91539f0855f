"""What columns of a table may be, and the names under which it is found without being told."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
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
        aliases: other names, words joined by underscores.
        point, quantity, axis: of the observed motion; empty for the clock and the crank.
    """

    name: str
    unit: str
    aliases: tuple[str, ...]
    point: str = ""
    quantity: str = ""
    axis: int = 0


def targets(points: Sequence[str]) -> tuple[Target, ...]:
    """All that columns may be in a table of some observed points."""
    single = [Target(name, unit, (name, *others)) for name, (unit, others) in SINGLE.items()]
    return (*single, *(target for point in points for target in _of_point(point, alone=len(points) == 1)))


def _of_point(point: str, alone: bool) -> Iterator[Target]:
    for quantity, (letter, unit, words) in MOTION.items():
        for axis, axis_name in enumerate(AXES):
            named = [*((word, axis_name) for word in words), *((dots.format(axis_name),) for dots in DOTS[quantity])]
            aliases = ["_".join(filter(None, parts)) for name in named for parts in permutations((point, *name))]
            # Names without the point say enough where there is but one.
            aliases += ["_".join(filter(None, name)) for name in named] if alone else []
            yield Target(f"{point}.{letter}{axis_name}", unit, tuple(dict.fromkeys(aliases)), point, quantity, axis)


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
