"""What is said of hardening: recipes as Python, objections, notes and figures, in all their words."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest

from conrod.comparison.other_forces import OtherForce
from conrod.engines.mujoco import compat
from conrod.errors import InvalidInput
from conrod.mjcf.edits import apply_recipe
from conrod.mjcf.hardenable import active_closures, hardenable_closures
from conrod.mjcf.runs import STATE
from conrod.models.harden import recipe as recipes
from conrod.models.harden import study
from conrod.models.harden.recipe import Closure, Edit
from conrod.models.harden.results import HardenedModel, HardeningRun
from conrod.models.harden.study import closed_start, compare_runs, harden_file, run_finer, run_steps

ARMS = """<mujoco><compiler angle="radian"/><option timestep="0.002" gravity="0 0 0" {option}/><worldbody>
  <body name="a"><joint name="a" axis="0 1 0"/><geom size="0.05" pos="0.3 0 0" mass="1"/><site name="s" pos="0.3 0 0"/>
  </body>
  <body name="b" pos="0 0.5 0"><joint name="b" axis="0 1 0"/><geom size="0.05" pos="0.3 0 0" mass="1"/>
    <site name="t" pos="0.3 0 0"/></body>
  <body name="hand" mocap="true" pos="0 1 0"/><body name="held" pos="0 1 0"><freejoint/><geom size="0.05"/></body>
</worldbody><tendon><fixed name="f"><joint joint="a" coef="1"/></fixed><fixed name="g"><joint joint="b" coef="1"/>
  </fixed><spatial name="r"><site site="s"/><site site="t"/></spatial></tendon>
<equality>{equality}</equality>{more}</mujoco>"""
BELT, GRIP = '<joint name="belt" joint1="a" joint2="b"/>', '<weld name="grip" body1="hand" body2="held"/>'


def arms(equality: str = BELT, more: str = "", option: str = "") -> mujoco.MjModel:
    return mujoco.MjModel.from_xml_string(ARMS.format(equality=equality, more=more, option=option))


def file_of(folder: Path, equality: str = BELT, more: str = "", option: str = "") -> Path:
    path = folder / "arms.xml"
    path.write_text(ARMS.format(equality=equality, more=more, option=option), encoding="utf-8")
    return path


# -- recipes -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("edit", "line"), [
    (Edit("dof_invweight0", 1e-9, [0, 3], ["a", "b"]), "model.dof_invweight0[[0, 3]] *= 1e-09  # a, b"),
    (Edit("eq_solref", 0.02, [1], ["be\nlt"]), "model.eq_solref[[1], 0] = 0.02  # be lt"),
    (Edit("integrator", mujoco.mjtIntegrator.mjINT_RK4),
     "model.opt.integrator = mujoco.mjtIntegrator.mjINT_RK4"),
    (Edit("enableflags", 2), "model.opt.enableflags = 2"),
])  # fmt: skip
def test_edit_has_a_line_of_python_with_the_same_effect(edit: Edit, line: str) -> None:
    assert edit.line == line
    pair = BELT + '<joint name="other" joint1="a" joint2="b" polycoef="0 2 0 0 0"/>'
    model, other = arms(pair), arms(pair)
    edit.make(model)
    exec(line, {"mujoco": mujoco, "model": other})
    for name in ("dof_invweight0", "eq_solref"):
        assert getattr(model, name).tolist() == getattr(other, name).tolist()
    assert str(model.opt) == str(other.opt)
    stock = arms(pair)
    if edit.scales:
        assert model.dof_invweight0[0] == 1e-9 * stock.dof_invweight0[0]
        assert model.dof_invweight0[1] == stock.dof_invweight0[1]


def test_numbers_behind_the_coefficients_bend_no_closure() -> None:
    model = arms()
    for place, curved in ((5, False), (4, True)):
        model.eq_data[0, place] = 1.0
        assert active_closures(model)[0].curved is curved


def test_recipe_lines_load_the_file_and_name_when_to_repeat() -> None:
    lines = recipes.python_lines((Edit("enableflags", 0),), Path("/models/arm's.xml"))
    assert lines == (
        'import mujoco\n\nmodel = mujoco.MjModel.from_xml_path("/models/arm\'s.xml")\n'
        "# again, after mj_setConst has computed these anew:\nmodel.opt.enableflags = 0\n"
    )
    assert "from_binary_path('/models/arm.MJB')" in recipes.python_lines((), Path("/models/arm.MJB"))


def test_closures_have_weights_of_bodies_joints_or_tendons() -> None:
    curved, straight = 'polycoef="0 1 0.5 0 0"', 'polycoef="0.5 2 0 0 0"'
    model = arms(
        '<connect name="c" site1="s" site2="t"/><weld name="w" body1="b"/>'
        f'<joint name="j" joint1="a" joint2="b" {curved}/>'
        f'<joint name="k" joint1="b" {curved}/><tendon name="x" tendon1="f" tendon2="g" {straight}/>'
        f'<tendon name="y" tendon1="f" tendon2="g" {curved}/><tendon name="z" tendon1="r"/>'
        f'<joint name="off" joint1="a" active="false"/>{GRIP}'
    )
    found = active_closures(model)
    assert found == (
        Closure(0, "c", "connect", "body", (1, 2)), Closure(1, "w", "weld", "body", (2, 0)),
        Closure(2, "j", "joint", "dof", (0, 1), curved=True), Closure(3, "k", "joint", "dof", (1,)),
        Closure(4, "x", "tendon", "tendon", (0, 1)), Closure(5, "y", "tendon", "tendon", (0, 1), curved=True),
        Closure(6, "z", "tendon", "tendon", (2,), curved=True),
    )  # fmt: skip
    assert [type(one.curved) for one in found] == [bool] * 7
    assert [one.name for one in hardenable_closures(model)][-1] == "grip"
    # The world has no weight.
    weights = recipes.inverse_weights(model, found)
    assert weights == pytest.approx(np.concatenate([
        model.body_invweight0[[1, 2]].ravel(), model.dof_invweight0[[0, 1]], model.tendon_invweight0[[0, 1, 2]],
    ]))  # fmt: skip
    assert recipes.inverse_weights(model, ()).tolist() == []
    for flag in ("equality", "constraint"):
        model = arms(BELT + GRIP)
        model.opt.disableflags |= int(getattr(mujoco.mjtDisableBit, f"mjDSBL_{flag.upper()}"))
        assert hardenable_closures(model) == ()


def test_a_recipe_has_weights_time_constants_and_options() -> None:
    fast = BELT.replace("/>", ' solref="0.004 1"/>')
    model = arms(fast + GRIP, option='solver="CG"')
    (belt,) = active_closures(model)
    weights, slow, integrator, solver = recipes.recipe_for(model, (belt,))
    # 1e-9 d / (1 - d) at d = 0.9, and ten steps of 2 ms.
    assert weights == Edit("dof_invweight0", 9e-9, [0, 1], ["a", "b"])
    assert slow == Edit("eq_solref", 0.02, [0], ["belt"])
    assert integrator == Edit("integrator", mujoco.mjtIntegrator.mjINT_RK4)
    assert solver == Edit("solver", mujoco.mjtSolver.mjSOL_NEWTON)
    # What is slow enough, or has no time constant, is left as it is.
    for solref in ("0.02 1", "-200 -5"):
        calm = arms(BELT.replace("/>", f' solref="{solref}"/>'), option='integrator="RK4"')
        assert [one.array for one in recipes.recipe_for(calm, active_closures(calm))] == ["dof_invweight0"]
    grip = recipes.recipe_for(model, hardenable_closures(model)[1:])
    assert grip[0] == Edit("body_invweight0", 9e-9, [3, 4], ["hand", "held"])
    changed = apply_recipe(model, (weights,))
    assert changed.dof_invweight0[0] == pytest.approx(9e-9 * model.dof_invweight0[0])
    exact = compat.enable_bit("DIAGEXACT")
    if exact:
        model.opt.enableflags |= exact | int(mujoco.mjtEnableBit.mjENBL_ENERGY)
        assert recipes.recipe_for(model, (belt,))[-1] == Edit("enableflags", int(mujoco.mjtEnableBit.mjENBL_ENERGY))


# -- softness ----------------------------------------------------------------------------------------------------------


def test_an_impedance_is_that_of_a_closed_constraint() -> None:
    known: dict[tuple[float, ...], float] = {
        (0.9, 0.95, 0.001): 0.9, (0.9, 0.95, 0.0): 0.925, (0.0, 1.0, 0.0): 0.5, (1.0, 1.0, 1.0): 0.9999,
        (0.0, 0.5, 1.0): 1e-4,
    }  # fmt: skip
    for solimp, found in known.items():
        assert recipes.impedance(np.array([*solimp, 0.5, 2.0])) == pytest.approx(found, rel=1e-12)


def test_compliance_is_proportional_to_time_constant_squared() -> None:
    solimp = np.array([0.8, 0.9, 0.001, 0.5, 2.0])
    # 0.2 / 0.64 x (0.9 x 0.02 x 1.5)^2
    assert recipes.compliance(np.array([0.02, 1.5]), solimp, 0.0) == pytest.approx(0.3125 * 0.027**2)
    assert recipes.compliance(np.array([0.02, 1.5]), solimp, 0.04) == pytest.approx(0.3125 * 0.054**2)


@pytest.mark.parametrize(("constant", "flag", "softer"), [
    (0.02, "", False), (0.0201, "", True), (0.001, "", False), (0.0201, "refsafe", True),
])  # fmt: skip
def test_softer_than_stock_is_a_longer_time_constant(constant: float, flag: str, softer: bool) -> None:
    more = f'<option><flag {flag}="disable"/></option>' if flag else ""
    model = arms(BELT.replace("/>", f' solref="{constant} 1"/>'), more)
    assert recipes.softer_than_stock(model, 0) is softer
    # Where MuJoCo raises both time constants to two steps of 0.1 s they are alike.
    model.opt.timestep = 0.1
    assert recipes.softer_than_stock(model, 0) is bool(flag and softer)


def test_reasons_to_leave_closures_soft_name_them() -> None:
    model = arms(
        '<joint name="p" joint1="a" solref="-200 -5"/><joint name="q" joint1="b" solref="0.1 1"/>'
        '<joint name="r" joint1="a" joint2="b" solref="0 1"/><joint name="s" joint1="a" joint2="b"/>'
    )
    model.eq_solref[2] = 0.0, 1.0
    assert recipes.soft_on_purpose(model, active_closures(model)) == (
        "p, r: stiffness and damping are given as such (solref <= 0), so meant to give way",
        "q: softer than MuJoCo's stock setting, so meant to give way",
    )
    assert recipes.soft_on_purpose(arms(), active_closures(arms())) == ()


CURVED = '<joint name="cam" joint1="a" joint2="b" polycoef="0 1 0.5 0 0"/>'


@pytest.mark.parametrize(("equality", "notes"), [
    (BELT, ()),
    (CURVED, ("cam: MuJoCo's acceleration of it lacks the part of the velocity: hardened or not, it opens with the "
              "square of its time constant, so that is kept; the reference has this error too, so the drift does not "
              "show it",)),
    (BELT + BELT.replace("belt", "off").replace("/>", ' active="false"/>'),
     ("off: not active at the start, or of a flex, so not hardened",)),
    (BELT + GRIP, ("grip is a handle: it drags held after the mocap body hand; so not hardened",)),
    (GRIP, ()),
])  # fmt: skip
def test_notes_say_what_stays_soft(equality: str, notes: tuple[str, ...]) -> None:
    model = arms(equality)
    assert recipes.hardening_notes(model, active_closures(model)) == notes


@pytest.mark.parametrize(("equality", "reason"), [
    (BELT, ""),
    (GRIP, "grip is a handle: it drags held after the mocap body hand; nothing to harden"),
    ("", "it has no closed loop: nothing to harden (joints of its tree are exact as they are)"),
    (BELT.replace("/>", ' active="false"/>'), "none of its equality constraints is active at the start: belt"),
])  # fmt: skip
def test_what_cannot_be_hardened_is_refused_with_its_reason(equality: str, reason: str) -> None:
    model = arms(equality)
    assert recipes.refusal_reason(model, active_closures(model)) == reason


@pytest.mark.parametrize(("share", "reason"), [
    (0.51, ""), (0.49, "it is hardened already: its weights are 4.9e-01 of what they were"),
    (1e-9, "it is hardened already: its weights are 1.0e-09 of what they were"),
])  # fmt: skip
def test_weights_of_less_than_half_were_scaled(share: float, reason: str) -> None:
    model = arms()
    model.dof_invweight0[:] *= share
    assert recipes.refusal_reason(model, active_closures(model)) == reason


def test_what_has_no_weight_has_nothing_to_harden() -> None:
    model = arms('<weld name="w" body1="world" body2="hand"/>')
    fixed = (Closure(0, "w", "weld", "body", (0, 3)),)
    assert recipes.refusal_reason(model, fixed) == "what its closures hold has no inverse weight: nothing to harden"


# -- harm, doubts and figures ------------------------------------------------------------------------------------------

FOUND = HardenedModel("m.xml", "4.0.0", size=2.0, travel=1.0)
RUN = HardeningRun("as it is", 100, "", (1e-4, 2e-4), 1e-3)


@pytest.mark.parametrize(("before", "after", "harm"), [
    (RUN, replace(RUN, openings=(1e-7, 4e-4)), ""),
    (RUN, replace(RUN, openings=(1e-7, 4.1e-4)),
     "its loops open more, 4.1e-01 mm and as it is 2.0e-01 mm: a smaller step of the model may help"),
    (replace(RUN, openings=(0.0, 0.0)), replace(RUN, openings=(2e-9, 0.0)), ""),  # 1e-9 of its size
    (replace(RUN, openings=(0.0, 0.0)), replace(RUN, openings=(2.1e-9, 0.0)),
     "its loops open more, 2.1e-06 mm and as it is 0.0e+00 mm: a smaller step of the model may help"),
    (replace(RUN, broke="bad qpos", openings=None), replace(RUN, openings=(1.0, 1.0)), ""),
    (RUN, replace(RUN, steps=7, broke="bad qacc", openings=None),
     "the run breaks off hardened after 7 steps (bad qacc), and as it is it does not: "
     "a smaller step of the model may help"),
    (replace(RUN, steps=5, broke="bad qpos"), replace(RUN, steps=7, broke="bad qacc"),
     "the run breaks off hardened after 7 steps (bad qacc), and as it is after 5 (bad qpos): "
     "nothing shows what hardening does"),
])  # fmt: skip
def test_harm_is_a_run_that_breaks_off_or_loops_that_open_more(
    before: HardeningRun, after: HardeningRun, harm: str
) -> None:
    assert study._harm_reason(FOUND, before, after) == harm


def test_figures_are_doubted_when_loops_open_or_nothing_moves() -> None:
    assert list(study._doubts(FOUND)) == []
    assert list(study._doubts(replace(FOUND, travel=None))) == []
    assert list(study._doubts(replace(FOUND, travel=2e-9))) == []
    assert list(study._doubts(replace(FOUND, start_closed=False, travel=1.9e-9))) == [
        "no pose near the start closes the loops: the runs start with them open",
        "nothing moves in these runs (travel 1.9e-09 m): they show how far the loops open at rest, and nothing else; "
        "--keyframe KEY starts others, --ctrl NAME=VALUE commands a motion",
    ]
    acting = (OtherForce("lacking acceleration", "p", 1.0, "m/s²"), OtherForce("limit", "joint j", 5.0, "N m"))
    (said,) = study._acting_words(replace(FOUND, acting=acting))
    assert said == "In these runs, what acts besides its loops: the limit of joint j (up to 5 N m)."


@pytest.mark.parametrize(("seconds", "steps", "every"), [
    (0.04, 20, 1), (0.041, 21, 1), (1.0, 500, 1), (1.002, 502, 2), (2.5, 1251, 3), (400.0, 200000, 400),
])  # fmt: skip
def test_a_run_has_whole_samples_of_its_steps(seconds: float, steps: int, every: int) -> None:
    assert run_steps(arms(), seconds) == (steps, every)
    for bad in (0.0399, 400.1, float("nan")):
        with pytest.raises(InvalidInput) as told:
            run_steps(arms(), bad)
        assert str(told.value) == (f"--seconds {bad:g} is out of range: 0.04 to 400 at the model's step of 0.002 s")


def test_a_run_of_no_given_length_fits_the_step_of_the_model() -> None:
    model = arms()
    assert run_steps(model) == (500, 1)  # a second
    model.opt.timestep = 0.1
    assert run_steps(model) == (20, 1)  # a second would be too few steps


KEYS = '<keyframe><key name="k" qpos="0.02 0 0 1 0 1 0 0 0" qvel="1 0 0 0 0 0 0 0"/></keyframe>'
MOTOR = '<actuator><motor name="m" joint="a"/></actuator>'


def test_a_start_is_closed_in_its_pose_and_its_rates() -> None:
    model = arms(more=KEYS + MOTOR)
    state, start = closed_start(model, "k", (("m", 0.5),))
    extent = float(model.stat.extent)
    assert start == {"start": "keyframe k with m = 0.5", "start_opening": pytest.approx(0.02 * extent),
                     "start_closed": True}  # fmt: skip
    data = mujoco.MjData(model)
    mujoco.mj_setState(model, data, state, STATE)
    # Both arms go half of the way, and take half of the rate.
    assert data.qpos[:2] == pytest.approx([0.01, 0.01])
    assert data.qvel[:2] == pytest.approx([0.5, 0.5])
    assert data.ctrl.tolist() == [0.5]
    assert closed_start(arms(), None)[1]["start"] == "its own pose"


def test_a_closure_that_says_the_same_but_for_rounding_is_one() -> None:
    again = '<joint name="again" joint1="a" joint2="b" polycoef="0 1.00000000001 0 0 0"/>'
    model = arms(BELT + again, KEYS.replace("0.02", "0"))
    state, start = closed_start(model, "k")
    assert start["start_closed"]
    data = mujoco.MjData(model)
    mujoco.mj_setState(model, data, state, STATE)
    # As if there were one: both together would stop the arms.
    assert data.qvel[:2] == pytest.approx([0.5, 0.5])


def test_runs_are_compared_as_they_are_and_hardened(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(study, "time_stepper_pair", lambda one, other: (one, other))
    model = arms(more=KEYS + MOTOR)
    hard = apply_recipe(model, recipes.recipe_for(model, active_closures(model)))
    state, _ = closed_start(model, "k", (("m", 0.5),))
    found = compare_runs(model, hard, state, 20, 2, [0])
    assert (found["size"], found["timestep"], found["seconds"]) == (float(model.stat.extent), 0.002, 0.04)
    before, after = found["variants"]
    assert (before.name, before.steps, before.broke) == ("as it is", 20, "")
    assert (after.name, after.steps, after.broke) == ("hardened", 20, "")
    assert after.openings[0] < 1e-3 * before.openings[0]
    assert after.drift < before.drift
    # Half of a force of 0.5 N m on one arm of two, 0.3 m long, from 0.5 rad/s.
    assert found["travel"] == pytest.approx(0.3 * 0.5 * 0.04, rel=0.2)
    assert found["reference_known_to"] >= np.finfo(float).eps * float(model.stat.extent)
    assert [one.name for one in found["acting"]] == ["actuator m"]
    one, other = found["cost"]
    assert one is not other
    # Of a run that breaks off there is no cost, drift or travel.
    model.dof_damping[:] = -1e12
    assert compare_runs(model, hard, state, 20, 2, [0])["cost"] is None
    assert compare_runs(hard, model, state, 20, 2, [0])["cost"] is None
    broken = compare_runs(model, model, state, 20, 2, [0])
    assert (broken["cost"], broken["travel"], broken["reference_known_to"]) == (None, None, None)
    assert broken["variants"][0].drift is None
    assert broken["variants"][0].broke


def test_a_finer_run_has_the_same_samples() -> None:
    model = arms(more=KEYS)
    state, _ = closed_start(model, "k")
    coarse, fine = run_finer(model, state, 20, 2), run_finer(model, state, 20, 2, 4)
    assert (coarse.steps, fine.steps, len(coarse.states), len(fine.states)) == (20, 80, 11, 11)
    assert np.abs(coarse.centres - fine.centres).max() < 1e-3
    assert model.opt.timestep == 0.002


def test_a_hardened_file_has_its_path_factor_lines_and_model(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(study, "time_stepper_pair", lambda *_: None)
    monkeypatch.chdir(tmp_path)
    path = file_of(tmp_path, BELT.replace("/>", ' solref="0.004 1"/>') + GRIP, KEYS + MOTOR)
    asked: dict[str, Any] = {"keyframe": "k", "seconds": 0.05, "controls": (("m", 0.5),)}
    found = harden_file(Path("arms.xml"), **asked)
    assert (found.path, found.mujoco) == ("arms.xml", mujoco.__version__)
    assert (found.factor, found.loops, found.refusals) == (9e-9, ("joint belt",), ())
    assert found.start == "keyframe k with m = 0.5"
    assert found.warnings == (
        "grip is a handle: it drags held after the mocap body hand; so not hardened",
        "In these runs, what acts besides its loops: the force of actuator m.",
    )
    assert str(path) in found.lines
    assert found.content is not None
    (tmp_path / "hard.mjb").write_bytes(found.content)
    hard = mujoco.MjModel.from_binary_path(str(tmp_path / "hard.mjb"))
    assert hard.dof_invweight0[:2] == pytest.approx(9e-9 * arms().dof_invweight0[:2])
    assert harden_file(Path("arms.xml"), content=False, **asked).content is None
    refused = harden_file(file_of(tmp_path, GRIP), seconds=0.05)
    assert refused.path == str(tmp_path / "arms.xml")
    assert refused.refusals == (
        "grip is a handle: it drags held after the mocap body hand; nothing to harden; --force hardens it all the same",
    )
    soft = BELT.replace("/>", ' solref="0.1 1"/>')
    words = "belt: softer than MuJoCo's stock setting, so meant to give way"
    assert harden_file(file_of(tmp_path, soft), seconds=0.05).refusals == (f"{words}; --force hardens it all the same",)
    forced = harden_file(file_of(tmp_path, soft), seconds=0.05, force=True)
    assert forced.refusals == ()
    assert forced.warnings[0] == words
