"""The page of a pack: what to solve, what to hand in, the one figure that counts, and the errors worth meeting."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from dataclasses import asdict, dataclass

from conrod.engines.capabilities import expected_error
from conrod.engines.engine import default_steps
from conrod.engines.registry import loadable_engines
from conrod.mechanism.mechanism import CamContact, Joint, Mechanism, Prismatic, Rack, Revolute, Rolling
from conrod.report import numbers
from conrod.report.numbers import ROUNDING
from conrod.report.scene_words import described, parameters_table
from conrod.report.table import Table, table
from conrod.report.template import rendered
from conrod.scenes import SCENES, Scene
from conrod.scenes.described_scene import DescribedScene
from conrod.studies.limits.records import SAFE_ERROR


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
    for engine in loadable_engines()[0]:
        for preset, rule in engine.presets.items():
            settings = rule(scene, steps)
            law = None if engine.refusal(scene, settings) else expected_error(engine, scene, settings)
            if law is not None and law.position is not None:
                meaning = f"as good as {engine.name}, preset {preset}, at {steps} steps a revolution"
                found.append(Tolerance(law.position, law.velocity, law.acceleration, meaning, law.law))
    found.append(Tolerance(ROUNDING, None, None, "rounding: a solver of the kinematics", "double precision"))
    return sorted(found, key=lambda one: -one.position)


def readme(
    name: str, scene: Scene, tolerances: Sequence[Tolerance], samples: int, revolutions: int, columns: Sequence[str]
) -> str:
    """The page.

    Args:
        name: of the scene.
        samples, revolutions: of the trajectory.
        columns: names of its columns.
    """
    mechanism = scene.mechanism()
    worth = [(_size(t.position), _size(t.velocity), _size(t.acceleration), t.meaning) for t in tolerances]
    return rendered(
        "pack", name=name, scene=scene, mechanism=mechanism, description=described(scene), samples=samples,
        revolutions=revolutions, columns=columns, drive=_drive(scene), one_pass=mechanism.driver.span is not None,
        sense="counter-clockwise" if mechanism.driver.sense * scene.speed > 0 else "clockwise",
        lengths=table(("point", "L [mm]"), [(p, _mm(length)) for p, length in scene.lengths.items()]),
        command=_command(name, scene), worth=table(("position", "velocity", "acceleration", "who does"), worth),
        parameters=parameters_table(scene), bodies=_bodies_table(mechanism),
        joints=table(
            ("joint", "kind", "a", "b", "geometry [m, rad]"),
            [(j.name, joint_kind(j), j.a, j.b, _geometry(j)) for j in mechanism.joints],
        ),
        observed=[f"{point.name} is {_place(point.point)} of {point.body}" for point in mechanism.observed],
    )  # fmt: skip


def _drive(scene: Scene) -> str:
    """From which crank angle to which, and when."""
    span = scene.kinematics.mechanism.driver.span
    if span is None:
        turn = f"{scene.period:.15g} s each"
        return f"from crank angle 0 at time 0, in motion from the start, over two revolutions of {turn}"
    first, last = span if scene.speed > 0.0 else span[::-1]
    return (
        f"in motion from the start, in one pass from crank angle {first!r} rad at time {first / scene.speed:.15g} s to "
        f"{last!r} rad at {last / scene.speed:.15g} s, with crank angle 0, and the start poses, at time 0: the input "
        "cannot turn fully"
    )


def _command(name: str, scene: Scene) -> str:
    """The command that judges a table, with what makes the scene of the one that ships, or that the file describes."""
    usual = scene.as_described.parameters if isinstance(scene, DescribedScene) else SCENES[name].parameters
    changed = [f"--set {shlex.quote(f'{p}={value!r}')}" for p, value in scene.parameters.items() if value != usual[p]]
    machine = name if scene.closed_form else "machine.toml"
    return " ".join(["conrod validate YOUR.csv --scene", machine, *changed])


def _size(size: float | None) -> str:
    return "-" if size is None else f"{size:.1e}"


def _bodies_table(mechanism: Mechanism) -> Table:
    rows = []
    for body in mechanism.bodies:
        x, y, turn = mechanism.poses[body.name]
        pose = f"({_mm(x)}, {_mm(y)}) mm, {numbers.quantity(turn, 6)} rad"
        rows.append((body.name, f"{body.mass:g}", f"{body.inertia:g}", _place(body.centre_of_gravity), pose))
    return table(("body", "mass [kg]", "inertia [kg m²]", "centre of gravity [mm]", "start pose, approximate"), rows)


def joint_kind(joint: Joint) -> str:
    """What `mechanism.json` and the page call a joint."""
    kinds = {Revolute: "revolute", Prismatic: "prismatic", CamContact: "cam contact", Rolling: "rolling", Rack: "rack"}
    return kinds[type(joint)]


def _geometry(joint: Joint) -> str:
    """Numbers of a joint [m, rad], but for a cam's profile."""
    given = {key: value for key, value in asdict(joint).items() if key not in ("name", "a", "b", "profile")}
    shown = {k: "({:.9g}, {:.9g})".format(*v) if isinstance(v, tuple) else f"{v:.9g}" for k, v in given.items()}
    return ", ".join(f"`{key}` {value}" for key, value in shown.items())


def _place(point: tuple[float, float]) -> str:
    return f"({_mm(point[0])}, {_mm(point[1])})"


def _mm(value: float) -> str:
    return numbers.quantity(1e3 * value, 9)
