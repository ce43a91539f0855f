"""The named scenes of dynamics: found by name, and each does what its description claims."""

from __future__ import annotations

import math
import tomllib
from functools import cache

import mujoco
import numpy as np
import pytest
from scipy.integrate import simpson
from scipy.optimize import brentq

from conrod import compare, run
from conrod.engines import engine_named
from conrod.engines.mujoco.loads import callback_loads
from conrod.engines.mujoco.standalone import standalone_mjcf
from conrod.exact.dynamics.forward import ForwardDynamics, FreeMotion
from conrod.exact.dynamics.inverse import joint_forces
from conrod.exact.motion import Array, Instants
from conrod.scenes import (
    MAX_CHAIN_LENGTH,
    CamFollower,
    Saw,
    catalogue_scene,
    catalogue_text,
    dynamics_names,
)
from conrod.scenes.described_scene import DescribedScene, scene_from_tables

NAMES = dynamics_names()
QUICK = tuple(name for name in NAMES if name != f"four-bar-chain-{MAX_CHAIN_LENGTH}")  # which is that of 2, and slow
# Times [s] that show what a scene is about, and samples; else 2 s by 301.
SHOWN = {
    **dict.fromkeys(("press-cutting", "press-cutting-flywheel"), (0.9, 601)),
    **dict.fromkeys(("cam-spring-slow", "cam-spring-fast"), (0.1, 301)),
    "saw-coasting": (1.2, 601), "slider-crank-spring": (3.0, 601), "pendulum": (3.0, 301), "four-bar-swing": (1.5, 301),
    "four-bar-chain-10": (0.5, 301),
}  # fmt: skip


@cache
def free(name: str) -> FreeMotion:
    """The motion that the scene's file begins."""
    scene = catalogue_scene(name)
    times = np.linspace(0.0, *SHOWN.get(name, (2.0, 301)))
    return ForwardDynamics(scene.mechanism()).motion(times, rates=scene.start_rates)


# -- what they claim -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", QUICK)
def test_the_balance_of_energy_closes(name: str) -> None:
    assert free(name).drift < 1e-11


def test_the_saw_loses_friction_times_its_way_until_it_rests() -> None:
    motion, stroke = free("saw-coasting"), Saw().lengths["C"]
    mechanism = catalogue_scene("saw-coasting").mechanism()
    slider, turn = 3 * mechanism.body_index["slider"], 3 * mechanism.body_index[mechanism.crank] + 2
    angle = mechanism.driver.sense * (motion.poses[:, turn] - mechanism.driver.start)
    assert abs(motion.rates[-1, turn]) < 1e-3 * abs(motion.rates[0, turn])
    speed = motion.rates[:, slider]
    friction = simpson(-30.0 * np.tanh(speed / 0.02) * speed, x=motion.times)
    assert motion.energy[-1] - motion.energy[0] == pytest.approx(friction, rel=1e-4)
    # Two strokes a turn; where the slider turns round friction is not up for a moment.
    turns = int(angle[-1] / (2.0 * math.pi))
    lost = motion.energy[0] - np.interp(2.0 * math.pi * turns, angle[: angle.argmax()], motion.energy[: angle.argmax()])
    assert turns >= 3
    assert lost == pytest.approx(30.0 * 2.0 * stroke * turns, rel=2e-3)


def test_cam_push_is_zero_at_the_nose_at_float_speed() -> None:
    slow, fast = (catalogue_scene(f"cam-spring-{name}") for name in ("slow", "fast"))
    begins = CamFollower().joint_angles[1]
    angle = np.append(np.linspace(0.0, 2.0 * math.pi, 361), begins + 1e-6)

    def push(speed: float) -> Array:
        state = Instants(angle / speed, angle, np.full_like(angle, speed), np.zeros_like(angle))
        return joint_forces(slow.kinematics, state).components["contact"]["contact"]

    assert push(slow.speed).min() > 1.0
    assert push(fast.speed).min() < -1.0
    assert push(fast.speed).argmin() == 361
    found = brentq(lambda speed: float(push(speed).min()), slow.speed, fast.speed, xtol=1e-9)
    nose = CamFollower().motion(np.linspace(begins, math.pi, 2001), 1.0, 0.0).point("roller")
    # The spring's force over the mass that it has to bring down.
    square = 400.0 * (nose.position[:, 1] - 0.020) / (0.5 * -nose.acceleration[:, 1])
    assert found == pytest.approx(math.sqrt(square.min()), rel=1e-5)
    assert f"{found * 30.0 / math.pi:.1f} rpm" in fast.description


# -- MJCF --------------------------------------------------------------------------------------------------------------


def crank_acceleration(name: str, scene: DescribedScene) -> float:
    """Of the exported model as MuJoCo alone has it, at its keyframe, with the crank's flywheel taken away."""
    model = mujoco.MjModel.from_xml_string(standalone_mjcf(name, scene))
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    assert model.dof_armature.max() >= 1e12
    model.dof_armature[:] = 0.0
    mujoco.mj_setConst(model, data)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    mujoco.mj_forward(model, data)
    return float(data.qacc[model.joint("crank").dofadr[0]])


@pytest.mark.parametrize("name", [name for name in QUICK if not name.startswith("cam-")])
def test_exported_scene_has_exact_acceleration_in_mujoco_alone(name: str) -> None:
    """But for laws that MJCF has no words for, which the file's header names."""
    tables = tomllib.loads(catalogue_text(name))
    header = standalone_mjcf(name, catalogue_scene(name)).split("-->")[0]
    for load in callback_loads(catalogue_scene(name).mechanism()):
        assert load.name in header[header.index("NOT IN THIS MODEL") :]
        kind, _, its_name = load.name.partition(".")
        del tables[kind][its_name]
    scene = scene_from_tables(tables)
    exact = exact_acceleration(scene, scene.kinematics.span[0])
    found = crank_acceleration(name, catalogue_scene(name))
    assert found == pytest.approx(exact, rel=1e-3)
    for some in ("springs", "dampers", "torques"):
        without = tables.pop(some, None)
        if without and name != "slider-crank-spring":  # whose damper is at rest in this pose: not a word of it is lost
            assert found != pytest.approx(exact_acceleration(scene_from_tables(tables), 0.0), rel=1e-2)


def exact_acceleration(scene: DescribedScene, angle: float) -> float:
    """Of the crank [rad/s^2] at its speed where nothing drives it: with it the drive's torque is 0."""
    at, accelerations = np.full(2, angle), np.array([0.0, 1.0])
    state = Instants(np.zeros(2), at, np.full(2, scene.speed), accelerations)
    held, pushed = joint_forces(scene.kinematics, state).drive_torque
    return float(-held / (pushed - held))


# -- engines at constant crank speed -----------------------------------------------------------------------------------


@pytest.mark.parametrize("engine", ["mujoco", "pymunk"])
def test_soft_joints_stay_within_the_law_that_includes_the_cut(engine: str) -> None:
    scene, settings_of = catalogue_scene("press-cutting"), engine_named(engine).presets["tuned"]
    settings = settings_of(scene, 500)
    found = compare(run(scene, settings, 1.0), scene).worst("position")
    law = engine_named(engine).expected_error(scene, settings).position
    assert 0.2 * law < found < law
    if engine == "mujoco":  # whose joints give way; without the loads the law is much narrower
        tables = tomllib.loads(catalogue_text("press-cutting"))
        del tables["forces"], tables["torques"]
        unloaded = scene_from_tables(tables)
        assert engine_named(engine).expected_error(unloaded, settings_of(unloaded, 500)).position < 0.3 * found
