"""Models that hardening would do harm to, or nothing."""

from __future__ import annotations

import copy
from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np
import pytest
from legged import LEGGED, legged, opening_of

from conrod.errors import InvalidInput
from conrod.mjcf.equalities import openings
from conrod.mjcf.harden.recipe import (
    Recipe,
    active_closures,
    compliance,
    edited,
    nothing_to_do,
    recipe_for,
    soft_on_purpose,
    to_know,
)
from conrod.mjcf.harden.results import Request
from conrod.mjcf.harden.runs import Pace, start_of
from conrod.mjcf.harden.study import harden_file

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


# -- where it would do harm ------------------------------------------------------------------------------------------

BELT = '<joint name="belt" joint1="a" joint2="b" {}/>'


@pytest.mark.parametrize(
    ("equality", "why"),
    [
        (BELT.format('solref="0.1 1"'), "softer than MuJoCo's stock"),
        (BELT.format('solref="-200 -5"'), "given as such"),
        ('<weld name="belt" body1="hand" body2="held"/>', "mocap"),
        # A stock closure, or one slow but stiff, is not.
        *((BELT.format(stiff), "") for stiff in ("", 'solref="0.1 1" solimp="0.9999 0.9999 0.001"')),
    ],
)
def test_a_closure_that_is_meant_to_give_way_is_refused_by_name(equality: str, why: str) -> None:
    model = two_arms(equality)
    reasons = soft_on_purpose(model, active_closures(model))
    assert [reason.startswith("belt: ") and why in reason for reason in reasons] == [True] * bool(why)


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
    (opening,) = openings(model, data, 0.0)
    assert opening == pytest.approx(9.81 * compliance(solref, solimp, 0.0), rel=1e-6)


def test_what_cannot_be_hardened_says_why() -> None:
    assert nothing_to_do(legged(), active_closures(legged())) == ""
    assert "no closed loop" in nothing_to_do(two_arms(""), ())
    inactive = two_arms(BELT.format('active="false"'))
    assert "belt" in nothing_to_do(inactive, active_closures(inactive))
    switched_off = copy.copy(legged())
    switched_off.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_EQUALITY)
    assert active_closures(switched_off) == ()


def test_set_const_undoes_it_and_a_hardened_model_is_told_from_one_that_is_not() -> None:
    closures = active_closures(legged())
    recipe = recipe_for(legged(), closures)
    model = edited(legged(), recipe)
    assert "hardened already" in nothing_to_do(model, closures)
    mujoco.mj_setConst(model, mujoco.MjData(model))
    np.testing.assert_allclose(recipe.weights.values(model), recipe.weights.values(legged()), rtol=1e-9)
    assert nothing_to_do(model, closures) == ""
    state = start_of(legged(), Request("swing")).state
    pace = Pace(50, 2, 0.001)
    undone, hard = opening_of(model, state, pace), opening_of(edited(legged(), recipe), state, pace)
    assert hard < 1e-5 * undone


def test_loops_that_open_more_when_hard_are_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    # Euler opens the loops in every step, and slow feedback lets it: a stiff model is better as it is.
    setting = 'solref="0.002 1" solimp="0.99 0.99 0.001"'
    text = LEGGED.read_text()
    for tag in ("<connect", '<joint name="gait"'):
        text = text.replace(tag, f"{tag} {setting}")
    model, request = tmp_path / "stiff.xml", Request(keyframe="swing", seconds=0.05)
    model.write_text(text)
    assert harden_file(model, request).refusals == ()

    def slow(model: mujoco.MjModel, recipe: Recipe) -> mujoco.MjModel:
        constants = tuple((index, 0.1) for index in range(3))
        return edited(model, replace(recipe, runge_kutta=False, time_constants=constants))

    monkeypatch.setattr("conrod.mjcf.harden.study.edited", slow)
    study, forced = (harden_file(model, replace(request, force=force)) for force in (False, True))
    (reason,) = study.refusals
    assert "its loops open more" in reason
    assert (study.content, forced.refusals) == (None, ())
    assert reason == f"{forced.warnings[0]}; --force hardens it all the same"
    assert forced.content is not None


def test_a_model_that_breaks_off_either_way_is_refused_for_nothing_shows_that_it_is_any_better(tmp_path: Path) -> None:
    # A motor whose feedback feeds: hard or soft, the swing grows until it is no number.
    model = tmp_path / "growing.xml"
    model.write_text(
        TWO_ARMS.format(BELT.format("")).replace("</mujoco>", "")
        + '<actuator><general joint="a" biastype="affine" biasprm="0.1 0 1e5"/></actuator></mujoco>'
    )
    study = harden_file(model, Request(seconds=1.0))
    assert len(study.refusals) == 1
    assert "nothing shows what hardening does" in study.refusals[0]
    assert study.content is None
    # Control: without the motor it is hardened.
    model.write_text(TWO_ARMS.format(BELT.format("")))
    assert harden_file(model, Request(seconds=0.1)).refusals == ()


def test_a_number_that_is_none_is_refused_by_its_place(tmp_path: Path) -> None:
    model = tmp_path / "none.xml"
    model.write_text(TWO_ARMS.format(BELT.format('polycoef="nan 1 0 0 0"')))
    with pytest.raises(InvalidInput, match=r"none\.xml: eq_data is not finite"):
        harden_file(model, Request())


def test_a_curved_joint_equality_is_not_slowed_for_it_opens_with_the_square_of_its_time_constant() -> None:
    model = two_arms('<joint name="cam" joint1="a" joint2="b" solref="0.005 1" polycoef="0 1 0.3 0 0"/>')
    straight = two_arms('<joint name="cam" joint1="a" joint2="b" solref="0.005 1"/>')
    assert recipe_for(model, active_closures(model)).time_constants == ()
    assert recipe_for(straight, active_closures(straight)).time_constants == ((0, 0.02),)
    assert any("cam" in note and "velocity" in note for note in to_know(model, active_closures(model)))
    assert to_know(straight, active_closures(straight)) == ()
    recipe = recipe_for(model, active_closures(model))
    state = start_of(model, Request()).state
    wide = [
        opening_of(edited(model, replace(recipe, time_constants=((0, constant),))), state, Pace(100, 4, 0.002))
        for constant in (0.01, 0.02)
    ]
    assert np.log2(wide[1] / wide[0]) == pytest.approx(2.0, abs=0.2)
