"""Hardening a user's model closes its loops, on models that conrod did not make; and where it would do harm."""

from __future__ import annotations

import copy
from dataclasses import replace
from functools import cache
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import mujoco
import numpy as np
import pytest

from conrod.engines.mujoco.harden.closures import Weights, active_closures, compliance, loops_of, openings
from conrod.engines.mujoco.harden.measuring import edited
from conrod.engines.mujoco.harden.objections import nothing_to_do, soft_on_purpose, to_know, touching_scaled
from conrod.engines.mujoco.harden.recipe import RESIDUE, Recipe, recipe_for
from conrod.engines.mujoco.harden.start import start_of
from conrod.engines.mujoco.harden.study import binary, harden_file, pace_of
from conrod.engines.mujoco.harden.swing import Pace, swing
from conrod.errors import InvalidInput
from conrod.hardened_model import HardenedModel, Request, Variant
from conrod.motion import Array
from tests.exact_loops import ExactLoops

LEGGED = Path(__file__).parent / "models" / "legged.xml"
KEPT = Request(integrator="keep", solref="keep")

TWO_ARMS = """
<mujoco><option timestep="0.002"/><worldbody>
  <body name="a"><joint name="a" axis="0 1 0"/><geom size="0.05" pos="0.3 0 0" mass="1"/></body>
  <body name="b" pos="0 0.5 0"><joint name="b" axis="0 1 0"/><geom size="0.05" pos="0.3 0 0" mass="1"/></body>
  <body name="hand" mocap="true" pos="0 1 0"/>
  <body name="held" pos="0 1 0"><freejoint/><geom size="0.05"/></body>
</worldbody><equality>{}</equality></mujoco>
"""


def two_arms(equality: str) -> mujoco.MjModel:
    return mujoco.MjModel.from_xml_string(TWO_ARMS.format(equality))


@cache
def legged() -> mujoco.MjModel:
    return mujoco.MjModel.from_xml_path(str(LEGGED))


@cache
def found(keyframe: str) -> HardenedModel:
    return harden_file(LEGGED, Request(keyframe=keyframe, seconds=0.15))


def three(study: HardenedModel) -> tuple[Variant, Variant, Variant]:
    before, weights_alone, after = study.variants
    return before, weights_alone, after


# -- what it is for --------------------------------------------------------------------------------------------------


def test_hardening_closes_every_loop_by_orders_of_magnitude() -> None:
    before, _, after = three(found("swing"))
    assert before.openings is not None
    assert after.openings is not None
    assert [loop.name for loop in found("swing").loops] == ["left-loop", "right-loop", "gait"]
    assert [loop.unit for loop in found("swing").loops] == ["m", "m", "rad"]
    assert all(now < 1e-5 * then for then, now in zip(before.openings, after.openings, strict=True))


def test_weights_alone_leave_the_loops_to_the_step_of_euler() -> None:
    # Control of the claim above: it is the whole recipe that does it.
    _, weights_alone, after = three(found("swing"))
    assert weights_alone.openings is not None
    assert after.openings is not None
    assert all(now < 1e-2 * then for then, now in zip(weights_alone.openings, after.openings, strict=True))
    assert weights_alone.closing is not None
    assert weights_alone.closing.claimed == pytest.approx(1.0, abs=0.1)


def test_the_motion_of_hardened_loops_is_of_order_4_and_was_of_none_that_a_step_could_give() -> None:
    before, weights_alone, after = three(found("swing"))
    assert before.drift is not None
    assert weights_alone.drift is not None
    assert after.drift is not None
    assert after.drift.claimed == pytest.approx(4.0, abs=0.1)
    assert after.drift.values[0] < 1e-3 * before.drift.values[0]
    assert weights_alone.drift.claimed == pytest.approx(1.0, abs=0.1)
    # Softness stays whatever the step: RK4 alone has no order at all.
    start = start_of(legged(), "swing", active_closures(legged()))
    soft = edited(legged(), None)
    soft.opt.integrator = mujoco.mjtIntegrator.mjINT_RK4
    wide = [opening_of(soft, start.state, Pace(50, 3 * k, 0.001 / k)) for k in (1, 4)]
    assert wide[1] == pytest.approx(wide[0], rel=0.1)


def opening_of(model: mujoco.MjModel, state: Array, pace: Pace) -> float:
    return float(swing(model, state, pace, active_closures(model)).openings.max())


def test_hardened_loops_keep_their_energy() -> None:
    before, _, after = three(found("swing"))
    assert set(found("swing").energy_without) == {"contacts", "limits", "damping"}
    assert before.energy is not None
    assert after.energy is not None
    assert after.energy < 1e-4 * before.energy


def test_loops_stay_closed_when_feet_hit_the_floor_and_knees_their_stops() -> None:
    before, _, after = three(found("drop"))
    for variant in (before, after):
        assert variant.broke is None
        assert variant.touching is not None
        assert variant.touching.contacts == 2
        assert variant.touching.penetration > 1e-3
    assert before.opening_over_size is not None
    assert after.opening_over_size is not None
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


# -- where it would do harm ------------------------------------------------------------------------------------------

BELT = '<joint name="belt" joint1="a" joint2="b" {}/>'


@pytest.mark.parametrize(
    ("equality", "why"),
    [
        (BELT.format('solref="0.1 1"'), "softer than MuJoCo's stock"),
        (BELT.format('solimp="0.5 0.95 0.001"'), "softer than MuJoCo's stock"),
        (BELT.format('solref="-200 -5"'), "given as such"),
        ('<weld name="belt" body1="hand" body2="held"/>', "mocap"),
    ],
)
def test_a_closure_that_is_meant_to_give_way_is_refused_by_name(equality: str, why: str) -> None:
    model = two_arms(equality)
    (reason,) = soft_on_purpose(model, active_closures(model))
    assert reason.startswith("belt: ")
    assert why in reason


@pytest.mark.parametrize("setting", ["", 'solref="0.02 1"', 'solref="0.1 1" solimp="0.9999 0.9999 0.001"'])
def test_a_stock_closure_or_one_slow_but_stiff_is_not(setting: str) -> None:
    model = two_arms(BELT.format(setting))
    assert soft_on_purpose(model, active_closures(model)) == ()


def test_softness_is_how_far_a_closure_gives_way_under_a_force() -> None:
    solref, solimp = np.array([0.05, 1.5]), np.array([0.7, 0.7, 0.001, 0.5, 2.0])
    model = mujoco.MjModel.from_xml_string(
        '<mujoco><worldbody><body name="a"><joint type="slide" axis="0 0 1"/><geom size="0.1" mass="3"/></body>'
        '</worldbody><equality><connect body1="a" anchor="0 0 0" solref="0.05 1.5" solimp="0.7 0.7 0.001"/></equality>'
        "</mujoco>"
    )
    data = mujoco.MjData(model)
    mujoco.mj_step(model, data, 5000)
    mujoco.mj_forward(model, data)
    (opening,) = openings(model, data, active_closures(model))
    assert opening == pytest.approx(9.81 * compliance(solref, solimp, 0.0), rel=1e-6)


def test_single_precision_is_refused() -> None:
    single: Any = SimpleNamespace(body_invweight0=legged().body_invweight0.astype(np.float32))
    assert "single precision" in nothing_to_do(single, active_closures(legged()))
    assert nothing_to_do(legged(), active_closures(legged())) == ""


def test_no_closed_loop_is_nothing_to_harden() -> None:
    assert "no closed loop" in nothing_to_do(two_arms(""), ())
    inactive = two_arms(BELT.format('active="false"'))
    assert "belt" in nothing_to_do(inactive, active_closures(inactive))
    switched_off = copy.copy(legged())
    switched_off.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_EQUALITY)
    assert active_closures(switched_off) == ()


def test_set_const_undoes_it_and_a_hardened_model_is_told_from_one_that_is_not() -> None:
    closures = active_closures(legged())
    recipe = recipe_for(legged(), closures, Request())
    model = edited(legged(), recipe)
    assert "hardened already" in nothing_to_do(model, closures)
    mujoco.mj_setConst(model, mujoco.MjData(model))
    np.testing.assert_allclose(recipe.weights.values(model), recipe.weights.values(legged()), rtol=1e-9)
    assert nothing_to_do(model, closures) == ""
    state = start_of(legged(), "swing", closures).state
    pace = Pace(50, 2, 0.001)
    undone, hard = opening_of(model, state, pace), opening_of(edited(legged(), recipe), state, pace)
    assert hard < 1e-5 * undone


def test_a_run_that_breaks_or_opens_more_when_hard_is_refused(tmp_path: Path) -> None:
    # Euler opens the loops in every step, and slow feedback lets it: a stiff model is better as it is.
    setting = 'solref="0.002 1" solimp="0.99 0.99 0.001"'
    text = (
        LEGGED.read_text()
        .replace("<connect ", f"<connect {setting} ")
        .replace('<joint name="gait"', f'<joint name="gait" {setting}')
    )
    model = tmp_path / "stiff.xml"
    model.write_text(text)
    request = Request(keyframe="swing", seconds=0.05, integrator="keep", solref=0.1)
    study = harden_file(model, request)
    assert len(study.refusals) == 1
    assert study.content is None
    assert "its loops open more" in study.refusals[0]
    forced = harden_file(model, replace(request, force=True))
    assert forced.refusals == ()
    assert study.refusals[0] in forced.warnings
    assert forced.content is not None
    # Control: the whole recipe is not refused.
    assert harden_file(model, replace(request, integrator="RK4", solref="auto")).refusals == ()


def test_a_curved_joint_equality_is_not_slowed_for_it_opens_with_the_square_of_its_time_constant() -> None:
    model = two_arms('<joint name="cam" joint1="a" joint2="b" solref="0.005 1" polycoef="0 1 0.3 0 0"/>')
    straight = two_arms('<joint name="cam" joint1="a" joint2="b" solref="0.005 1"/>')
    assert recipe_for(model, active_closures(model), Request()).time_constants == ()
    assert recipe_for(straight, active_closures(straight), Request()).time_constants == ((0, 0.02),)
    assert any("cam" in note and "velocity" in note for note in to_know(model, active_closures(model)))
    assert to_know(straight, active_closures(straight)) == ()
    recipe = recipe_for(model, active_closures(model), Request())
    state = start_of(model, None, active_closures(model)).state
    wide = [
        opening_of(edited(model, replace(recipe, time_constants=((0, constant),))), state, Pace(100, 4, 0.002))
        for constant in (0.01, 0.02)
    ]
    assert np.log2(wide[1] / wide[0]) == pytest.approx(2.0, abs=0.2)


# -- start, run, figures ---------------------------------------------------------------------------------------------


def test_a_start_that_leaves_loops_open_is_closed_and_told() -> None:
    model = mujoco.MjModel.from_xml_string(
        LEGGED.read_text().replace('name="left-lever" pos="-0.08 0.05 0"', 'name="left-lever" pos="-0.08 0.05 0.002"')
    )
    closures = active_closures(model)
    start = start_of(model, "swing", closures)
    assert start.given["m"] == pytest.approx(0.002)
    assert start.closed
    first = swing(model, start.state, Pace(1, 1, 0.001), closures).openings[0]
    assert first.max() < 1e-12
    # One that no pose can close is left as it is.
    apart = mujoco.MjModel.from_xml_string(
        LEGGED.read_text().replace('name="left-lever" pos="-0.08 0.05 0"', 'name="left-lever" pos="-0.08 3 0"')
    )
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
    assert [loop.unit for loop in loops_of(model, closures)] == ["m", "rad"]
    assert openings(model, data, closures) == pytest.approx([0.01, 0.3])


def test_the_binary_model_is_mujocos_own_and_the_user_model_is_not_changed(tmp_path: Path) -> None:
    recipe = recipe_for(legged(), active_closures(legged()), Request())
    before = binary(legged())
    hard = edited(legged(), recipe)
    assert binary(legged()) == before
    mujoco.mj_saveModel(hard, str(tmp_path / "hard.mjb"), None)
    assert (tmp_path / "hard.mjb").read_bytes() == binary(hard) != before


@pytest.mark.parametrize("seconds", [0.001, 1e6])
def test_runs_too_short_or_too_long_are_refused(seconds: float) -> None:
    with pytest.raises(InvalidInput, match="out of range"):
        pace_of(legged(), seconds)
    assert pace_of(legged(), 1.0) == Pace(500, 2, 0.001)


def test_the_recipe_can_keep_what_the_model_has() -> None:
    closures = active_closures(legged())
    kept = recipe_for(legged(), closures, KEPT)
    assert kept == Recipe(kept.factor, kept.weights)
    slower = recipe_for(legged(), closures, Request(solref=0.05))
    assert slower.time_constants == ((0, 0.05), (1, 0.05), (2, 0.05))
    hard = edited(legged(), slower)
    assert hard.eq_solref[:, 0].tolist() == [0.05] * 3
    assert mujoco.mjtIntegrator(hard.opt.integrator) == mujoco.mjtIntegrator.mjINT_RK4
