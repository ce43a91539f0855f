"""Hardening a user's model closes its loops, on models that conrod did not make."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path

import mujoco
import numpy as np
import pytest

from conrod.exact.motion import Array
from conrod.mjcf.harden.closures import active_closures, loops_of, openings
from conrod.mjcf.harden.recipe import RESIDUE, Recipe, Weights, edited, recipe_for, to_know, touching_scaled
from conrod.mjcf.harden.results import HardenedModel, Request
from conrod.mjcf.harden.runs import Pace, start_of, swing
from conrod.mjcf.harden.study import binary, harden_file
from tests.support.exact_loops import ExactLoops
from tests.support.legged import LEGGED, legged, opening_of

KEPT = Request(integrator="keep", solref="keep")


@cache
def found(keyframe: str) -> HardenedModel:
    return harden_file(LEGGED, Request(keyframe=keyframe, seconds=0.15))


# -- what it is for --------------------------------------------------------------------------------------------------


def test_hardening_closes_every_loop_by_orders_of_magnitude() -> None:
    before, weights_alone, after = found("swing").variants
    assert [loop.name for loop in found("swing").loops] == ["left-loop", "right-loop", "gait"]
    assert [loop.unit for loop in found("swing").loops] == ["m", "m", "rad"]
    assert all(now < 1e-5 * then for then, now in zip(before.openings, after.openings, strict=True))
    # Control: it is the whole recipe that does it; weights alone leave the loops to the step of Euler.
    assert all(now < 1e-2 * then for then, now in zip(weights_alone.openings, after.openings, strict=True))
    assert weights_alone.closing.claimed == pytest.approx(1.0, abs=0.1)


def test_the_motion_of_hardened_loops_is_of_order_4_and_was_of_none_that_a_step_could_give() -> None:
    before, weights_alone, after = found("swing").variants
    assert after.drift.claimed == pytest.approx(4.0, abs=0.1)
    assert after.drift.values[0] < 1e-3 * before.drift.values[0]
    assert weights_alone.drift.claimed == pytest.approx(1.0, abs=0.1)
    # Softness stays whatever the step: RK4 alone has no order at all.
    start = start_of(legged(), "swing", active_closures(legged()))
    soft = edited(legged(), None)
    soft.opt.integrator = mujoco.mjtIntegrator.mjINT_RK4
    wide = [opening_of(soft, start.state, Pace(50, 3 * k, 0.001 / k)) for k in (1, 4)]
    assert wide[1] == pytest.approx(wide[0], rel=0.1)


def test_hardened_loops_keep_their_energy() -> None:
    before, _, after = found("swing").variants
    assert set(found("swing").energy_without) == {"contacts", "limits", "damping"}
    assert after.energy < 1e-4 * before.energy


def test_loops_stay_closed_when_feet_hit_the_floor_and_knees_their_stops() -> None:
    before, _, after = found("drop").variants
    for variant in (before, after):
        assert variant.broke is None
        assert variant.touching.contacts == 2
        assert variant.touching.penetration > 1e-3
    assert after.opening_over_size < 1e-3 * before.opening_over_size


def test_the_hardened_motion_is_that_of_loops_closed_by_lagrange_multipliers() -> None:
    # An independent judge: neither MuJoCo's solver nor any regularisation is in it.
    state = start_of(legged(), "swing", active_closures(legged())).state
    pace = Pace(5, 20, 0.001)
    exact = exact_points(legged(), state, pace)
    recipe = recipe_for(legged(), active_closures(legged()), Request())
    hard, soft = (swing(edited(legged(), edit), state, pace, ()).points for edit in (recipe, None))
    error, control = (float(np.abs(found - exact).max()) for found in (hard, soft))
    assert error < 2e-8
    assert control > 1e-4


def exact_points(model: mujoco.MjModel, state: Array, pace: Pace) -> Array:
    """(S + 1, bodies, 3) by the same Runge-Kutta method at the same step: what differs is the solver's."""
    exact = ExactLoops(model, state, pace.timestep)
    points = [exact.points()]
    for _ in range(pace.samples):
        for _ in range(pace.stride):
            exact.step()
        points.append(exact.points())
    return np.array(points)


# -- which factor ----------------------------------------------------------------------------------------------------

PRESS = """
<mujoco><option timestep="0.001" integrator="RK4"><flag contact="disable"/></option>
<worldbody>
  <body name="crank"><joint name="crank" axis="0 1 0"/>
    <geom type="capsule" fromto="0 0 0 0.0325 0 0" size="0.01" mass="5"/>
    <body name="rod" pos="0.0325 0 0"><joint name="pin" axis="0 1 0"/>
      <geom type="capsule" fromto="0 0 0 0.38864 0 0.0325" size="0.01" mass="8"/>
      <site name="rod-end" pos="0.38864 0 0.0325"/></body></body>
  <body name="slider" pos="0.42114 0 0.0325"><joint name="slide" type="slide" axis="1 0 0"/>
    <geom size="0.03" mass="60"/><site name="slider"/></body>
</worldbody>
<equality><connect name="loop" site1="rod-end" site2="slider" solref="0.01 1" {}/></equality></mujoco>
"""


@pytest.mark.parametrize("solimp", ["", 'solimp="0.9999 0.9999 0.001"'], ids=["stock", "stiff"])
def test_what_is_left_of_the_regularisation_decides_and_neither_too_much_nor_too_little_is_best(solimp: str) -> None:
    model = mujoco.MjModel.from_xml_string(PRESS.format(solimp))
    closures = active_closures(model)
    state = start_of(model, None, closures).state
    pace = Pace(10, 30, 0.001)
    exact = exact_points(model, state, pace)
    chosen = recipe_for(model, closures, KEPT)
    errors = {}
    for share in (1e5, 1.0, 1e-5):
        recipe = replace(chosen, factor=chosen.factor * share)
        errors[share] = float(np.abs(swing(edited(model, recipe), state, pace, ()).points - exact).max())
    assert RESIDUE == 1e-9
    assert errors[1.0] < 1e-2 * errors[1e5]
    assert errors[1.0] < 1e-2 * errors[1e-5]


def test_stiffer_closures_get_less_of_it() -> None:
    factors = []
    for solimp in ("", 'solimp="0.9999 0.9999 0.001"'):
        model = mujoco.MjModel.from_xml_string(PRESS.format(solimp))
        factors.append(recipe_for(model, active_closures(model), Request()).factor)
    assert factors == pytest.approx([9e-9, 1e-5], rel=2e-3)


def test_only_what_the_loops_are_held_by_hardens() -> None:
    model = legged()
    recipe = recipe_for(model, active_closures(model), Request())
    hard = edited(model, recipe)
    held = {"left-shank", "left-rod", "right-shank", "right-rod"}
    for body in range(1, model.nbody):
        name = mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_BODY, body)
        ratio = hard.body_invweight0[body] / model.body_invweight0[body]
        assert ratio == pytest.approx(recipe.factor if name in held else 1.0)
    hips = [model.joint("left-hip").dofadr[0], model.joint("right-hip").dofadr[0]]
    changed = np.flatnonzero(hard.dof_invweight0 != model.dof_invweight0)
    assert sorted(changed.tolist()) == sorted(hips)
    assert touching_scaled(model, recipe.weights) == ()
    # Control: a geom on a held body that can collide, and a limit of a held joint, are told.
    model = mujoco.MjModel.from_xml_string(
        LEGGED.read_text()
        .replace('fromto="0 0 0 0 0 -0.4" size="0.02"', 'fromto="0 0 0 0 0 -0.4" size="0.02" contype="1" name="l"', 1)
        .replace('name="left-hip"', 'name="left-hip" limited="true" range="-1 1"')
    )
    weights = Weights.of(active_closures(model))
    assert touching_scaled(model, weights) == ("geom l", "limit of joint left-hip")
    assert any("friction" in note for note in to_know(model, active_closures(model)))


# -- start, run, figures ---------------------------------------------------------------------------------------------


def test_a_start_that_leaves_loops_open_is_closed_and_told() -> None:
    lever = 'name="left-lever" pos="-0.08 {} 0{}"'
    aside, apart = (
        mujoco.MjModel.from_xml_string(LEGGED.read_text().replace(lever.format("0.05", ""), lever.format(*place)))
        for place in (("0.05", ".002"), ("3", ""))
    )
    closures = active_closures(aside)
    start = start_of(aside, "swing", closures)
    assert start.given["m"] == pytest.approx(0.002)
    assert start.closed
    first = swing(aside, start.state, Pace(1, 1, 0.001), closures).openings[0]
    assert first.max() < 1e-12
    # One that no pose can close is left as it is.
    assert not start_of(apart, "swing", active_closures(apart)).closed


def test_a_weld_is_told_in_metres_and_radians() -> None:
    model = mujoco.MjModel.from_xml_string(
        '<mujoco><worldbody><body name="held"><freejoint/><geom size="0.05"/></body></worldbody>'
        '<equality><weld name="grip" body1="held" torquescale="0.5"/></equality></mujoco>'
    )
    closures = active_closures(model)
    data = mujoco.MjData(model)
    data.qpos[0] = 0.01
    mujoco.mju_axisAngle2Quat(data.qpos[3:], np.array([0.0, 0.0, 1.0]), 0.3)
    mujoco.mj_fwdPosition(model, data)
    assert [loop.unit for loop in loops_of(closures)] == ["m", "rad"]
    assert openings(model, data, closures) == pytest.approx([0.01, 0.3])


def test_the_binary_model_is_mujocos_own_and_the_user_model_is_not_changed(tmp_path: Path) -> None:
    recipe = recipe_for(legged(), active_closures(legged()), Request())
    before = binary(legged())
    hard = edited(legged(), recipe)
    assert binary(legged()) == before
    mujoco.mj_saveModel(hard, str(tmp_path / "hard.mjb"), None)
    assert (tmp_path / "hard.mjb").read_bytes() == binary(hard) != before


def test_the_recipe_can_keep_what_the_model_has() -> None:
    closures = active_closures(legged())
    kept = recipe_for(legged(), closures, KEPT)
    assert kept == Recipe(kept.factor, kept.weights)
    slower = recipe_for(legged(), closures, Request(solref=0.05))
    assert slower.time_constants == ((0, 0.05), (1, 0.05), (2, 0.05))
    hard = edited(legged(), slower)
    assert hard.eq_solref[:, 0].tolist() == [0.05] * 3
    assert mujoco.mjtIntegrator(hard.opt.integrator) == mujoco.mjtIntegrator.mjINT_RK4
