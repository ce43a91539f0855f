"""Mechanism files: parse a file and check its content, independent of the order in it; see docs/mechanism-files.md."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from conrod.errors import InvalidInput, no_such_file, unknown_choice
from conrod.mechanism.files.bodies import Places, read_bodies, read_points
from conrod.mechanism.files.fields import MAX_SHOWN_CHARACTERS, PARAMETERS, SPEED_NAME, Fields, Numbers, check_name
from conrod.mechanism.files.joints import read_drive, read_joints
from conrod.mechanism.files.loads import read_loads
from conrod.mechanism.files.proportions import check_proportions
from conrod.mechanism.files.start_poses import StartHint, place_bodies, read_start, with_start_offset
from conrod.mechanism.mechanism import GROUND, Body, Driver, HigherPair, Joint, Mechanism, ObservedPoint, Revolute
from conrod.mechanism.units import Parameter

FREE_FALL = Parameter("m/s^2", 0.0, 1e5, magnitude=True)
FRAME = "the ground's frame in the file: x to the right, y up; the crank angle counts from the start poses, {sense}"
# Names that engines' models reserve.
WORLD_NAME, CRANK_NAME = "world", "crank"
# Limit for users' files, which are data alone: a machine of 50 links takes 15 kB.
MAX_FILE_BYTES = 256 * 1024
# The parser's time grows with the square of the number of parts in a dotted name. A valid file needs 5 parts, none in
# quotes.
LONG_NAME = re.compile(r"(?<![A-Za-z0-9_-])(?:[A-Za-z0-9_-]++[ \t]*+\.[ \t]*+){20}")
QUOTED_PART = re.compile(r"""["'][ \t]*+\.""")
LONG_NUMBER = re.compile(r"[0-9_]{1000}")


@dataclass(frozen=True)
class MachineDescription:
    """The checked content of a mechanism file."""

    name: str
    title: str
    source: str
    about: str
    assumptions: tuple[str, ...]
    frame: str
    mechanism: Mechanism  # with approximate start poses
    speed: float  # crank speed [rad/s]
    output: str  # the observed point that does the machine's work
    hints: Mapping[str, StartHint]  # hints at the start poses, by body
    values: Mapping[str, float]  # all numbers of the file, SI, by place
    facts: Mapping[str, Parameter]

    @property
    def rates(self) -> dict[str, float]:
        """Turn rates [rad/s] of bodies, counter-clockwise, at the start of a free motion."""
        return {name: hint.rate for name, hint in self.hints.items() if hint.rate is not None}


def read_description(given: Mapping[str, Any], given_anew: Mapping[str, float]) -> MachineDescription:
    """Read a description from a file's tables, with some of its numbers replaced.

    Args:
        given: tables of the file.
        given_anew: values [SI] that replace those of the file, by place or parameter name.

    Raises:
        InvalidInput: names the field and what was expected.
    """
    numbers = Numbers(given_anew)
    fields = Fields(given, "", numbers)
    numbers.named = _read_parameters(fields)
    name = fields.text("name")
    check_name("name", name)
    title, source = fields.text("title"), fields.text("source")
    about, assumptions = fields.text("description", title + "."), fields.texts("assumptions")
    mechanism, speed, hints = _read_mechanism(fields, name)
    sense = "counter-clockwise" if mechanism.driver.sense > 0 else "clockwise"
    frame = fields.text("frame", FRAME.format(sense=sense))
    output = _read_output(fields, mechanism)
    fields.refuse_unknown()
    unused = [one for one in numbers.named if one not in numbers.values]
    if unused:
        raise InvalidInput(f"{PARAMETERS}.{unused[0]}: nothing in the file uses it")
    unknown = given_anew.keys() - numbers.values.keys()
    if unknown:
        raise unknown_choice("parameter", min(unknown)[:MAX_SHOWN_CHARACTERS], numbers.values)
    # Named parameters come first.
    values = {name: numbers.values[name] for name in numbers.named} | numbers.values
    facts = {name: numbers.facts[name] for name in values}
    return MachineDescription(
        name, title, source, about, assumptions, frame, mechanism, speed, output, hints, values, facts
    )


def _read_parameters(fields: Fields) -> dict[str, object]:
    """Raw values of [parameters], by name."""
    table = fields.table(PARAMETERS)
    for name in table.names():
        if name == SPEED_NAME or name[0].isdigit():
            why = "all machines call the crank's speed so" if name == SPEED_NAME else "it begins with a digit"
            raise InvalidInput(f"{table.place_of(name)}: {why}; give the parameter another name")
    return {name: table.raw(name) for name in table.names()}


def _read_mechanism(fields: Fields, name: str) -> tuple[Mechanism, float, dict[str, StartHint]]:
    """Read the mechanism, the crank speed [rad/s], and the start positions of bodies."""
    bodies, points = read_bodies(fields)
    ground = fields.table(GROUND)
    places = Places({**points, GROUND: read_points(ground, "the ground")})
    ground.refuse_unknown()
    joints = read_joints(fields, places)
    driver, speed = read_drive(fields, joints)
    bodies, joints = _sort_from_crank(bodies, joints, driver)
    names = tuple(body.name for body in bodies)
    hints = read_start(fields, places, crank=names[0])
    if fields.flag("drawn"):
        if driver.start or any(hint.turn is not None or hint.places for hint in hints.values()):
            raise InvalidInput(
                "drawn = true: all points are where they are at the start; leave out start and driver.start"
            )
        poses = dict.fromkeys(names, (0.0, 0.0, 0.0))
    else:
        poses = place_bodies(names, joints, driver, hints)
    mechanism = Mechanism(
        name,
        bodies,
        tuple(with_start_offset(joint, poses) for joint in joints),
        driver,
        poses,
        _read_observed(fields, places),
        fields.pair("gravity", FREE_FALL, "acceleration of free fall", (0.0, 0.0)),
        *read_loads(fields, places, names),
    )
    _check_names(mechanism)
    if not fields.numbers.given_anew:
        check_proportions(fields.numbers, bodies, places.of_body, fields.flag("drawn"))
    return mechanism, speed, hints


# -- order -----------------------------------------------------------------------------------------------------------


def _sort_from_crank(
    bodies: tuple[Body, ...], joints: tuple[Joint, ...], driver: Driver
) -> tuple[tuple[Body, ...], tuple[Joint, ...]]:
    """Sort bodies by breadth-first search from the crank, and joints with them; ties by name.

    Engines solve joints in order, and results depend on it where they stop early. So the order in the file must not
    matter, and this one follows the motion. Body `a` of a pin is the one that is reached first.

    Raises:
        InvalidInput: a body has no joint, or the mobility is not one.
    """
    joined = {body for joint in joints for body in (joint.a, joint.b)}
    for body in bodies:
        if body.name not in joined:
            raise InvalidInput(f"bodies.{body.name}: no joint holds it")
    _check_mobility(bodies, joints)
    by_name = sorted(joints, key=lambda joint: (joint.name != driver.joint, joint.name))
    reached = [body for body in (by_name[0].a, by_name[0].b) if body != GROUND]
    taken: list[Joint] = []
    for name in reached:
        here = [joint for joint in by_name if name in (joint.a, joint.b) and joint not in taken]
        taken += here
        new = {body: None for joint in here for body in (joint.a, joint.b) if body != GROUND and body not in reached}
        reached += new
    loose = sorted({body.name for body in bodies} - set(reached))
    if loose:
        raise InvalidInput(
            f"bodies.{loose[0]}: no chain of joints leads to it from the crank {reached[0]!r}: it would not move"
        )
    place = {name: k for k, name in enumerate([GROUND, *reached])}
    turned = [
        replace(joint, a=joint.b, b=joint.a, point_a=joint.point_b, point_b=joint.point_a)
        if isinstance(joint, Revolute) and place[joint.a] > place[joint.b]
        else joint
        for joint in taken
    ]
    return tuple(sorted(bodies, key=lambda body: place[body.name])), tuple(turned)


def _check_mobility(bodies: tuple[Body, ...], joints: tuple[Joint, ...]) -> None:
    """Refuse a mechanism whose mobility by Gruebler's count is not one."""
    higher = sum(isinstance(joint, HigherPair) for joint in joints)
    lower = len(joints) - higher
    if (mobility := 3 * len(bodies) - 2 * lower - higher) != 1:
        raise InvalidInput(
            f"mobility {mobility}: 3 x {len(bodies)} moving bodies - 2 x {lower} lower - {higher} higher pairs; one "
            "driven crank needs exactly 1, without special lengths"
        )


# -- names -----------------------------------------------------------------------------------------------------------


def _check_names(mechanism: Mechanism) -> None:
    """Refuse names that engines' models reserve."""
    if WORLD_NAME in mechanism.body_index:
        raise InvalidInput(f"bodies.{WORLD_NAME}: MuJoCo has this name for the ground; give it another one")
    for joint in mechanism.joints:
        if joint.name == CRANK_NAME and joint.name != mechanism.driver.joint:
            raise InvalidInput(f"joints.{CRANK_NAME}: models have this name for the driven joint; give it another one")
    for observed in mechanism.observed:
        if observed.name in mechanism.body_index:
            raise InvalidInput(f"observed.{observed.name}: a body has this name; give the point another one")


def _read_observed(fields: Fields, places: Places) -> tuple[ObservedPoint, ...]:
    """Read the observed points, at least one, none of the ground."""
    table = fields.table("observed")
    found = []
    for name in table.names():
        place = places.field(table, name)
        if place.body == GROUND:
            raise InvalidInput(f"{table.place_of(name)}: a point of the ground does not move")
        found.append(ObservedPoint(name, place.body, place.point))
    if not found:
        raise InvalidInput('there are no observed points: give [observed] with lines like C = "slider.C"')
    return tuple(found)


def _read_output(fields: Fields, mechanism: Mechanism) -> str:
    """Read the name of the observed point that does the machine's work."""
    names = [observed.name for observed in mechanism.observed]
    if len(names) == 1 and "output" not in fields:
        return names[0]
    if "output" not in fields:
        raise InvalidInput(
            f"there is no 'output', which is needed with several observed points: one of {', '.join(sorted(names))}; "
            "it stands before the first [table]"
        )
    return fields.choice("output", names)


def read_tables(path: Path) -> dict[str, Any]:
    """Read the tables of a TOML file; InvalidInput names the file and the line if it cannot be read."""
    try:
        if not path.is_file():
            raise InvalidInput("it is no regular file") if path.exists() else no_such_file(path)
        with path.open("rb") as file:
            content = file.read(MAX_FILE_BYTES + 1)
        if len(content) > MAX_FILE_BYTES:
            raise InvalidInput(f"it is too large: at most {MAX_FILE_BYTES // 1024} KiB are read")
        if not content.strip():
            raise InvalidInput("it is empty; `conrod init` writes a mechanism file to begin with")
        return parse_toml(content)
    except InvalidInput as error:
        raise error if str(error).startswith(str(path)) else InvalidInput(f"{path}: {error}") from None
    except OSError as error:
        raise InvalidInput(f"{path}: it cannot be read: {error.strerror or error}") from None


def parse_toml(content: bytes) -> dict[str, Any]:
    """Parse a TOML text into tables; InvalidInput gives the place of an error."""
    try:
        text = content.decode("utf-8-sig")  # some editors begin a file with a byte order mark
    except UnicodeDecodeError as error:
        raise InvalidInput(f"it is no text in UTF-8: byte {error.start} cannot be read; save it as UTF-8") from None
    for number, line in enumerate(text.split("\n"), 1):
        if LONG_NAME.search(line) or len(QUOTED_PART.findall(line)) > 20 or LONG_NUMBER.search(line):
            raise InvalidInput(f"line {number}: names of more than 20 parts and numbers of 1000 digits are not read")
    try:
        return tomllib.loads(text)
    except RecursionError:
        raise InvalidInput("its lists or tables lie too deep inside each other") from None
    except ValueError as error:
        raise InvalidInput(f"it is no TOML: {' '.join(str(error).split())[:200]}") from None
