"""Springs, dampers, forces and torques of a file."""

from __future__ import annotations

from conrod.errors import InvalidInput
from conrod.mechanism.files.bodies import Places
from conrod.mechanism.files.fields import ANGLE, COORDINATE, SPEED, Fields
from conrod.mechanism.loads import (
    Displacement,
    Distance,
    Elastic,
    Friction,
    Load,
    LoadLaw,
    SpeedLine,
    Steady,
    StrokePulse,
    TimePulse,
    Turn,
    Viscous,
)
from conrod.mechanism.mechanism import GROUND, ConstantForce
from conrod.mechanism.units import Parameter

# For a distance, and for a rotation.
STIFFNESSES = Parameter("N/m", 1e-12, 1e12), Parameter("N*m/rad", 1e-12, 1e12)
DAMPING = Parameter("N*s/m", 1e-12, 1e12), Parameter("N*m*s/rad", 1e-12, 1e12)
FORCE, TORQUE = Parameter("N", 0.0, 1e12, magnitude=True), Parameter("N*m", 0.0, 1e12, magnitude=True)
CREEP = Parameter("m/s", 1e-9, 1e6), Parameter("rad/s", 1e-9, 1e6)
REST_LENGTH = Parameter("m", 0.0, 1e6)
TIME = Parameter("s", 0.0, 1e6)
RESISTED_SENSES = {"forward": 1, "backward": -1}
LAW_NAMES = {
    "force": ("constant", "stroke-pulse", "time-pulse", "friction"),
    "torque": ("constant", "speed-line", "time-pulse", "friction"),
}


def read_loads(
    fields: Fields, places: Places, bodies: tuple[str, ...]
) -> tuple[tuple[ConstantForce, ...], tuple[Load, ...]]:
    """Read constant forces, and loads that follow a law; InvalidInput names what cannot be used."""
    constant: list[ConstantForce] = []
    loads = [_spring(table, name, places) for name, table in fields.named_tables("springs").items()]
    loads += [_damper(table, name, places) for name, table in fields.named_tables("dampers").items()]
    for name, table in fields.named_tables("forces").items():
        if "body" in table:
            body = table.choice("body", bodies)
            constant.append(ConstantForce(body, table.pair("force", FORCE, f"constant force on {body}")))
            table.refuse_unknown()
        else:
            loads.append(_force(table, name, places))
    for name, table in fields.named_tables("torques").items():
        loads.append(_build_load(table, _turn(table, places), _law(table, "torque", name)))
    return tuple(constant), tuple(loads)


def _build_load(table: Fields, coordinate: Distance | Turn | Displacement, law: LoadLaw) -> Load:
    """Build a load, after refusing unknown fields."""
    table.refuse_unknown()
    return Load(table.place, coordinate, law)


def _spring(table: Fields, name: str, places: Places) -> Load:
    """Read a spring between two points, or on the rotation of two bodies."""
    along = _distance_or_turn(table, places)
    turns = isinstance(along, Turn)
    stiffness = table.number("stiffness", STIFFNESSES[turns], f"stiffness of the spring {name}")
    if turns:
        rest = table.number("rest", ANGLE, f"turn at which the spring {name} is without torque", 0.0)
    else:
        rest = table.number("rest", REST_LENGTH, f"length of the spring {name} without force", 0.0)
    return _build_load(table, along, Elastic(stiffness, rest))


def _damper(table: Fields, name: str, places: Places) -> Load:
    """Read a damper between two points, or on the rotation of two bodies."""
    along = _distance_or_turn(table, places)
    damping = table.number("damping", DAMPING[isinstance(along, Turn)], f"damping of the damper {name}")
    return _build_load(table, along, Viscous(damping))


def _distance_or_turn(table: Fields, places: Places) -> Distance | Turn:
    """Read the coordinate of a spring or damper: two points by `connects`, or two bodies by `turns`."""
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
    """Read the rotation of one body against another."""
    given = table.entries("turns", "the names of two bodies are wanted", kind=str)
    first, second = (places.find_point(f"{table.place_of('turns')}[{k}]", some).body for k, some in enumerate(given))
    if first == second:
        raise InvalidInput(f"{table.place_of('turns')}: {first!r} does not turn against itself; two bodies are wanted")
    return Turn(first, second)


def _force(table: Fields, name: str, places: Places) -> Load:
    """Read a force on a point along a direction."""
    place = places.field(table, "point")
    if place.body == GROUND:
        raise InvalidInput(f"{table.place_of('point')}: a force on the ground moves nothing")
    direction = table.number("direction", ANGLE, f"direction in the document's frame that the force {name} acts along")
    return _build_load(table, Displacement(place.body, place.point, direction), _law(table, "force", name))


def _law(table: Fields, kind: str, name: str) -> LoadLaw:
    """Read the law of a force or a torque."""
    turns = kind == "torque"
    size = TORQUE if turns else FORCE
    match table.choice("law", LAW_NAMES[kind]):
        case "constant":
            return Steady(table.number(kind, size, f"constant {kind} {name}"))
        case "speed-line":
            return SpeedLine(
                table.number("stall", size, f"torque {name} at rest"),
                table.number("idle", SPEED, f"rate of turn at which the torque {name} is 0"),
            )
        case "friction":
            meaning, rate = ("friction torque", "rate of turn") if turns else ("sliding friction", "speed")
            return Friction(
                abs(table.number(kind, size, f"{meaning} {name}")),
                table.number("creep", CREEP[turns], f"{rate} below which the friction {name} has not come up"),
            )
        case "time-pulse":
            return TimePulse(
                table.number("peak", size, f"peak of the {kind} {name}"),
                table.number("begin", TIME, "time at which the pulse begins", 0.0),
                table.number("end", TIME, "time at which the pulse ends"),
            )
        case _:
            return StrokePulse(
                table.number("peak", size, f"peak of the force {name}"),
                table.number("begin", COORDINATE, f"where along its direction the force {name} begins"),
                table.number("end", COORDINATE, f"where along its direction the force {name} ends"),
                RESISTED_SENSES[table.choice("against", RESISTED_SENSES)],
            )
