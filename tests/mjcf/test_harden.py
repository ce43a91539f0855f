"""Hardening a user's model closes its loops, on models that conrod did not make."""

from __future__ import annotations

import copy
import re
from dataclasses import replace
from functools import cache
from pathlib import Path

import mujoco
import numpy as np
import pytest
from exact_loops import ExactLoops
from legged import LEGGED, legged, opening_of

from conrod.cli.harden import print_hardened
from conrod.errors import InvalidInput
from conrod.exact.motion import Array
from conrod.mjcf.equalities import openings
from conrod.mjcf.harden.recipe import Recipe, active_closures, edited, recipe_for, to_know
from conrod.mjcf.harden.results import HardenedModel, Request
from conrod.mjcf.harden.runs import Pace, start_of, swing
from conrod.mjcf.harden.study import harden_file
from conrod.mjcf.lint.findings import Request as LintRequest
from conrod.mjcf.lint.linting import lint


@cache
def found(keyframe: str) -> HardenedModel:
    return harden_file(LEGGED, Request(keyframe=keyframe, seconds=0.15))


SAW = Path(__file__).parents[2] / "mjcf" / "saw-500rpm.xml"


def alone(recipe: Recipe) -> Recipe:
    """The weights, and nothing else."""
    return Recipe(recipe.factor, recipe.weights)


@cache
def saw(keyframe: str | None) -> HardenedModel:
    return harden_file(SAW, Request(keyframe, seconds=0.024, content=False))


def printed(found: HardenedModel, capsys: pytest.CaptureFixture[str]) -> dict[str, list[str]]:
    """Cells of the printed table by the heading of their row; of two rows the last."""
    print_hardened(found, None)
    rows = (re.split(r"\s{2,}", line.strip()) for line in capsys.readouterr().out.splitlines())
    return {heading: cells for heading, *cells in rows if cells}


# -- what it is for --------------------------------------------------------------------------------------------------


def test_hardening_closes_every_loop_by_orders_of_magnitude() -> None:
    before, after = found("swing").variants
    assert found("swing").loops == ("connect left-loop", "connect right-loop", "joint gait")
    assert all(now < 1e-5 * then for then, now in zip(before.openings, after.openings, strict=True))


def test_it_is_the_whole_recipe_that_keeps_the_motion() -> None:
    before, after = found("swing").variants
    assert after.drift < 1e-3 * before.drift
    # Control: it is the whole recipe that does it. Weights alone leave the loops to the step of Euler; softness stays
    # whatever the step, so that RK4 alone has no order at all.
    closures = active_closures(legged())
    start = start_of(legged(), Request("swing"))
    weights, soft = edited(legged(), alone(recipe_for(legged(), closures))), copy.copy(legged())
    soft.opt.integrator = mujoco.mjtIntegrator.mjINT_RK4
    for model, order in ((weights, 1.0), (soft, 0.0)):
        wide = [opening_of(model, start.state, Pace(50, 3 * k, 0.001 / k)) for k in (1, 4)]
        assert np.log(wide[0] / wide[1]) / np.log(4.0) == pytest.approx(order, abs=0.1)


def test_loops_stay_closed_when_feet_hit_the_floor_and_knees_their_stops() -> None:
    before, after = found("drop").variants
    assert before.broke == after.broke == ""
    assert max(after.openings) < 1e-3 * max(before.openings)


def test_the_hardened_motion_is_that_of_loops_closed_by_lagrange_multipliers() -> None:
    # An independent judge: neither MuJoCo's solver nor any regularisation is in it.
    state = start_of(legged(), Request("swing")).state
    pace = Pace(5, 20, 0.001)
    exact = exact_points(legged(), state, pace)
    recipe = recipe_for(legged(), active_closures(legged()))
    hard, soft = (swing(model, state, pace, ()).points for model in (edited(legged(), recipe), legged()))
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


@pytest.mark.parametrize(
    ("solimp", "factor"), [("", 9e-9), ('solimp="0.9999 0.9999 0.001"', 1e-5)], ids=["stock", "stiff"]
)
def test_what_is_left_of_the_regularisation_decides_and_neither_too_much_nor_too_little_is_best(
    solimp: str, factor: float
) -> None:
    model = mujoco.MjModel.from_xml_string(PRESS.format(solimp))
    closures = active_closures(model)
    state = start_of(model, Request()).state
    pace = Pace(10, 30, 0.001)
    exact = exact_points(model, state, pace)
    chosen = alone(recipe_for(model, closures))
    assert chosen.factor == pytest.approx(factor, rel=2e-3)
    errors = {}
    for share in (1e5, 1.0, 1e-5):
        recipe = replace(chosen, factor=chosen.factor * share)
        errors[share] = float(np.abs(swing(edited(model, recipe), state, pace, ()).points - exact).max())
    assert errors[1.0] < 1e-2 * errors[1e5]
    assert errors[1.0] < 1e-2 * errors[1e-5]


def test_only_what_the_loops_are_held_by_hardens() -> None:
    model = legged()
    recipe = recipe_for(model, active_closures(model))
    hard = edited(model, recipe)
    held = {"left-shank", "left-rod", "right-shank", "right-rod"}
    for body in range(1, model.nbody):
        name = mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_BODY, body)
        ratio = hard.body_invweight0[body] / model.body_invweight0[body]
        assert ratio == pytest.approx(recipe.factor if name in held else 1.0)
    hips = [model.joint("left-hip").dofadr[0], model.joint("right-hip").dofadr[0]]
    changed = np.flatnonzero(hard.dof_invweight0 != model.dof_invweight0)
    assert sorted(changed.tolist()) == sorted(hips)
    assert to_know(model, active_closures(model)) == ()


# -- start, run, figures ---------------------------------------------------------------------------------------------


def test_a_start_that_leaves_loops_open_is_closed_and_told() -> None:
    lever = 'name="left-lever" pos="-0.08 {} 0{}"'
    aside, apart = (
        mujoco.MjModel.from_xml_string(LEGGED.read_text().replace(lever.format("0.05", ""), lever.format(*place)))
        for place in (("0.05", ".002"), ("3", ""))
    )
    closures = active_closures(aside)
    start = start_of(aside, Request("swing"))
    assert start.given == pytest.approx(0.002)
    assert start.closed
    first = swing(aside, start.state, Pace(1, 1, 0.001), closures).openings[0]
    assert first.max() < 1e-12
    # One that no pose can close is left as it is.
    assert not start_of(apart, Request("swing")).closed


def test_a_weld_is_open_by_its_place_or_by_its_turn_at_an_extent() -> None:
    model = mujoco.MjModel.from_xml_string(
        '<mujoco><worldbody><body name="held"><freejoint/><geom size="0.05"/></body></worldbody>'
        '<equality><weld name="grip" body1="held" torquescale="0.5"/></equality></mujoco>'
    )
    data = mujoco.MjData(model)
    data.qpos[0] = 0.01
    mujoco.mju_axisAngle2Quat(data.qpos[3:], np.array([0.0, 0.0, 1.0]), 0.3)
    mujoco.mj_fwdPosition(model, data)
    assert openings(model, data, 0.0) == pytest.approx([0.01])
    assert openings(model, data, 0.2) == pytest.approx([0.2 * 2.0 * np.sin(0.15)])


# -- where they start ------------------------------------------------------------------------------------------------


def test_runs_start_from_the_first_keyframe_as_those_of_lint_do() -> None:
    assert saw(None).start == "keyframe start"
    assert saw(None).travel == pytest.approx(0.1, rel=0.5)
    assert f"from {saw(None).start}" in lint(SAW, LintRequest(seconds=0.0012, ignored=())).run


# -- where they show nothing -----------------------------------------------------------------------------------------


def test_a_machine_that_stands_has_no_drift_below_what_its_reference_is_known_to(
    capsys: pytest.CaptureFixture[str],
) -> None:
    stands = saw("qpos0")
    assert any("nothing moves" in note for note in stands.warnings)
    table = printed(stands, capsys)
    assert table["drift from the reference [mm]"][1] == "-"
    # Control: one that moves has them.
    assert not any("nothing moves" in note for note in saw(None).warnings)
    table = printed(saw(None), capsys)
    assert "-" not in table["drift from the reference [mm]"]


# -- actuators ---------------------------------------------------------------------------------------------------------

SERVO = '<actuator><velocity name="motor" kv="30" joint="crank"/></actuator></mujoco>'


def actuated() -> str:
    """The saw with stock closures and a servo on its crank in place of the flywheel; nothing moves at first."""
    text = re.sub(r' solref="0\.00096.*?/>', "/>", SAW.read_text().replace(' armature="1e+13"', ""))
    return re.sub(r' qvel="[^"]*"', "", text).replace("</mujoco>", SERVO)


def test_an_actuated_model_is_measured_in_the_motion_that_its_controls_command(tmp_path: Path) -> None:
    (tmp_path / "saw.xml").write_text(actuated())
    stands, driven = (
        harden_file(tmp_path / "saw.xml", Request(seconds=0.003, content=False, controls=controls))
        for controls in ((), (("motor", 52.36),))
    )
    assert driven.start == "keyframe start with motor = 52.36"
    assert driven.travel > 50 * stands.travel
    with pytest.raises(InvalidInput, match="unknown actuator 'moter': did you mean 'motor'"):
        harden_file(tmp_path / "saw.xml", Request(controls=(("moter", 1.0),)))
