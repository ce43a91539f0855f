"""Drive torque and joint reactions by an engine's own account, against those that the exact motion takes."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import mujoco
import numpy as np
import pytest
from catalogue import CAM

from conrod.engines import engine_named
from conrod.engines.pymunk import forces as own
from conrod.engines.pymunk.dynamics import build_at_angle
from conrod.engines.tracks import ForceTracks
from conrod.exact.dynamics.inverse import JointForces, joint_forces
from conrod.exact.kinematics import GenericReference
from conrod.mechanism.loads import (
    Displacement,
    Distance,
    Elastic,
    Friction,
    Load,
    SpeedLine,
    Steady,
    StrokePulse,
    TimePulse,
    Turn,
    Viscous,
)
from conrod.mechanism.mechanism import Prismatic
from conrod.scenes import scene_named

START = 0.3
LOADS = (
    Load("spring", Distance("ground", "rod", (0.1, -0.5), (0.05, 0.0)), Elastic(3e3, 0.2)),
    Load("damper", Distance("crank", "slider", (0.05, 0.0), (0.1, 0.1)), Viscous(80.0)),
    Load("turn-spring", Turn("crank", "rod"), Elastic(40.0, 0.3)),
    Load("turn-damper", Turn("rod", "slider"), Viscous(2.0)),
    Load("torque-on-slider", Turn("ground", "slider"), Steady(5.0)),
    Load("push", Displacement("rod", (0.1, 0.0), 0.7), Steady(90.0)),
    Load("spring-to-line", Displacement("slider", (0.1, 0.0), 0.1), Elastic(900.0, 0.1)),
    Load("motor", Turn("ground", "crank"), SpeedLine(20.0, 60.0)),
    Load("friction", Displacement("slider", (0.0, 0.0), 0.0), Friction(100.0, 0.05)),
    Load("cut", Displacement("slider", (0.0, 0.0), 0.0), StrokePulse(500.0, -0.18, -0.02, 1)),
    Load("knock", Turn("ground", "rod"), TimePulse(30.0, 0.01, 0.05)),
)


def machine(name: str, **changes: Any) -> GenericReference:
    scene = scene_named(name)
    return GenericReference(replace(scene.mechanism(), **changes), scene.speed)


def reported_forces(engine: str, model: Any, steps: int, turns: float = 1.0, **settings: Any) -> ForceTracks:
    made: Any = engine_named(engine)
    preset = made.presets["hardened" if engine == "mujoco" and not model.kinematics.mechanism.cam_contacts else "tuned"]
    found: ForceTracks = made.forces(model, replace(preset(model, steps), **settings), turns, START)
    return found


def exact_forces(model: Any, tracks: ForceTracks) -> JointForces:
    at = tracks.instants
    return joint_forces(model.kinematics, at)


def errors(tracks: ForceTracks, judge: GenericReference) -> tuple[float, float]:
    """Largest errors of drive torque and reactions, over the exact peak of each quantity."""
    assert not tracks.unsupported
    assert tracks.drive_torque is not None
    right_forces = exact_forces(judge, tracks)
    torque = np.abs(tracks.drive_torque - right_forces.drive_torque).max() / np.abs(right_forces.drive_torque).max()
    worst = 0.0
    for joint in judge.described.joints:
        own_part, right = tracks.joints[joint.name], right_forces.components[joint.name]
        assert list(own_part) == list(right)
        # Both components of a pin are judged by its largest force; a slide's moment may be 0 throughout.
        size = {name: np.abs(values).max() for name, values in right.items()}
        scale = {name: size[name] if isinstance(joint, Prismatic) else max(size.values()) for name in size}
        scale |= {"moment": max(size.get("moment", 0.0), size.get("normal", 0.0) * judge.kinematics.size)}
        worst = max(worst, *(float(np.abs(own_part[name] - right[name]).max() / scale[name]) for name in own_part))
    return float(torque), worst


# -- MuJoCo ------------------------------------------------------------------------------------------------------------


def test_forces_lose_digits_with_the_flywheel_of_a_run(monkeypatch: pytest.MonkeyPatch) -> None:
    """Why forces have settings of their own: the solver stops at corrections shorter than 1e-15."""
    saw = machine("saw-40rpm")
    monkeypatch.setattr("conrod.engines.mujoco.forces.FORCE_ARMATURE_FACTOR", 1.0)
    monkeypatch.setattr("conrod.engines.mujoco.forces.MIN_FORCE_HARDENING", 1e-15)
    # Solved a second time from beside the solution, a state has them again.
    assert errors(reported_forces("mujoco", saw, 1000), saw)[0] < 1e-7
    monkeypatch.setattr("conrod.engines.mujoco.forces.MIN_SOLVER_ITERATIONS", 0)
    assert errors(reported_forces("mujoco", saw, 1000), saw)[0] > 1e-4


def test_flywheel_inertia_includes_the_work_of_loads() -> None:
    """A torque of 50 kN m on the press: it gives as much in a turn as it takes from the drive."""
    press = machine("shear-press", loads=(Load("cut", Turn("ground", "crank"), Steady(5e4)),))
    tracks = reported_forces("mujoco", press, 250)
    assert np.abs(tracks.instants.rate / press.speed - 1.0).max() < 1e-5
    assert errors(tracks, press)[0] < 1e-7


@pytest.mark.parametrize("load", [LOADS[:1], LOADS[-1:], LOADS], ids=["spring", "knock", "all"])
def test_loads_appear_in_torque_and_reactions(load: tuple[Load, ...]) -> None:
    saw = machine("saw-500rpm", loads=load)
    tracks = reported_forces("mujoco", saw, 500)
    assert max(errors(tracks, saw)) < 1e-6
    assert max(errors(tracks, machine("saw-500rpm"))) > 1e-3  # which has no loads
    assert mujoco.get_mjcb_act_bias() is None


# -- pymunk ------------------------------------------------------------------------------------------------------------


def test_loads_are_exact_for_a_crank_with_its_centre_off_shaft() -> None:
    mechanism = scene_named("saw-500rpm").mechanism()
    crank = replace(mechanism.body("crank"), centre_of_gravity=(0.03, -0.02))
    bodies = (crank, *(body for body in mechanism.bodies if body.name != "crank"))
    loaded, without = (machine("saw-500rpm", bodies=bodies, loads=loads) for loads in (LOADS, ()))
    found = np.array([errors(reported_forces("pymunk", loaded, steps), loaded) for steps in (250, 500, 1000)])
    assert found[-1].max() < 1e-4
    assert np.log2(found[0] / found[1]).min() > 1.8
    assert errors(reported_forces("pymunk", without, 250), loaded)[0] > 0.1


def test_forces_stamped_with_another_instant_have_order_one() -> None:
    found, saw = [], machine("saw-40rpm")
    for steps in (250, 500):
        tracks = reported_forces("pymunk", saw, steps)
        late = replace(tracks.instants, angle=tracks.instants.angle + np.pi / steps)
        found.append(errors(replace(tracks, instants=late), saw)[0])
    assert np.log2(found[0] / found[1]) == pytest.approx(1.0, abs=0.1)


def test_joint_components_agree_with_the_engines_impulse() -> None:
    model: Any = machine("six-bar")
    settings = engine_named("pymunk").presets["tuned"](model, 400)
    tracks = reported_forces("pymunk", model, 400, 0.1)
    made, h = build_at_angle(model, settings, START), settings.timestep
    for n in range(40):
        made.crank.angle = made.mechanism.crank_turn(START + model.speed * h * n)
        made.space.step(h)
        if n + 1 < own.FIRST_SAMPLE:
            continue
        for constraint, name in made.names.items():
            pushes = [
                values[n + 1 - own.FIRST_SAMPLE] for part, values in tracks.joints[name].items() if part != "moment"
            ]
            assert np.hypot.reduce([*pushes, 0.0]) == pytest.approx(constraint.impulse / h, rel=1e-9)


# -- contact -----------------------------------------------------------------------------------------------------------


def contact_scatter(engine: str, steps: int, turns: float) -> float:
    """Rms error of the contact force between the arcs' joints, against its peak."""
    tracks = reported_forces(engine, CAM, steps, turns)
    angle, right = tracks.instants.angle, exact_forces(CAM, tracks).components["contact"]["contact"]
    assert right.min() > 0.0
    gaps = (angle[:, None] - np.array(CAM.break_angles())[None] + np.pi) % (2.0 * np.pi) - np.pi
    away = np.abs(gaps).min(axis=1) > 0.02
    away[:50] &= engine == "pymunk"  # a contact of MuJoCo's that starts without overlap gives nothing yet
    gap = (tracks.joints["contact"]["contact"] - right)[away]
    return float(np.sqrt(np.mean(gap**2)) / right.max())


@pytest.mark.parametrize(("engine", "steps", "turns"), [("mujoco", 6283, 0.25), ("pymunk", 7854, 1.0)])
def test_contact_force_is_within_two_percent_between_arc_joints(engine: str, steps: int, turns: float) -> None:
    assert contact_scatter(engine, steps, turns) < (0.02 if engine == "mujoco" else 0.01)


def test_contact_force_of_single_steps_scatters_at_any_step(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(own, "SAMPLES_PER_MEAN", 1)
    found = [contact_scatter("pymunk", steps, 1.0) for steps in (3927, 15708)]
    assert found == pytest.approx([0.055, 0.055], abs=0.01)


@pytest.mark.parametrize(
    ("engine", "name", "change", "reason"),
    [
        ("mujoco", "planetary-gear", {}, "MuJoCo couples the joint coordinates of what rolls"),
        ("pymunk", "rack-and-wheel", {}, "pymunk has no joint that ties the way along a line to a turn"),
        ("pymunk", "saw-40rpm", {"iterations": 1, "error_bias": 1.0}, "the run ended as"),
    ],
)
def test_unreported_forces_have_a_reason(engine: str, name: str, change: dict[str, Any], reason: str) -> None:
    model = machine(name)
    tracks = reported_forces(engine, model, 60, **change)
    assert tracks.drive_torque is None
    assert not tracks.joints
    assert reason in tracks.unsupported["drive torque"]
    assert set(tracks.unsupported) == {"drive torque", *(joint.name for joint in model.described.joints)}
