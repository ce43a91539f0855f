"""Hardening a user's model closes its loops, on models that conrod did not make; those it would do harm are refused."""

from __future__ import annotations

import copy
import json
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest
from command_line import conrod
from own_model_edits import TEXTS, replace_once

from conrod.engines.mujoco.model import equality_jacobian
from conrod.exact.motion import Array
from conrod.mjcf.edits import Recipe, apply_recipe
from conrod.mjcf.equalities import constraint_violations
from conrod.mjcf.hardenable import active_closures
from conrod.mjcf.runs import STATE
from conrod.models.harden import recipe as recipes
from conrod.models.harden.results import HardenedModel
from conrod.models.harden.study import closed_start, harden_file, reference_motion, run_finer

LEGGED = Path(__file__).parents[1] / "support" / "models" / "legged.xml"


@cache
def legged() -> mujoco.MjModel:
    return mujoco.MjModel.from_xml_path(str(LEGGED))


def opening_of(model: mujoco.MjModel, state: Array, steps: int, every: int, finer: int = 1) -> float:
    return float(run_finer(model, state, steps, every, finer).constraint_violations(float(model.stat.extent)).max())


def exact_points(model: mujoco.MjModel, state: Array, steps: int, every: int) -> Array:
    """(S + 1, bodies, 3) centres of gravity by Lagrange multipliers for the equalities, nothing regularised.

    M a = f + J^T l, J a = a_ref (MuJoCo's: the velocity's part and Baumgarte's feedback), the redundant rows by least
    squares; stepped by the classical Runge-Kutta method at the same step. Contacts and limits do not act.
    """
    model = copy.copy(model)
    model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_CONTACT | mujoco.mjtDisableBit.mjDSBL_LIMIT)
    data, h, moving = mujoco.MjData(model), model.opt.timestep, model.body_weldid > 0
    mujoco.mj_setState(model, data, state, STATE)

    def acceleration(q: Array, v: Array) -> Array:
        data.qpos[:], data.qvel[:] = q, v
        mujoco.mj_forward(model, data)
        jacobian = equality_jacobian(model, data)
        spread = np.zeros_like(jacobian)
        mujoco.mj_solveM(model, data, spread, jacobian)  # rows of J M^-1
        wanted = data.efc_aref[: len(jacobian)] - jacobian @ data.qacc_smooth
        multipliers = np.linalg.lstsq(spread @ jacobian.T, wanted, rcond=1e-13)[0]
        return np.asarray(data.qacc_smooth + spread.T @ multipliers)

    def moved(q: Array, by: Array) -> Array:
        result = q.copy()
        mujoco.mj_integratePos(model, result, by, 1.0)
        return result

    q, v, points = data.qpos.copy(), data.qvel.copy(), list[Array]()
    for step in range(steps + 1):
        rates, pushes = [v], [acceleration(q, v)]
        if step % every == 0:
            points.append(data.xipos[moving].copy())
        for share in (0.5, 0.5, 1.0):
            place = moved(q, share * h * rates[-1])
            rates.append(v + share * h * pushes[-1])
            pushes.append(acceleration(place, rates[-1]))
        by, gain = (h / 6 * (k[0] + 2 * k[1] + 2 * k[2] + k[3]) for k in (rates, pushes))
        q, v = moved(q, by), v + gain
    return np.array(points)


@cache
def found(keyframe: str) -> HardenedModel:
    return harden_file(LEGGED, keyframe, 0.15)


def alone(recipe: Recipe) -> Recipe:
    """The weights, and nothing else."""
    return tuple(edit for edit in recipe if edit.scales)


# -- what it is for --------------------------------------------------------------------------------------------------


def test_hardening_closes_loops_by_the_whole_recipe_alone() -> None:
    before, after = found("swing").variants
    assert found("swing").loops == ("connect left-loop", "connect right-loop", "joint gait")
    assert all(now < 1e-5 * then for then, now in zip(before.openings, after.openings, strict=True))
    assert after.drift < 1e-3 * before.drift
    # Control: it is the whole recipe that does it. Weights alone leave the loops to the step of Euler; softness stays
    # whatever the step, so that RK4 alone has no order at all.
    closures = active_closures(legged())
    start, _ = closed_start(legged(), "swing")
    scaled, soft = apply_recipe(legged(), alone(recipes.recipe_for(legged(), closures))), copy.copy(legged())
    soft.opt.integrator = mujoco.mjtIntegrator.mjINT_RK4
    for model, order in ((scaled, 1.0), (soft, 0.0)):
        wide = [opening_of(model, start, 150, 3, k) for k in (1, 4)]
        assert np.log(wide[0] / wide[1]) / np.log(4.0) == pytest.approx(order, abs=0.1)


def test_loops_stay_closed_when_feet_hit_floor_and_knees_stops() -> None:
    before, after = found("drop").variants
    assert before.broke == after.broke == ""
    assert max(after.openings) < 1e-3 * max(before.openings)


def test_hardened_motion_equals_that_of_lagrange_multipliers() -> None:
    # An independent judge: neither MuJoCo's solver nor any regularisation is in it.
    state = closed_start(legged(), "swing")[0]
    exact = exact_points(legged(), state, 100, 20)
    recipe = recipes.recipe_for(legged(), active_closures(legged()))

    def error(recipe: Recipe) -> float:
        return float(np.abs(run_finer(apply_recipe(legged(), recipe), state, 100, 20).centres - exact).max())

    assert error(recipe) < 2e-8
    assert error(()) > 1e-4
    # Neither more nor less of the regularisation would do.
    for share in (1e5, 1e-5):
        other = tuple(replace(edit, value=edit.value * share) if edit.scales else edit for edit in recipe)
        assert error(recipe) < 0.05 * error(other)
    stiff = two_arms(BELT.format('solimp="0.9999 0.9999 0.001"'))
    factors = [recipe[0].value, recipes.recipe_for(stiff, active_closures(stiff))[0].value]
    assert factors == pytest.approx([9e-9, 1e-5], rel=2e-3)


# -- start, run, figures ---------------------------------------------------------------------------------------------


def test_a_start_that_leaves_loops_open_is_closed_and_told() -> None:
    lever = 'name="left-lever" pos="-0.08 {} 0{}"'
    aside, apart = (
        mujoco.MjModel.from_xml_string(LEGGED.read_text().replace(lever.format("0.05", ""), lever.format(*place)))
        for place in (("0.05", ".002"), ("3", ""))
    )
    state, start = closed_start(aside, "swing")
    assert (start["start_opening"], start["start_closed"]) == (pytest.approx(0.002), True)
    first = run_finer(aside, state, 1, 1).constraint_violations(1.0)[0]
    assert first.max() < 1e-12
    # One that no pose can close is left as it is.
    assert not closed_start(apart, "swing")[1]["start_closed"]


def test_a_weld_is_open_by_its_place_or_by_its_turn_at_an_extent() -> None:
    model = mujoco.MjModel.from_xml_string(
        '<mujoco><worldbody><body name="held"><freejoint/><geom size="0.05"/></body></worldbody>'
        '<equality><weld name="grip" body1="held" torquescale="0.5"/></equality></mujoco>'
    )
    data = mujoco.MjData(model)
    data.qpos[0] = 0.01
    mujoco.mju_axisAngle2Quat(data.qpos[3:], np.array([0.0, 0.0, 1.0]), 0.3)
    mujoco.mj_fwdPosition(model, data)
    assert constraint_violations(model, data, 0.0) == pytest.approx([0.01])
    assert constraint_violations(model, data, 0.2) == pytest.approx([0.2 * 2.0 * np.sin(0.15)])


# -- models that hardening would do harm to, or nothing ------------------------------------------------------------

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


BELT = '<joint name="belt" joint1="a" joint2="b" {}/>'


@pytest.mark.parametrize(
    ("equality", "why"),
    [
        (BELT.format('solref="0.1 1"'), "softer than MuJoCo's stock"),
        (BELT.format('solref="-200 -5"'), "given as such"),
        # A stock closure, or one slow but stiff, is not.
        *((BELT.format(stiff), "") for stiff in ("", 'solref="0.1 1" solimp="0.9999 0.9999 0.001"')),
    ],
)
def test_a_closure_that_is_meant_to_give_way_is_refused_by_name(equality: str, why: str) -> None:
    model = two_arms(equality)
    reasons = recipes.soft_on_purpose(model, active_closures(model))
    assert [reason.startswith("belt: ") and why in reason for reason in reasons] == [True] * bool(why)


HELD = '<weld name="grip" body1="hand" body2="held"/>'
GRIPS = (
    HELD,
    '<weld name="grip" body1="held" body2="hand"/>',
    '<connect name="grip" body1="hand" body2="held" anchor="0 0 0"/>',
    '<weld name="grip" site1="on_hand" site2="on_held"/>',
)


@pytest.mark.parametrize("grip", GRIPS)
def test_weld_to_a_mocap_body_is_a_handle_and_no_closure(grip: str, tmp_path: Path) -> None:
    words = "grip is a handle: it drags held after the mocap body hand"
    site = '<body name="hand" mocap="true" pos="0 1 0"><body name="palm"><site name="on_hand"/></body></body>'
    text = TWO_ARMS.replace('<body name="hand" mocap="true" pos="0 1 0"/>', site)
    text = text.replace('<geom size="0.05"/></body>', '<geom size="0.05"/><site name="on_held"/></body>')
    path = tmp_path / "arms.xml"
    path.write_text(text.format(grip))
    (refusal,) = harden_file(path, seconds=0.1).refusals
    assert refusal == f"{words}; nothing to harden; --force hardens it all the same"
    assert harden_file(path, seconds=0.1, force=True).content is not None
    # Beside a closed loop it is left as it is, and said.
    path.write_text(text.format(grip + BELT.format("")))
    found = harden_file(path, seconds=0.1)
    assert (found.loops, found.refusals) == (("joint belt",), ())
    assert f"{words}; so not hardened" in found.warnings
    assert "joint belt" in harden_file(path, seconds=0.1, force=True).loops
    # Negative control: a body that stands still is no hand.
    fixed = mujoco.MjModel.from_xml_string(text.replace(' mocap="true"', "").format(grip))
    assert [one.name for one in active_closures(fixed)] == ["grip"]


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
    (opening,) = constraint_violations(model, data, 0.0)
    assert opening == pytest.approx(9.81 * recipes.compliance(solref, solimp, 0.0), rel=1e-6)


def test_set_const_undoes_hardening_and_recipe_detects_hardening() -> None:
    closures = active_closures(legged())
    recipe = recipes.recipe_for(legged(), closures)
    model = apply_recipe(legged(), recipe)
    assert "hardened already" in recipes.refusal_reason(model, closures)
    mujoco.mj_setConst(model, mujoco.MjData(model))
    np.testing.assert_allclose(
        recipes.inverse_weights(model, closures), recipes.inverse_weights(legged(), closures), rtol=1e-9
    )
    assert recipes.refusal_reason(model, closures) == recipes.refusal_reason(legged(), closures) == ""
    inactive = two_arms(BELT.format('active="false"'))
    assert "none of its equality constraints is active" in recipes.refusal_reason(inactive, active_closures(inactive))
    state = closed_start(legged(), "swing")[0]
    undone, hard = (opening_of(one, state, 100, 2) for one in (model, apply_recipe(legged(), recipe)))
    assert hard < 1e-5 * undone


def test_loops_that_open_more_when_hard_are_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    # Euler opens the loops in every step, and slow feedback lets it: a stiff model is better as it is.
    setting = 'solref="0.002 1" solimp="0.99 0.99 0.001"'
    text = LEGGED.read_text()
    for tag in ("<connect", '<joint name="gait"'):
        text = text.replace(tag, f"{tag} {setting}")
    model = tmp_path / "stiff.xml"
    model.write_text(text)
    assert harden_file(model, "swing", 0.05).refusals == ()

    edited = apply_recipe

    def slow(model: mujoco.MjModel, recipe: Recipe) -> mujoco.MjModel:
        changed = edited(model, alone(recipe))
        changed.eq_solref[:3, 0] = 0.1
        return changed

    monkeypatch.setattr("conrod.models.harden.study.apply_recipe", slow)
    study, forced = (harden_file(model, "swing", 0.05, force=force) for force in (False, True))
    (reason,) = study.refusals
    assert "its loops open more" in reason
    assert (study.content, forced.refusals) == (None, ())
    assert reason == f"{forced.warnings[0]}; --force hardens it all the same"
    assert forced.content is not None


def test_model_is_refused_when_it_breaks_off_hard_and_soft(tmp_path: Path) -> None:
    # A motor whose feedback feeds: hard or soft, the swing grows until it is no number.
    model = tmp_path / "growing.xml"
    model.write_text(
        TWO_ARMS.format(BELT.format("")).replace("</mujoco>", "")
        + '<actuator><general joint="a" biastype="affine" biasprm="0.1 0 1e5"/></actuator></mujoco>'
    )
    study = harden_file(model, seconds=1.0)
    assert len(study.refusals) == 1
    assert "nothing shows what hardening does" in study.refusals[0]
    assert study.content is None
    # Control: without the motor it is hardened.
    model.write_text(TWO_ARMS.format(BELT.format("")))
    assert harden_file(model, seconds=0.1).refusals == ()


def test_curved_joint_equality_is_not_slowed_by_hardening() -> None:
    model = two_arms('<joint name="cam" joint1="a" joint2="b" solref="0.005 1" polycoef="0 1 0.3 0 0"/>')
    straight = two_arms('<joint name="cam" joint1="a" joint2="b" solref="0.005 1"/>')
    slowed = [
        next(e.value for e in recipes.recipe_for(one, active_closures(one)) if not e.scales)
        for one in (model, straight)
    ]
    assert slowed == [mujoco.mjtIntegrator.mjINT_RK4, 0.02]
    assert any("cam" in note and "velocity" in note for note in recipes.hardening_notes(model, active_closures(model)))
    assert recipes.hardening_notes(straight, active_closures(straight)) == ()
    hard, wide = apply_recipe(model, recipes.recipe_for(model, active_closures(model))), []
    for constant in (0.01, 0.02):
        hard.eq_solref[0, 0] = constant
        wide.append(opening_of(hard, closed_start(model)[0], 400, 4))
    assert np.log2(wide[1] / wide[0]) == pytest.approx(2.0, abs=0.2)


# -- models that were not written for conrod ---------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize(
    ("robot", "start", "seconds", "closures"),
    [("agility_cassie", ("--keyframe", "home"), 0.1, 4), ("robotiq_2f85", (), 0.2, 3)],
)
def test_robot_loops_are_hardened_and_its_model_is_unchanged(
    robot: str, start: tuple[str, ...], seconds: float, closures: int, tmp_path: Path
) -> None:
    menagerie = pytest.importorskip("mujoco_menagerie")
    try:
        model = Path(menagerie.get(robot).xml())
    except (menagerie.MenagerieError, OSError) as error:
        pytest.skip(f"the models of mujoco-menagerie cannot be downloaded here: {error}")
    text, given = model.read_bytes(), (str(model), "--seconds", str(seconds), "--json", "found.json")
    done = conrod("harden", *given, *start, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    before, after = json.loads((tmp_path / "found.json").read_text())["variants"]
    assert max(after["openings"]) < 1e-3 * max(before["openings"])
    assert len(before["openings"]) == closures
    done = conrod("lint", *given, cwd=tmp_path)
    assert done.returncode == 1, done.stderr
    findings = json.loads((tmp_path / "found.json").read_text())["findings"]
    assert "silent-reset" in {finding["rule"] for finding in findings}  # MuJoCo's default, which neither switches off
    assert model.read_bytes() == text


def test_recipe_clears_the_flag_that_makes_weights_unread(tmp_path: Path) -> None:
    path = tmp_path / "exact.xml"
    path.write_text(
        replace_once(TEXTS["saw"], "<flag ", '<flag diagexact="enable" '),
        encoding="utf-8",
    )
    found = harden_file(path, seconds=0.06)
    assert "model.opt.enableflags = 0" in found.lines
    names: dict[str, Any] = {}
    exec(found.lines, names)
    assert names["model"].opt.enableflags == 0
    before, after = (max(one.openings) for one in found.variants)
    assert after < 1e-2 * before


def test_drift_is_from_the_motion_at_a_step_of_zero() -> None:
    hard = mujoco.MjModel.from_xml_path(str(Path(__file__).parents[2] / "mjcf" / "saw-500rpm.xml"))
    hard.opt.integrator, hard.opt.timestep = mujoco.mjtIntegrator.mjINT_RK4, 1e-3
    hard = apply_recipe(hard, recipes.recipe_for(hard, active_closures(hard)))
    state, steps, every = closed_start(hard)[0], 100, 10
    first = run_finer(hard, state, steps, every)
    found = reference_motion(hard, first, state, steps, every)
    assert found.extrapolated
    fine = run_finer(hard, state, steps, every, 16, watched=False).centres
    off, runs_off = (float(np.abs(found.centres - one).max()) for one in (fine, first.centres))
    assert found.known_to < 0.1 * runs_off
    assert off <= found.known_to + runs_off / 16**4
    # Negative control: errors of order 1 are not extrapolated as if they were of order 4.
    hard.opt.integrator = mujoco.mjtIntegrator.mjINT_EULER
    assert not reference_motion(hard, run_finer(hard, state, steps, every), state, steps, every).extrapolated
