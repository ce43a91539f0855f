"""What a pack's mechanism is driven through: turns, or the one pass of an input that cannot turn fully.

Errors worth meeting: usable, what engines reach by their own laws, and rounding.

The page of a pack: what to solve, what to hand in, and the one figure that counts.
"""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from dataclasses import dataclass
from typing import assert_never

from conrod.engines import engine_named, engine_names
from conrod.engines.capabilities import expected_error
from conrod.engines.engine import default_steps
from conrod.mechanism.cam_law import LawProfile
from conrod.mechanism.mechanism import CamContact, Mechanism, Prismatic, Revolute
from conrod.mechanism.rolling import Rack, Rolling
from conrod.report import numbers
from conrod.report.numbers import ROUNDING
from conrod.report.tables import paragraphs, table
from conrod.scenes import SCENES, Scene
from conrod.scenes.described_scene import DescribedScene
from conrod.studies.limits.grade import SAFE_ERROR


def course(scene: Scene) -> str:
    """What is to be solved."""
    return "two revolutions" if _span(scene) is None else "the pass"


def whole_course(scene: Scene) -> str:
    """The same where it has been spoken of before."""
    return "the two revolutions" if _span(scene) is None else "the pass"


def drive(scene: Scene) -> str:
    """From which crank angle to which, and when."""
    span = _span(scene)
    if span is None:
        turn = f"{scene.period:.15g} s each"
        return f"from crank angle 0 at time 0, in motion from the start, over two revolutions of {turn}"
    first, last = span if scene.speed > 0.0 else span[::-1]
    return (
        f"in motion from the start, in one pass from crank angle {first!r} rad at time {first / scene.speed:.15g} s to "
        f"{last!r} rad at {last / scene.speed:.15g} s, with crank angle 0, and the start poses, at time 0: the input "
        "cannot turn fully"
    )


def covered(scene: Scene, revolutions: int) -> str:
    """What the trajectory goes over."""
    return f"{revolutions}, from crank angle 0" if _span(scene) is None else "the pass, from its start"


def unknowns(scene: Scene) -> str:
    """What need not be known of a solution."""
    if _span(scene) is not None:
        return "An unknown frame can be worked out first: `--estimate frame`."
    return (
        "Unknown start times, crank angles, senses and frames can be worked out first: "
        "`--estimate time,phase,sense,frame`."
    )


def _span(scene: Scene) -> tuple[float, float] | None:
    return scene.kinematics.mechanism.driver.span


@dataclass(frozen=True)
class Tolerance:
    """Errors worth meeting, normalised; None where the max norm says nothing.

    Attributes:
        meaning: who meets them, or what they are good for.
        law: where they come from.
    """

    position: float
    velocity: float | None
    acceleration: float | None
    meaning: str
    law: str


def worth_meeting(scene: Scene) -> list[Tolerance]:
    """Tolerances, the loosest first: what is usable, what engines reach by their own laws, and rounding."""
    found = [Tolerance(SAFE_ERROR, None, None, "usable: what conrod calls safe", "by definition")]
    steps = default_steps(scene)
    for engine in map(engine_named, engine_names()):
        for preset, rule in engine.presets.items():
            settings = rule(scene, steps)
            law = None if engine.refusal(scene, settings) else expected_error(engine, scene, settings)
            if law is not None and law.position is not None:
                meaning = f"as good as {engine.name}, preset {preset}, at {steps} steps a revolution"
                found.append(Tolerance(law.position, law.velocity, law.acceleration, meaning, law.law))
    found.append(Tolerance(ROUNDING, None, None, "rounding: a solver of the kinematics", "double precision"))
    return sorted(found, key=lambda one: -one.position)


FILES = (
    ("`parameters.json`", "all parameters with their units, SI, in full precision"),
    ("`mechanism.json`", "bodies with masses, joints, drive, start poses, observed points, gravity and forces"),
    ("`trajectory.csv`, `trajectory.npz`", "the exact motion of the observed points, to jerk"),
    ("`tolerances.json`", "errors worth meeting, and where they come from"),
    ("`figures/mechanism.svg`", "a drawing with dimensions"),
)
FILE = ("`machine.toml`", "the mechanism as conrod reads it, but for parameters that were given anew")


def readme(
    name: str,
    scene: Scene,
    tolerances: Sequence[Tolerance],
    samples: int,
    revolutions: int,
    columns: Sequence[str],
) -> str:
    """The page.

    Args:
        name: of the scene.
        samples, revolutions: of the trajectory.
        columns: names of its columns.
    """
    mechanism = scene.mechanism()
    return (
        paragraphs(
            f"# {name}: {scene.title}",
            "![The mechanism with its dimensions](figures/mechanism.svg)",
            "A mechanism whose motion is known exactly, to try a simulation tool on. " + _in_words(scene),
            f"Source: {scene.source}. Frame: {scene.frame}",
            "## What to solve",
            _task(scene, mechanism),
            "## What to hand in",
            _hand_in(scene),
            "## The figure that counts",
            f"The **largest position error over L, over {course(scene)}**: of all observed points and all rows the "
            "largest distance from the exact position at that time, divided by the L of the point.",
            table(("point", "L [mm]"), [(p, numbers.quantity(1e3 * x, 9)) for p, x in scene.lengths.items()]),
            _how(name, scene),
            "## Errors worth meeting",
            table(("position", "velocity", "acceleration", "who does"), [_worth(t) for t in tolerances]),
            "Velocities are divided by ω L, accelerations by ω² L. Bounds of engines are derived from their own laws, "
            "not measured.",
            "## Parameters",
            _parameters(scene),
            "## Bodies",
            _bodies(mechanism),
            "## Joints",
            _joints(mechanism),
            _loads(mechanism),
            "## Files",
            table(("file", "holds"), FILES if scene.closed_form else (FILE, *FILES)),
            f"The trajectory has {samples} instants a revolution over {covered(scene, revolutions)}; its columns "
            f"are {', '.join(f'`{column}`' for column in columns)}. {_breaks(scene)}".strip(),
        )
        + "\n"
    )


def _in_words(scene: Scene) -> str:
    facts = scene.parameter_facts()
    shown = {
        name: " ".join(numbers.in_shown_unit(value, facts[name].unit)).removesuffix(" -")
        for name, value in scene.parameters.items()
    }
    return scene.description.format(**shown)


def _task(scene: Scene, mechanism: Mechanism) -> str:
    sense = "counter-clockwise" if mechanism.driver.sense * scene.speed > 0 else "clockwise"
    return (
        f"Drive the body `{mechanism.crank}` about the joint `{mechanism.driver.joint}` at a constant "
        f"{abs(scene.speed)!r} rad/s {sense}, {drive(scene)}. Assemble the mechanism on the branch of the start poses "
        "below. The exact motion depends on no mass and no gravity; what your tool makes of it may."
    )


def _hand_in(scene: Scene) -> str:
    first = next(iter(scene.lengths))
    return (
        "A table (CSV, Parquet or npz) with the time and the positions of the observed points "
        f"({', '.join(f'`{p}.x`, `{p}.y`' for p in scene.lengths)}), at any times that cover {whole_course(scene)}, "
        f"such as those of `trajectory.csv`; with velocities (`{first}.vx`) and "
        f"accelerations (`{first}.ax`) if you have them, and the crank's own angle (`crank_angle`). Units go into the "
        f"headings: `time [s]`, `{first}.x [mm]`."
    )


def _how(name: str, scene: Scene) -> str:
    machine = name if scene.closed_form else "machine.toml"
    command = " ".join(["conrod validate YOUR.csv --scene", machine, *_assignments(name, scene)])
    return (
        f"`{command}` prints it, says what else is off, and why where it can. {unknowns(scene)} Without conrod the "
        "figure is the largest distance from `trajectory.csv`, row by row at its times, over L."
    )


def _assignments(name: str, scene: Scene) -> list[str]:
    """What makes the scene of the one that ships, or that the file describes."""
    usual = scene.as_described.parameters if isinstance(scene, DescribedScene) else SCENES[name].parameters
    return [f"--set {shlex.quote(f'{p}={value!r}')}" for p, value in scene.parameters.items() if value != usual[p]]


def _worth(tolerance: Tolerance) -> tuple[str, str, str, str]:
    sizes = (tolerance.position, tolerance.velocity, tolerance.acceleration)
    position, velocity, acceleration = ("-" if size is None else f"{size:.1e}" for size in sizes)
    return position, velocity, acceleration, tolerance.meaning


def _parameters(scene: Scene) -> str:
    facts = scene.parameter_facts()
    rows = [
        (f"`{name}`", *numbers.in_shown_unit(value, facts[name].unit), facts[name].meaning)
        for name, value in scene.parameters.items()
    ]
    return table(("parameter", "value", "unit", "meaning"), rows)


def _bodies(mechanism: Mechanism) -> str:
    rows = []
    for body in mechanism.bodies:
        x, y, turn = mechanism.poses[body.name]
        pose = f"({_mm(x)}, {_mm(y)}) mm, {numbers.quantity(turn, 6)} rad"
        rows.append((body.name, f"{body.mass:g}", f"{body.inertia:g}", _place(body.centre_of_gravity), pose))
    head = ("body", "mass [kg]", "inertia [kg m²]", "centre of gravity [mm]", "start pose, approximate")
    return table(head, rows) + (
        "\n\nInertias are about the centres of gravity. A pose is the place of the body's frame and its turn, "
        "counter-clockwise; points are in the frame of their body."
    )


def _joints(mechanism: Mechanism) -> str:
    rows = []
    for joint in mechanism.joints:
        match joint:
            case Revolute():
                what = f"pin: {_place(joint.point_a)} of {joint.a} at {_place(joint.point_b)} of {joint.b}"
            case Prismatic():
                what = (
                    f"slide: {_place(joint.point_b)} of {joint.b} on the line through {_place(joint.point_a)} of "
                    f"{joint.a} at {numbers.quantity(joint.direction, 9)} rad, turned against that by "
                    f"{numbers.quantity(joint.angle, 9)} rad"
                )
            case CamContact():
                what = (
                    f"contact: a roller of radius {_mm(joint.roller_radius)} mm of {joint.b} about "
                    f"{_place(joint.roller_centre)} on the profile of {joint.a}{_profile(joint)}"
                )
            case Rolling():
                what = (
                    f"rolling: a circle of radius {_mm(joint.radius_a)} mm about {_place(joint.point_a)} of {joint.a} "
                    f"on one of {_mm(joint.radius_b)} mm about {_place(joint.point_b)} of {joint.b} (negative: the "
                    f"other is inside); radii x turns against the line of centres sum up to {_mm(joint.offset)} mm"
                )
            case Rack():
                what = (
                    f"rolling: a wheel of radius {_mm(joint.radius)} mm about {_place(joint.point_a)} of {joint.a} on "
                    f"the left of the line through {_place(joint.point_b)} of {joint.b} at "
                    f"{numbers.quantity(joint.direction, 9)} rad; way + radius x turn = {_mm(joint.offset)} mm"
                )
            case _:
                assert_never(joint)
        rows.append((joint.name, joint.a, joint.b, what))
    points = [f"{point.name} is {_place(point.point)} of {point.body}" for point in mechanism.observed]
    return table(("joint", "a", "b", "what [mm]"), rows) + f"\n\nObserved: {'; '.join(points)}."


def _profile(contact: CamContact) -> str:
    if isinstance(contact.profile, LawProfile):
        return (
            ": the envelope of the roller whose centre follows the law in `mechanism.json`, segment by segment against "
            "the cam's turn, on a line fixed beside the shaft"
        )
    return (
        ": arcs in `mechanism.json`, each from `start` to `stop`, directions of its outward normal [rad] in the frame "
        "of that body"
    )


def _loads(mechanism: Mechanism) -> str:
    x, y = mechanism.gravity
    forces = [
        f"a constant force of ({f.force[0]:g}, {f.force[1]:g}) N at the centre of gravity of {f.body}"
        for f in mechanism.forces
    ]
    return f"Gravity: ({x:g}, {y:g}) m/s²." + (f" Forces: {'; '.join(forces)}." if forces else "")


def _breaks(scene: Scene) -> str:
    if not scene.break_angles():
        return ""
    return "Where the acceleration jumps, an instant has the value just behind it."


def _place(point: tuple[float, float]) -> str:
    return f"({_mm(point[0])}, {_mm(point[1])})"


def _mm(value: float) -> str:
    return numbers.quantity(1e3 * value, 9)
