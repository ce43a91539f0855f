"""Python modules for people to reuse: a machine in a `pymunk.Space`, with its drive, complete to run alone.

What a module says of bodies and constraints is read from the space that the translator builds, so that both have the
same numbers to the last bit.
"""

from __future__ import annotations

import math
import re
from functools import cache
from typing import TYPE_CHECKING, Any

import numpy as np
from jinja2 import Environment, PackageLoader, StrictUndefined

from conrod.engines.engine import DeferredLibrary, DescribedMachine, default_steps, run_extent
from conrod.engines.pymunk import PymunkSettings
from conrod.engines.pymunk.dynamics import build_at_angle
from conrod.engines.pymunk.python_text import (
    call,
    conditional_expression,
    docstring,
    number,
    numbers,
    one_line,
    string_literal,
    wrapped_conditional,
)
from conrod.engines.pymunk.space import PymunkSpace, build_free, refusal, rounded_polygon, wedges
from conrod.engines.pymunk.standalone_header import driven_header, free_header
from conrod.engines.pymunk.standalone_loads import load_calls
from conrod.errors import InvalidInput
from conrod.exact.motion import Array
from conrod.mechanism.mechanism import Point

if TYPE_CHECKING:
    import pymunk
else:
    pymunk = DeferredLibrary("pymunk")

EDITED_REASON = "a module has links and joints as the machine has them, and no edits"
ENTRY = 8  # indent of an entry in the module's dictionaries [characters]


def standalone_module(name: str, machine: DescribedMachine, settings: PymunkSettings | None = None) -> str:
    """Python module of a scene that is driven at constant speed; with usual steps and the preset `tuned` by default.

    Raises:
        InvalidInput: pymunk cannot have the machine; says why.
    """
    if settings is None:
        settings = PymunkSettings.tuned(machine, default_steps(machine))
    if reason := refusal(machine, settings) or (EDITED_REASON if settings.dressing else None):
        raise InvalidInput(f"{name}: {reason}")
    mechanism = machine.kinematics.mechanism
    start_angle, revolutions = run_extent(machine, settings.steps_per_revolution, 2.0)
    poses, derivative = machine.kinematics.derivatives(np.array([start_angle]), 1)
    driven = build_at_angle(machine, settings, start_angle)
    undriven = build_free(mechanism, settings, poses[0])
    undriven.set_states(poses[0], derivative[0] * machine.speed)
    makes_a_pass = mechanism.driver.span is not None
    return _render(
        driven,
        undriven,
        settings,
        header=driven_header(name, machine, settings),
        machine=machine,
        start_angle=start_angle,
        makes_a_pass=makes_a_pass,
        run_steps=round(settings.steps_per_revolution * revolutions),
        run_words="one pass" if makes_a_pass else "two turns",
        slop_follows_speed=bool(mechanism.cam_contacts) and settings.collision_bias == 0.0,
        build_arguments="space=None, *, speed=SPEED, drive=True",
        motor=False,
    )


def standalone_free_module(
    name: str, machine: DescribedMachine, start: tuple[Array, Array], settings: PymunkSettings, motor: bool = False
) -> str:
    """Python module of a scene without a drive, whose crank is moved by weight, loads or a motor.

    Args:
        start: exact poses and rates (3 n,) of all bodies.
        motor: whether the crank has a motor, whose rate is an argument of the module's `build`.

    Raises:
        InvalidInput: pymunk cannot have the machine; says why.
    """
    if reason := refusal(machine, settings) or (EDITED_REASON if settings.dressing else None):
        raise InvalidInput(f"{name}: {reason}")
    mechanism = machine.kinematics.mechanism
    made = build_free(mechanism, settings, start[0])
    made.set_states(*start)
    return _render(
        made,
        made,
        settings,
        header=free_header(name, machine, settings, motor),
        run_steps=round(2.0 * 2.0 * math.pi / abs(machine.speed) / settings.timestep),
        run_words=f"{4.0 * math.pi / abs(machine.speed):.6g} s",
        slop_follows_speed=False,
        build_arguments="space=None, *, rate=MOTOR_RATE, max_force=math.inf" if motor else "space=None",
        motor=motor,
        motor_rate=mechanism.driver.sense * machine.speed,
        # A machine may have a joint of this name.
        motor_name="motor" if "motor" not in made.names.values() else f"motor of {mechanism.crank}",
    )


def _render(driven: PymunkSpace, undriven: PymunkSpace, settings: PymunkSettings, **names: Any) -> str:
    """Text of a module, from the machine's spaces with and without the drive; one space twice for a free machine."""
    mechanism = undriven.mechanism
    loads = load_calls(
        mechanism.loads, lambda body, point: _place(driven, undriven, body, point, condition="model.drive")
    )
    values = names | {
        "mechanism": mechanism,
        "settings": settings,
        "driven": driven is not undriven,
        "gravity": undriven.space.gravity,
        "pushes": mechanism.constant_forces,
        "contacts": _contacts(undriven, settings),
        "bodies": _bodies(driven, undriven),
        "constraints": _constraints(driven, undriven),
        "shaft": _shaft(driven, undriven),
        "points": _points(driven, undriven),
        "half_step": not mechanism.cam_contacts,
        "loads": loads,
        "used": " ".join(coordinate + force for _, coordinate, force in loads),
    }
    return re.sub(r"\n{4,}", "\n\n\n", _environment().get_template("standalone.py.jinja").render(values))


@cache
def _environment() -> Environment:
    """The templates of modules."""
    made = Environment(
        loader=PackageLoader("conrod.engines.pymunk", ""), undefined=StrictUndefined, trim_blocks=True,
        lstrip_blocks=True, keep_trailing_newline=True,
    )  # fmt: skip
    writers = (docstring, number, numbers, one_line, string_literal)
    made.filters.update({write.__name__: write for write in writers})
    return made


# -- what a module says of the machine's space -------------------------------------------------------------------------


def _place(driven: PymunkSpace, undriven: PymunkSpace, body: str, point: Point, condition: str = "drive") -> str:
    """Point [m] of a body in pymunk's body frame, with and without the drive, as Python source."""
    here, there = (numbers(made.to_body_frame(body, point)) for made in (driven, undriven))
    return conditional_expression(here, there, condition)


def _bodies(driven: PymunkSpace, undriven: PymunkSpace) -> list[tuple[str, str, str]]:
    """Name of each body, the call that creates it, and its start."""
    found = []
    for link, one, other in zip(undriven.mechanism.bodies, driven.bodies, undriven.bodies, strict=True):
        before = len(string_literal(link.name)) + 2
        creation = wrapped_conditional(_creation(one), _creation(other), ENTRY, before)
        start = call("", _start(one), ENTRY, before)
        if _start(one) != _start(other):
            start = wrapped_conditional(f"({', '.join(_start(one))})", f"({', '.join(_start(other))})", ENTRY, before)
        found.append((link.name, creation, start))
    return found


def _creation(body: pymunk.Body) -> str:
    """Call that creates a body."""
    if body.body_type == pymunk.Body.KINEMATIC:
        return "pymunk.Body(body_type=pymunk.Body.KINEMATIC)"
    return f"pymunk.Body({number(body.mass)}, {number(body.moment)})"


def _start(body: pymunk.Body) -> list[str]:
    """Position, angle and their rates at the start."""
    return [numbers(body.position), number(body.angle), numbers(body.velocity), number(body.angular_velocity)]


def _constraints(driven: PymunkSpace, undriven: PymunkSpace) -> list[tuple[str, str]]:
    """Name of each constraint that the machine has with and without its drive, and the call that creates it."""
    taken, found = set[str](), []
    held = [one for one, joint in undriven.names.items() if not driven.driven or joint != driven.mechanism.driver.joint]
    for one, other in zip(driven.names, held, strict=True):
        name = driven.names[one]
        while name in taken:  # a slide on a moving link has a groove and a gear
            name += " angle"
        taken.add(name)
        function, *arguments = _constraint_parts(driven, one)
        others = _constraint_parts(undriven, other)[1:]
        chosen = [conditional_expression(here, there) for here, there in zip(arguments, others, strict=True)]
        found.append((name, call(function, chosen, ENTRY, len(string_literal(name)) + 2)))
    return found


def _shaft(driven: PymunkSpace, undriven: PymunkSpace) -> tuple[str, str] | None:
    """Name and creating call of the crank's shaft for a model without the drive; None if it has no drive."""
    if driven is undriven:
        return None
    name = driven.mechanism.driver.joint
    (one,) = (constraint for constraint, joint in undriven.names.items() if joint == name)
    function, *arguments = _constraint_parts(undriven, one)
    return name, call(function, arguments, ENTRY, len(string_literal(name)) + 2)


def _constraint_parts(made: PymunkSpace, constraint: pymunk.Constraint) -> list[str]:
    """Function that creates a constraint, and its arguments."""
    names = {
        body: f"bodies[{string_literal(link.name)}]"
        for link, body in zip(made.mechanism.bodies, made.bodies, strict=True)
    }
    names[made.space.static_body] = "ground"
    ends = [names[constraint.a], names[constraint.b]]
    match constraint:
        case pymunk.PivotJoint():
            places = [numbers(constraint.anchor_a), numbers(constraint.anchor_b)]
        case pymunk.GrooveJoint():
            places = [numbers(p) for p in (constraint.groove_a, constraint.groove_b, constraint.anchor_b)]
        case pymunk.GearJoint():
            places = [number(constraint.phase), number(constraint.ratio)]
        case _:
            raise TypeError(f"{constraint!r}: modules have no word for it")
    return [f"pymunk.{type(constraint).__name__}", *ends, *places]


def _points(driven: PymunkSpace, undriven: PymunkSpace) -> list[tuple[str, str]]:
    """Name of each observed point, and its body and place [m] as a tuple in Python source."""
    found = []
    for one in undriven.mechanism.observed:
        place = [string_literal(one.body), _place(driven, undriven, one.body, one.point)]
        found.append((one.name, call("", place, ENTRY, len(string_literal(one.name)) + 2)))
    return found


def _contacts(made: PymunkSpace, settings: PymunkSettings) -> list[dict[str, Any]]:
    """Shapes of each cam and roller."""
    found = []
    for contact in made.mechanism.cam_contacts:
        outline = rounded_polygon(contact.profile, settings.cam_vertices)
        found.append(
            {
                "cam": contact.a,
                "follower": contact.b,
                "rounding": outline.radius,
                "parts": wedges(outline),
                "roller_radius": contact.roller_radius,
                "roller_centre": made.to_body_frame(contact.b, contact.roller_centre),
            }
        )
    return found
