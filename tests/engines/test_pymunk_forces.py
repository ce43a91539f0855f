"""Drive torque and joint reactions by pymunk's impulses, against those that the exact motion takes."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from catalogue import CAM, PRESS, SAW, SCENES

from conrod.engines import engine_named
from conrod.engines.pymunk import forces as own
from conrod.engines.pymunk.dynamics import started
from conrod.engines.pymunk.settings import PymunkSettings
from conrod.engines.tracks import ForceTracks
from conrod.exact.dynamics.inverse import JointForces, State, joint_forces
from conrod.exact.kinematics import Kinematics
from conrod.mechanism.loads import (
    Displacement,
    Distance,
    Elastic,
    Friction,
    Load,
    SpeedLine,
    StrokePulse,
    TimePulse,
    Turn,
    Viscous,
)
from conrod.mechanism.mechanism import Mechanism
from conrod.scenes.catalogue import scene_named

PYMUNK: Any = engine_named("pymunk")
START = 0.3
STEPS = (125, 250, 500, 1000)
MACHINES = {"press": PRESS, "saw": SAW, "saw-500rpm": SCENES["saw-500rpm"], "six-bar": scene_named("six-bar")}


def machine_of(mechanism: Mechanism, speed: float) -> Any:
    return SimpleNamespace(kinematics=Kinematics(mechanism), speed=speed)


def measured(machine: Any, steps: int, **settings: Any) -> ForceTracks:
    told: ForceTracks = PYMUNK.forces(machine, replace(PymunkSettings.tuned(machine, steps), **settings), 1.0, START)
    assert not told.unsupported
    return told


def exact(machine: Any, told: ForceTracks) -> JointForces:
    at = told.instants
    return joint_forces(machine.kinematics, State(at.angle, at.rate, at.acceleration, at.times))


def errors(machine: Any, told: ForceTracks) -> dict[str, float]:
    """Of the torque and every component, against the exact peak: that of the whole vector where it is a pin's."""
    right = exact(machine, told)
    assert told.drive_torque is not None
    found = {"torque": against_peak(told.drive_torque, right.drive_torque, right.drive_torque)}
    for joint, components in told.joints.items():
        size = np.sqrt(sum(v**2 for name, v in right.components[joint].items() if name != "moment"))
        for name, values in components.items():
            told_size = right.components[joint][name] if name == "moment" else size
            found[f"{joint}.{name}"] = against_peak(values, right.components[joint][name], told_size)
    return found


def against_peak(values: Any, right: Any, size: Any) -> float:
    peak = float(np.abs(size).max())
    gap = float(np.abs(values - right).max())
    # A moment that is nothing but rounding in the exact motion has no peak.
    return gap / peak if peak > 1e-9 else gap


def test_values_given_to_another_instant_are_of_order_one() -> None:
    found = []
    for steps in (250, 500):
        told = measured(SAW, steps)
        late = replace(told.instants, angle=told.instants.angle + SAW.speed * 0.5 * SAW.period / steps)
        found.append(errors(SAW, replace(told, instants=late))["torque"])
    assert np.log2(found[0] / found[1]) == pytest.approx(1.0, abs=0.1)


def test_a_joints_components_have_the_size_of_the_impulse_that_the_engine_tells() -> None:
    machine, settings = MACHINES["six-bar"], PymunkSettings.tuned(MACHINES["six-bar"], 400)
    told = PYMUNK.forces(machine, settings, 0.1, START)
    made, h = started(machine, settings, START), settings.timestep
    for n in range(40):
        made.crank.angle = made.mechanism.crank_turn(START + machine.speed * h * n)
        made.space.step(h)
        if n + 1 < own.FIRST:
            continue
        for constraint, name in made.names.items():
            pushes = [values[n + 1 - own.FIRST] for part, values in told.joints[name].items() if part != "moment"]
            assert np.hypot.reduce([*pushes, 0.0]) == pytest.approx(constraint.impulse / h, rel=1e-9)


def press_under_load(crank_centre: tuple[float, float] = (0.0, 0.0)) -> Any:
    """With a cutting force, a spring with damper, friction in the slide, a pulse in time and a motor."""
    mechanism = PRESS.kinematics.mechanism
    slider, crank = mechanism.joints[-1].b, mechanism.crank
    rod = next(body.name for body in mechanism.bodies if body.name not in (slider, crank))
    poses = PRESS.kinematics.poses(np.linspace(0.0, 2.0 * np.pi, 100))
    column = 3 * mechanism.body_index[slider]
    way = 0 if np.ptp(poses[:, column]) > np.ptp(poses[:, column + 1]) else 1
    low, high = float(poses[:, column + way].min()), float(poses[:, column + way].max())
    along = Displacement(slider, (0.0, 0.0), 0.5 * np.pi * way)
    brace = Distance("ground", rod, (0.3, 0.4), (0.02, 0.01))
    weight = 9.81 * sum(body.mass for body in mechanism.bodies)
    loads = (
        Load("cut", along, StrokePulse(weight, low + 0.2 * (high - low), low + 0.7 * (high - low), 1)),
        Load("friction", along, Friction(0.3 * weight, 0.5)),
        Load("spring", brace, Elastic(2.0 * weight, 0.2)),
        Load("damper", brace, Viscous(0.2 * weight)),
        Load("push", Turn("ground", rod), TimePulse(0.1 * weight, 0.1 * PRESS.period, 0.9 * PRESS.period)),
        Load("motor", Turn("ground", crank), SpeedLine(0.2 * weight, 30.0)),
    )
    bodies = tuple(replace(b, centre_of_gravity=crank_centre) if b.name == crank else b for b in mechanism.bodies)
    return machine_of(replace(mechanism, bodies=bodies, loads=loads), PRESS.speed)


def test_loads_are_carried_at_their_instants() -> None:
    machine = press_under_load(crank_centre=(0.03, -0.02))
    found = [errors(machine, measured(machine, steps)) for steps in (250, 500, 1000)]
    for quantity in found[0]:
        series = [each[quantity] for each in found]
        assert series[-1] < 3e-4, quantity
        assert series[0] < 1e-12 or np.log2(series[0] / series[1]) > 1.8, quantity
    without = machine_of(replace(machine.kinematics.mechanism, loads=()), PRESS.speed)
    assert errors(machine, measured(without, 250))["torque"] > 0.1


def away_from_joints(angle: Any) -> Any:
    gaps = (angle[:, None] - np.array(CAM.break_angles())[None] + np.pi) % (2.0 * np.pi) - np.pi
    return np.abs(gaps).min(axis=1) > 0.02


def contact_scatter(steps: int) -> float:
    """Rms error of the contact force between the arcs' joints, against its peak."""
    settings = PymunkSettings.tuned(CAM, steps)
    told = PYMUNK.forces(CAM, settings, 1.0, START)
    right = exact(CAM, told).components["contact"]["contact"]
    gap = (told.joints["contact"]["contact"] - right)[away_from_joints(told.instants.angle)]
    return float(np.sqrt(np.mean(gap**2)) / right.max())


def test_the_contact_force_of_sixteen_steps_is_within_two_per_cent_rms() -> None:
    assert contact_scatter(7854) < 0.01


def test_the_contact_force_of_single_steps_scatters_and_no_smaller_step_helps(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(own, "TOGETHER", 1)
    assert [contact_scatter(steps) for steps in (3927, 15708)] == pytest.approx([0.055, 0.055], abs=0.01)


@pytest.mark.parametrize(
    ("scene", "change", "reason"),
    [
        (scene_named("rack-and-wheel"), {}, "pymunk has no joint that ties the way along a line to a turn"),
        (SAW, {"iterations": 1, "error_bias": 1.0}, "the run ended as"),
    ],
)
def test_what_is_not_told_has_its_reason(scene: Any, change: dict[str, Any], reason: str) -> None:
    told = PYMUNK.forces(scene, replace(PymunkSettings.tuned(scene, 60), **change), 1.0)
    assert told.drive_torque is None
    assert not told.joints
    assert reason in told.unsupported["drive torque"]
    assert set(told.unsupported) == {"drive torque", *(joint.name for joint in scene.kinematics.mechanism.joints)}
