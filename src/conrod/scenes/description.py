"""The checked content of a mechanism file, and checks of how far its input reaches."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from conrod.errors import InvalidInput, unknown_choice
from conrod.exact.kinematics import Kinematics
from conrod.mechanism.files.bodies import ordered, read_bodies
from conrod.mechanism.files.fields import Fields, check_name
from conrod.mechanism.files.joints import read_drive, read_joints
from conrod.mechanism.files.loads import read_loads
from conrod.mechanism.files.numbers import FREE_FALL, SHOWN, Numbers
from conrod.mechanism.files.places import Places, read_ground
from conrod.mechanism.mechanism import GROUND, Mechanism, ObservedPoint
from conrod.mechanism.parameters import Parameter
from conrod.scenes.start_poses import Hint, fitted, placed, rates_of, read_start

FRAME = "the ground's frame in the file: x to the right, y up; the crank angle counts from the start poses, {sense}"
# Names that models in engines have uses of their own for.
WORLD, CRANK = "world", "crank"


@dataclass(frozen=True)
class Description:
    """A file that was read.

    Attributes:
        mechanism: with approximate start poses.
        speed: of the crank [rad/s].
        output: the observed point that does the machine's work.
        hints: what the file says of the start poses, by body.
        rates: turn rates [rad/s] of bodies, counter-clockwise, that a motion without a drive starts with.
        values, facts: all numbers of the file, SI, by place.
    """

    name: str
    title: str
    source: str
    assumptions: tuple[str, ...]
    about: str
    frame: str
    mechanism: Mechanism
    speed: float
    output: str
    hints: Mapping[str, Hint]
    rates: Mapping[str, float]
    values: Mapping[str, float]
    facts: Mapping[str, Parameter]


def read_description(given: Mapping[str, Any], given_anew: Mapping[str, float]) -> Description:
    """The description that a file's tables give, with some of its numbers given anew.

    Raises:
        InvalidInput: names the field and what was expected.
    """
    numbers = Numbers(given_anew)
    fields = Fields(given, "", numbers)
    name = fields.text("name")
    check_name("name", name)
    about = {key: fields.text(key) for key in ("title", "source")}
    text, assumptions = fields.text("description", about["title"] + "."), fields.texts("assumptions")
    mechanism, speed, hints = _mechanism(fields, name)
    sense = "counter-clockwise" if mechanism.driver.sense > 0 else "clockwise"
    frame = fields.text("frame", FRAME.format(sense=sense))
    output = _output(fields, mechanism)
    fields.end()
    unknown = given_anew.keys() - numbers.values.keys()
    if unknown:
        raise unknown_choice("parameter", min(unknown)[:SHOWN], numbers.values)
    return Description(
        name, **about, assumptions=assumptions, about=text, frame=frame, mechanism=mechanism, speed=speed,
        output=output, hints=hints, rates=rates_of(hints), values=numbers.values, facts=numbers.facts,
    )  # fmt: skip


def _mechanism(fields: Fields, name: str) -> tuple[Mechanism, float, dict[str, Hint]]:
    bodies, points = read_bodies(fields)
    places = Places({**points, GROUND: read_ground(fields)})
    read = read_joints(fields, places)
    driver, speed = read_drive(fields, read.joints)
    structure = ordered(bodies, read.joints, driver)
    crank = structure.bodies[0].name
    hints = read_start(fields, places, crank)
    if fields.truth("drawn"):
        if driver.start or any(hint.tells_pose for hint in hints.values()):
            raise InvalidInput(
                "drawn = true: all points are where they are at the start; leave out start and driver.start"
            )
        poses = {body.name: (0.0, 0.0, 0.0) for body in structure.bodies}
    else:
        poses = placed(structure, driver, hints)
    mechanism = Mechanism(
        name,
        structure.bodies,
        tuple(fitted(joint, poses) if joint.name in read.to_fit else joint for joint in structure.joints),
        driver,
        poses,
        _observed(fields, places),
        fields.pair("gravity", FREE_FALL, "acceleration of free fall", (0.0, 0.0)),
        *read_loads(fields, places, tuple(body.name for body in structure.bodies)),
    )
    _check_names(mechanism)
    return mechanism, speed, hints


def _check_names(mechanism: Mechanism) -> None:
    """Refuse names that a model in an engine has two uses for.

    Raises:
        InvalidInput: names the one that has to be another.
    """
    bodies = set(mechanism.body_index)
    if WORLD in bodies:
        raise InvalidInput(f"bodies.{WORLD}: MuJoCo has this name for the ground; give it another one")
    for joint in mechanism.joints:
        if joint.name == CRANK and joint.name != mechanism.driver.joint:
            raise InvalidInput(f"joints.{CRANK}: models have this name for the driven joint; give it another one")
    for observed in mechanism.observed:
        if observed.name in bodies:
            raise InvalidInput(f"observed.{observed.name}: a body has this name; give the point another one")


def _observed(fields: Fields, places: Places) -> tuple[ObservedPoint, ...]:
    table = fields.table("observed")
    found = []
    for name in table.names():
        if name == "output" and name not in fields and table.raw(name) in table.names():
            raise InvalidInput(f"{table.at(name)}: as a field of the file it stands before the first [table]")
        place = places.field(table, name)
        if place.body == GROUND:
            raise InvalidInput(f"{table.at(name)}: a point of the ground does not move")
        found.append(ObservedPoint(name, place.body, place.point))
    if not found:
        raise InvalidInput('there are no observed points: give [observed] with lines like C = "slider.C"')
    return tuple(found)


def _output(fields: Fields, mechanism: Mechanism) -> str:
    names = [observed.name for observed in mechanism.observed]
    if len(names) == 1 and "output" not in fields:
        return names[0]
    if "output" not in fields:
        raise InvalidInput(
            f"there is no 'output', which is needed with several observed points: one of {', '.join(sorted(names))}; "
            "it stands before the first [table]"
        )
    return fields.choice("output", names)


# Errors are measured over the travel of a point: over less than this part of the size, rounding alone is 1e-10.
LEAST_TRAVEL = 1e-6


def check_reach(kinematics: Kinematics) -> None:
    """Refuse an input that does not reach all crank angles of its turn, or of its pass.

    Raises:
        InvalidInput: says how far it reaches.
    """
    span = kinematics.mechanism.driver.span
    if kinematics.turns_fully or (span is not None and _passes(kinematics, span)):
        return
    turn = 2.0 * math.pi
    low, high = (math.degrees(kinematics.reach(goal)) for goal in (-turn, turn))
    wanted = "turn fully"
    if span is not None:
        wanted = f"pass from {math.degrees(span[0]):.6g} to {math.degrees(span[1]):.6g} deg"
    raise InvalidInput(
        f"driver: the crank cannot {wanted}: from its start it reaches {low:.2f} to {high:.2f} deg on this assembly; "
        "give driver.from and driver.to within that, for one pass"
    )


def _passes(kinematics: Kinematics, span: tuple[float, float]) -> bool:
    try:
        kinematics.poses(np.array(span))
    except InvalidInput:
        return False
    return True


def check_travel(kinematics: Kinematics) -> None:
    """Refuse an observed point that stands still.

    Raises:
        InvalidInput: names it.
    """
    for name, travel in kinematics.lengths.items():
        if travel < LEAST_TRAVEL * kinematics.size:
            raise InvalidInput(
                f"observed.{name}: the point moves {travel:.3g} m in all, too little to normalise errors by: observe "
                f"points that move by a millionth of the machine's size, {kinematics.size:.3g} m, at least"
            )
