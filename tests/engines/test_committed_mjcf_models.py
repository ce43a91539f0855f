"""The committed MuJoCo models are what is exported today, and plain MuJoCo moves them along the exact motion."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest

from conrod import check_loops
from conrod.engines import engine_named
from conrod.engines.engine import run_extent
from conrod.exact.dynamics.forward import ForwardDynamics
from conrod.exact.motion import Array
from conrod.scenes import scene_named
from conrod.scenes.space import MACHINES
from docs.committed_models import ROOT, Model, equal_to_rounding, models

MODELS = models("mjcf")
DRIVEN = [one for one in MODELS if not one.free and one.name not in MACHINES]
FREE = [one for one in MODELS if one.free]
IN_SPACE = [one for one in MODELS if one.name in MACHINES]
FAST = ("saw-500rpm", "geneva", "jansen-leg", "pendulum", "saw-coasting", "bennett")
STEPS, PART_OF_TURN = 40, 0.05  # of a run, at least; or so much of a turn


def named(chosen: list[Model], fast: tuple[str, ...] = FAST) -> list[object]:
    """Models by the machine's name; those that are not named as fast are slow tests."""
    return [pytest.param(one, id=one.name, marks=[] if one.name in fast else [pytest.mark.slow]) for one in chosen]


@pytest.mark.parametrize("model", named(MODELS, tuple(one.name for one in MODELS if one.name != "four-bar-chain-40")))
def test_committed_mjcf_model_is_what_is_exported(model: Model) -> None:
    assert equal_to_rounding(str(model.text), model.file.read_text(encoding="utf-8"))


def test_no_other_mjcf_models_are_committed() -> None:
    assert set((ROOT / "mjcf").rglob("*.xml")) == {one.file for one in MODELS}
    assert len({one.name for one in MODELS}) == len(MODELS)


def load_alone(model: Model, folder: Path) -> tuple[mujoco.MjModel, mujoco.MjData]:
    """Load a copy of a committed file by plain MuJoCo, in the state of its keyframe."""
    copy = folder / "model.xml"
    copy.write_text(model.file.read_text(encoding="utf-8"), encoding="utf-8")
    made = mujoco.MjModel.from_xml_path(str(copy))
    data = mujoco.MjData(made)
    if made.nkey:
        mujoco.mj_resetDataKeyframe(made, data, 0)
    mujoco.mj_forward(made, data)
    return made, data


@pytest.mark.parametrize("model", named(DRIVEN))
def test_driven_mjcf_model_follows_the_exact_motion(model: Model, tmp_path: Path) -> None:
    scene, (made, data) = scene_named(model.name), load_alone(model, tmp_path)
    steps = round(scene.period / made.opt.timestep)
    crank = made.joint("crank").qposadr[0]
    start, first = run_extent(scene, steps, 1.0)[0], float(data.qpos[crank])
    angles: list[float] = []
    positions: dict[str, list[Array]] = {point: [] for point in scene.lengths}
    for _ in range(max(STEPS, round(steps * PART_OF_TURN))):
        angles.append(start + float(data.qpos[crank]) - first)
        for point, found in positions.items():
            found.append(data.site(point).xpos[:2].copy())
        mujoco.mj_step(made, data)
        mujoco.mj_kinematics(made, data)
    engine: Any = engine_named("mujoco")
    # A redundant machine has no law.
    law = engine.expected_error(scene, engine.presets["tuned"](scene, steps)).position or 1e-5

    def largest_error(at: Array) -> float:
        exact = scene.motion(at, scene.speed)
        off = {point: np.array(found) - exact.point(point).position for point, found in positions.items()}
        return max(float(np.linalg.norm(one, axis=1).max()) / scene.lengths[point] for point, one in off.items())

    assert largest_error(np.array(angles)) <= law
    # Negative control: the exact motion a thousandth of a turn on; half a turn with a cam, which may dwell.
    shift = np.pi if scene.kinematics.mechanism.cam_contacts else 2e-3 * np.pi
    assert largest_error(np.array(angles) + shift) > 2.0 * law


@pytest.mark.parametrize("model", named(FREE))
def test_free_mjcf_model_follows_the_exact_motion(model: Model, tmp_path: Path) -> None:
    scene, (made, data) = scene_named(model.name), load_alone(model, tmp_path)
    times = STEPS * made.opt.timestep * np.array([0.0, 0.5, 1.0])
    mechanism = scene.kinematics.mechanism
    exact = ForwardDynamics(mechanism).motion(times, rates=scene.start_rates)
    observed = {one.name: one for one in mechanism.observed}
    for k in range(len(times)):
        for point, length in scene.lengths.items():
            body = mechanism.body_index[observed[point].body]
            x, y, turn = exact.poses[k].reshape(-1, 3)[body]
            cosine, sine = np.cos(turn), np.sin(turn)
            arm = np.array([[cosine, -sine], [sine, cosine]]) @ np.array(observed[point].point)
            assert data.site(point).xpos[:2] == pytest.approx(np.array([x, y]) + arm, abs=1e-4 * length), point
        mujoco.mj_step(made, data, nstep=STEPS // 2)
        mujoco.mj_kinematics(made, data)


@pytest.mark.parametrize("model", named(IN_SPACE))
def test_mjcf_model_in_space_follows_the_exact_motion(model: Model) -> None:
    found = check_loops(model.file, drives=MACHINES[model.name]().drives, tolerance={"position": 1e-2})
    (study,) = found.values()
    assert study.kinematic["position"] < 1e-9
    assert study.mobility is not None


def test_slip_in_a_committed_mjcf_model_is_seen() -> None:
    text = (ROOT / "mjcf" / "catalogue" / "jansen-leg.xml").read_text(encoding="utf-8")
    right = 'armature="1e+14"'
    assert right in text
    assert not equal_to_rounding(text.replace(right, 'armature="1e+13"'), text)
