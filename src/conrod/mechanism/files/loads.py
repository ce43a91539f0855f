"""Springs, dampers, forces and torques of a file."""

from __future__ import annotations

from conrod.errors import InvalidInput
from conrod.mechanism.files.fields import Fields
from conrod.mechanism.files.numbers import ANGLE, COORDINATE, FORCE, SPEED, Measure, shown
from conrod.mechanism.files.places import Places
from conrod.mechanism.loads import (
    Coordinate,
    Displacement,
    Distance,
    Elastic,
    Friction,
    Law,
    Load,
    SpeedLine,
    Steady,
    StrokePulse,
    TimePulse,
    Turn,
    Viscous,
)
from conrod.mechanism.mechanism import GROUND, ConstantForce

STIFFNESS, TURN_STIFFNESS = Measure("N/m", 1e-12, 1e12), Measure("N*m/rad", 1e-12, 1e12)
DAMPING, TURN_DAMPING = Measure("N*s/m", 1e-12, 1e12), Measure("N*m*s/rad", 1e-12, 1e12)
TORQUE = Measure("N*m", 0.0, 1e12, magnitude=True)
RESTING = Measure("m", 0.0, 1e6)
CREEP, TURN_CREEP = Measure("m/s", 1e-9, 1e6), Measure("rad/s", 1e-9, 1e6)
TIME = Measure("s", 0.0, 1e6)
SENSES = {"forward": 1, "backward": -1}
MOST_LOADS = 100
FORCE_LAWS = ("constant", "stroke-pulse", "time-pulse", "friction")
TORQUE_LAWS = ("constant", "speed-line", "time-pulse", "friction")


def read_loads(
    fields: Fields, places: Places, bodies: tuple[str, ...]
) -> tuple[tuple[ConstantForce, ...], tuple[Load, ...]]:
    """Constant forces, and all that follow a law.

    Raises:
        InvalidInput: names what cannot be used.
    """
    constant: list[ConstantForce] = []
    loads = [
        *(_spring(table, name, places) for table, name in _tables(fields, "springs")),
        *(_damper(table, name, places) for table, name in _tables(fields, "dampers")),
    ]
    for table, name in _tables(fields, "forces"):
        if "body" in table:
            constant.append(_constant(table, bodies))
        else:
            loads.append(_force(table, name, places))
    loads += [_torque(table, name, places) for table, name in _tables(fields, "torques")]
    if len(loads) > MOST_LOADS:
        raise InvalidInput(
            f"there are {len(loads)} springs, dampers, forces and torques: at most {MOST_LOADS} are read"
        )
    return tuple(constant), tuple(loads)


def _tables(fields: Fields, kind: str) -> list[tuple[Fields, str]]:
    whole = fields.table(kind)
    return [(whole.table(name), name) for name in whole.names()]


def _made(table: Fields, along: Coordinate, law: Law) -> Load:
    table.end()
    return Load(table.place, along, law)


def _constant(table: Fields, bodies: tuple[str, ...]) -> ConstantForce:
    body = table.choice("body", bodies)
    force = table.pair("force", FORCE, f"constant force on {body}")
    table.end()
    return ConstantForce(body, force)


def _spring(table: Fields, name: str, places: Places) -> Load:
    along = _between(table, places)
    if isinstance(along, Turn):
        law = Elastic(
            table.number("stiffness", TURN_STIFFNESS, f"stiffness of the spring {name}"),
            table.number("rest", ANGLE, f"turn at which the spring {name} is without torque", 0.0),
        )
    else:
        law = Elastic(
            table.number("stiffness", STIFFNESS, f"stiffness of the spring {name}"),
            table.number("rest", RESTING, f"length of the spring {name} without force", 0.0),
        )
    return _made(table, along, law)


def _damper(table: Fields, name: str, places: Places) -> Load:
    along = _between(table, places)
    measure = TURN_DAMPING if isinstance(along, Turn) else DAMPING
    return _made(table, along, Viscous(table.number("damping", measure, f"damping of the damper {name}")))


def _between(table: Fields, places: Places) -> Distance | Turn:
    """Two points by `connects`, or two bodies, of which the second turns against the first, by `turns`."""
    if ("connects" in table) == ("turns" in table):
        raise InvalidInput(
            f"{table.place}: give connects, the two points that it lies between, or turns, two bodies, that it lies "
            "between where it acts on their turn"
        )
    if "turns" in table:
        return _turn(table, places)
    first, second = places.pair(table, "connects")
    return Distance(first.body, second.body, first.point, second.point)


def _turn(table: Fields, places: Places) -> Turn:
    given = table.raw("turns")
    if not isinstance(given, list) or len(given) != 2 or not all(isinstance(some, str) for some in given):
        raise InvalidInput(f"{table.at('turns')} = {shown(given)}: the names of two bodies are wanted")
    first, second = (places.found(f"{table.at('turns')}[{k}]", some).body for k, some in enumerate(given))
    if first == second:
        raise InvalidInput(f"{table.at('turns')}: {first!r} does not turn against itself; two bodies are wanted")
    return Turn(first, second)


def _force(table: Fields, name: str, places: Places) -> Load:
    place = places.field(table, "point")
    if place.body == GROUND:
        raise InvalidInput(f"{table.at('point')}: a force on the ground moves nothing")
    along = Displacement(
        place.body,
        place.point,
        table.number("direction", ANGLE, f"direction in the document's frame that the force {name} acts along"),
    )
    law: Law
    match table.choice("law", FORCE_LAWS):
        case "constant":
            law = Steady(table.number("force", FORCE, f"constant force {name}"))
        case "stroke-pulse":
            law = StrokePulse(
                table.number("peak", FORCE, f"peak of the force {name}"),
                table.number("begin", COORDINATE, f"where along its direction the force {name} begins"),
                table.number("end", COORDINATE, f"where along its direction the force {name} ends"),
                SENSES[table.choice("against", SENSES)],
            )
            _check_growing(table, law.start, law.stop, "m")
        case "time-pulse":
            law = _time_pulse(table, FORCE, f"peak of the force {name}")
        case _:
            law = Friction(
                abs(table.number("force", FORCE, f"sliding friction {name}")),
                table.number("creep", CREEP, f"speed below which the friction {name} has not come up"),
            )
    return _made(table, along, law)


def _torque(table: Fields, name: str, places: Places) -> Load:
    along = _turn(table, places)
    law: Law
    match table.choice("law", TORQUE_LAWS):
        case "constant":
            law = Steady(table.number("torque", TORQUE, f"constant torque {name}"))
        case "speed-line":
            law = SpeedLine(
                table.number("stall", TORQUE, f"torque {name} at rest"),
                table.number("idle", SPEED, f"rate of turn at which the torque {name} is 0"),
            )
        case "time-pulse":
            law = _time_pulse(table, TORQUE, f"peak of the torque {name}")
        case _:
            law = Friction(
                abs(table.number("torque", TORQUE, f"friction torque {name}")),
                table.number("creep", TURN_CREEP, f"rate of turn below which the friction {name} has not come up"),
            )
    return _made(table, along, law)


def _time_pulse(table: Fields, measure: Measure, meaning: str) -> TimePulse:
    law = TimePulse(
        table.number("peak", measure, meaning),
        table.number("begin", TIME, "time at which the pulse begins", 0.0),
        table.number("end", TIME, "time at which the pulse ends"),
    )
    _check_growing(table, law.start, law.stop, "s")
    return law


def _check_growing(table: Fields, begin: float, end: float, unit: str) -> None:
    if not begin < end:
        raise InvalidInput(f"{table.place}: begin = {begin:g} {unit} must be less than end = {end:g} {unit}")
