"""Models without a drive: no flywheel is in them, and they move as the engine's own free runs do, to the last bit."""

from __future__ import annotations

import re
from functools import cache
from pathlib import Path

import mujoco
import numpy as np
import pytest
from modules_alone import run_alone

import conrod
from conrod import InvalidInput
from conrod.engines import engine_named
from conrod.engines.engine import step_length
from conrod.engines.numerics import frames_from_centres
from conrod.engines.tracks import FreeRun, Pace
from conrod.exact.motion import Array
from conrod.models.export.api import free_start
from conrod.scenes import scene_named

# Each with the steps of a turn of its crank.
MACHINES = {"saw-500rpm": 1000, "pendulum": 500, "press-cutting": 1000, "slider-crank-spring": 1000, "cam-3-4-5": 2000}


@cache
def module(name: str, motor: bool = False) -> str:
    return str(conrod.export(name, "pymunk", steps_per_rev=MACHINES[name], free=True, motor=motor))


def free_run(name: str, engine: str, steps: int) -> FreeRun:
    scene = scene_named(name)
    step = step_length(scene, MACHINES[name])
    start, pace = free_start(name, scene), Pace(scene.period, False)
    return engine_named(engine).free_run(scene.kinematics.mechanism, "tuned", step, steps, *start, pace)  # type: ignore[attr-defined] # both engines have it


@cache
def engine_poses(name: str) -> Array:
    """Poses (3 n,) at the end of the engine's own run of two turns' time."""
    return free_run(name, "pymunk", 2 * MACHINES[name]).poses[-1]


def is_of_engine(name: str, text: str, folder: Path) -> bool:
    found = frames_from_centres(scene_named(name).kinematics.mechanism, *run_alone(text, folder))[0]
    return np.array_equal(found[0], engine_poses(name))


@pytest.mark.parametrize("name", MACHINES)
def test_free_module_makes_the_bits_of_the_engine(name: str, tmp_path: Path) -> None:
    assert is_of_engine(name, module(name), tmp_path)


# Negative control.
def test_a_slip_in_a_free_module_is_seen(tmp_path: Path) -> None:
    for right, wrong in (
        ("pymunk.Body(4.0, 0.02)", "pymunk.Body(4.0, 0.020000000000000004)"),
        ("0.5 * model.timestep * body.velocity", "0.5000001 * model.timestep * body.velocity"),
    ):
        assert module("saw-500rpm").count(right) == 1
        assert not is_of_engine("saw-500rpm", module("saw-500rpm").replace(right, wrong), tmp_path)


def test_free_models_have_no_flywheel_and_no_kinematic_crank() -> None:
    assert "KINEMATIC" not in module("saw-500rpm")
    assert "KINEMATIC" in str(conrod.export("saw-500rpm", "pymunk"))
    assert "Motor" not in module("saw-500rpm")
    file = str(conrod.export("saw-500rpm", "mjcf", free=True))
    assert re.findall('armature="(.*?)"', file) == ["0"]
    assert "<actuator>" not in file
    assert float(re.findall('armature="(.*?)"', str(conrod.export("saw-500rpm", "mjcf")))[0]) > 1e12


def test_motor_of_a_module_drives_the_crank_to_its_rate(tmp_path: Path) -> None:
    text = module("pendulum", motor=True)
    _, rates = run_alone(text, tmp_path, rate=-2.0, max_force=1e6)
    assert rates[0, 2] == pytest.approx(-2.0, abs=1e-9)
    # It cannot hold the bar, whose weight has a moment of 4.9 N m.
    _, rates = run_alone(text, tmp_path, rate=-2.0, max_force=0.01)
    assert abs(rates[0, 2] + 2.0) > 0.1


def test_free_mjcf_moves_as_the_engine_does() -> None:
    model = mujoco.MjModel.from_xml_string(
        str(conrod.export("saw-500rpm", "mjcf", steps_per_rev=MACHINES["saw-500rpm"], free=True))
    )
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    mujoco.mj_step(model, data, nstep=500)
    mujoco.mj_forward(model, data)
    run = free_run("saw-500rpm", "mujoco", 500)
    mechanism = scene_named("saw-500rpm").kinematics.mechanism
    slider = run.poses[-1][3 * mechanism.body_index["slider"] :][:2]
    assert data.site("C").xpos[:2] == pytest.approx(slider, abs=1e-12)


def test_motor_of_an_mjcf_is_a_torque_on_the_crank() -> None:
    model = mujoco.MjModel.from_xml_string(str(conrod.export("pendulum", "mjcf", free=True, motor=True)))
    data = mujoco.MjData(model)
    data.ctrl[:] = 2.0
    mujoco.mj_forward(model, data)
    # A bar of 1 kg and 1 m, held level: (2 - 9.81 / 2) / (1 / 3).
    assert data.qacc[0] == pytest.approx(3.0 * (2.0 - 9.81 / 2.0), rel=1e-9)


def test_a_machine_at_rest_that_nothing_moves_is_refused() -> None:
    still = conrod.scene("pendulum", **{"gravity.y": 0.0})
    for format in ("pymunk", "mjcf"):
        with pytest.raises(InvalidInput, match="--free: pendulum rests, and no weight or load moves it: --motor"):
            conrod.export(("pendulum", still), format, free=True)
    assert "SimpleMotor" in str(conrod.export(("pendulum", still), "pymunk", free=True, motor=True))
