"""Driven runs are judged, and settings, limits and contacts said, each figure against one known beforehand."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import mujoco
import numpy as np
import pytest
from four_bars import GRASHOF, driven, four_bar, start_angles

from conrod.comparison.trajectory import Outcome
from conrod.engines.mujoco.compat import disable_bit
from conrod.errors import InvalidInput
from conrod.exact.motion import Array
from conrod.exact.space import SpatialTree
from conrod.exact.space.mobility import SpatialForces
from conrod.exact.space.motion import DrivenTree, SpatialMotion
from conrod.mjcf import driven_runs
from conrod.mjcf.driven_runs import (
    is_on_other_branch,
    judge_run,
    shipped_run,
    tendons_beyond_limits,
    with_settings,
)
from conrod.mjcf.driving import (
    LoopRecording,
    break_off_reason,
    closure_rows,
    closure_violations,
    driven_run,
    site_points,
    widest_opening_words,
)
from conrod.mjcf.loop_results import LoopRun
from conrod.mjcf.reading import tree_of
from conrod.mjcf.runs import STATE, break_reason, looping_stepper, run, state_of, user_model_errors

TIMES = np.linspace(0.0, 0.5, 11)
TRAVEL = 0.2


@cache
def machine() -> DrivenTree:
    return driven(four_bar(), {"crank": "60rpm"})


@cache
def exact() -> SpatialMotion:
    return machine().motion(TIMES)


def recording(**other: Any) -> LoopRecording:
    """A run that is the exact motion, of the points B and A."""
    motion = exact()
    points = {
        name: np.array([getattr(motion.points[name], q) for q in ("position", "velocity", "acceleration")])
        for name in ("B", "A")
    }
    made = LoopRecording(
        TIMES, motion.coordinates, motion.rates[0], motion.rates[1], points, {"pin": np.full(11, 1e-4)}, {}, {},
        Outcome.COMPLETED, "",
    )  # fmt: skip
    return replace(made, **other)


def judged(made: LoopRecording, forces: SpatialForces | None = None) -> LoopRun:
    return judge_run("tuned", 0.05, made, exact(), machine(), forces, TRAVEL)


def off(name: str, quantity: int, sample: int, by: tuple[float, float, float]) -> LoopRecording:
    made = recording()
    points = {point: values.copy() for point, values in made.points.items()}
    points[name][quantity, sample] += by
    return replace(made, points=points)


# -- judging -----------------------------------------------------------------------------------------------------------


def test_a_run_that_is_exact_has_no_errors() -> None:
    found = judged(recording())
    assert found == LoopRun("tuned", 0.05, Outcome.COMPLETED, errors=found.errors, worst="B", gap=1e-4)
    assert found.errors == {"position": 0.0, "velocity": 0.0, "acceleration": 0.0}


def test_errors_are_the_largest_distances_over_all_points() -> None:
    for quantity, name in enumerate(("position", "velocity", "acceleration")):
        found = judged(off("A", quantity, 4, (0.002, 0.003, 0.006)))
        assert found.errors == {"position": 0.0, "velocity": 0.0, "acceleration": 0.0} | {name: pytest.approx(0.007)}
        assert found.worst == ("A" if name == "position" else "B")
    assert (found.drives, found.reactions) == ({}, {})


def test_a_run_that_did_not_complete_or_opened_has_no_errors() -> None:
    gap = {"pin": np.array([0.0, 3e-4, np.nan]), "other": np.array([0.0, 2e-4, 0.0])}
    found = judged(recording(outcome=Outcome.DIVERGED, reason="not finite at 0.1 s", violations=gap))
    assert found == LoopRun("tuned", 0.05, Outcome.DIVERGED, "not finite at 0.1 s", gap=3e-4)
    # A twentieth of the travel of 0.2 m.
    wide = {"pin": np.array([0.0, 0.0101]), "other": np.array([0.005, 0.0])}
    assert judged(recording(violations=wide)) == LoopRun(
        "tuned", 0.05, Outcome.OPENED, "pin opens by 10.1 mm", gap=0.0101
    )
    assert judged(recording(violations={"pin": np.array([0.01])})).outcome is Outcome.COMPLETED
    assert judged(recording(violations={})).gap == 0.0


def flipped(coordinates: Array) -> LoopRecording:
    """A run whose fifth sample is elsewhere, with its point B 30 mm off."""
    made, every = off("B", 0, 4, (0.03, 0.0, 0.0)), exact().coordinates.copy()
    every[:, 4] = coordinates
    return replace(made, coordinates=every)


def test_a_run_on_another_branch_is_no_error_of_the_same_motion() -> None:
    crank = float(exact().coordinates[0, 4])
    other = judged(flipped(np.array(start_angles(GRASHOF, crank, -1.0))))
    assert other.outcome is Outcome.FLIPPED
    assert other.reason == f"on another branch {machine().describe_drives(float(TIMES[4]))}"
    assert (other.errors, other.gap) == ({}, 1e-4)
    # Far off, and yet on its branch: an error.
    same = judged(flipped(np.array(start_angles(GRASHOF, crank, 1.0)) + 0.01))
    assert (same.outcome, same.errors["position"]) == (Outcome.COMPLETED, pytest.approx(0.03))


@pytest.mark.parametrize(("branch", "near", "is_other"), [(1.0, 1e-6, False), (-1.0, 0.01, True), (-1.0, 1.0, False)])
def test_branch_differs_when_nearest_closed_pose_is_elsewhere(branch: float, near: float, is_other: bool) -> None:
    here = np.array(start_angles(GRASHOF, 1.0, branch))[:, None]
    truth = exact().coordinates[:, :1]
    assert is_on_other_branch(machine(), ("A", "B"), here, 0.0, truth, near) is is_other
    assert not is_on_other_branch(machine(), ("A",), here, 0.0, truth, near)  # which is on both branches
    unlike = SimpleNamespace(close_loops=lambda *_: (_ for _ in ()).throw(InvalidInput("no pose")), tree=machine().tree)
    assert not is_on_other_branch(unlike, ("B",), here, 0.0, truth, 1e-9)  # type: ignore[arg-type]


def test_forces_are_compared_over_their_largest_exact_value() -> None:
    one = np.array([[3.0, 0.0, 0.0], [0.0, -4.0, 0.0]])
    forces = SpatialForces(
        {"crank": np.array([1.0, -2.0]), "idle": np.array([0.0, 0.0])}, {"pin": one, "any": np.full((2, 3), np.nan)}, {}
    )
    made = recording(
        drives={"crank": np.array([1.5, -2.0]), "idle": np.array([1e-9, 0.0])},
        reactions={"pin": one + 0.2, "any": one},
    )
    found = judged(made, forces)
    # 0.5 of 2; 1e-9 over 1e-9 of the largest, 2; 0.2 of 4; of what nothing is known nothing is said.
    assert found.drives == {"crank": pytest.approx(0.25), "idle": pytest.approx(0.5)}
    assert found.reactions == {"pin": pytest.approx(0.05)}


# -- settings ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("label", "integrator", "solref", "weight"), [
    ("as it is", "EULER", (0.02, 1.0), 1.0), ("tuned", "RK4", (0.004, 1.0), 1.0),
    ("hardened", "RK4", (0.15, 1.0), 1e-9),
])  # fmt: skip
def test_settings_are_those_of_their_label(
    label: str, integrator: str, solref: tuple[float, float], weight: float
) -> None:
    model = mujoco.MjModel.from_xml_string(four_bar(option='solver="CG" iterations="7"'))
    made = with_settings(model, label, 0.0005, 1.5)
    option = made.opt
    own = label == "as it is"
    assert (option.timestep, option.tolerance) == (0.0005, 1e-30)
    assert mujoco.mjtIntegrator(option.integrator).name.removeprefix("mjINT_").upper() == integrator
    assert mujoco.mjtSolver(option.solver).name == ("mjSOL_CG" if own else "mjSOL_NEWTON")
    assert option.iterations == (7 if own else 100)
    assert made.eq_solref[0] == pytest.approx(solref)
    assert made.eq_solimp[0, :2] == pytest.approx((0.9, 0.95) if own else (0.9999, 0.9999))
    assert made.body_invweight0[2, 0] == pytest.approx(weight * model.body_invweight0[2, 0])
    assert option.disableflags & disable_bit("AUTORESET") == disable_bit("AUTORESET")
    assert option.o_solref == pytest.approx((0.02, 1.0) if own else (0.001, 1.0))
    # The model itself is as it was.
    assert (model.opt.timestep, model.eq_solref[0].tolist(), model.opt.iterations) == (0.001, [0.02, 1.0], 7)
    contact = with_settings(model, "tuned", 0.0005, 1.5, contact=True)
    assert mujoco.mjtIntegrator(contact.opt.integrator).name == "mjINT_EULER"
    assert driven_runs.preset_settings("hardened", 0.0005, 1.5, False).preset == "hardened"
    idle = with_settings(model, "hardened", 0.0005, 1.5, idle=True)
    assert idle.body_invweight0[2, 0] == pytest.approx(1e-7 * model.body_invweight0[2, 0])


# -- limits and contacts -----------------------------------------------------------------------------------------------

TENDONS = """<tendon><fixed name="t" range="-1 2"><joint joint="crank" coef="1"/></fixed>
  <fixed range="0 1"><joint joint="crank" coef="1"/></fixed><fixed name="free"><joint joint="crank" coef="1"/></fixed>
  </tendon>"""
RUNS = "the runs have these limits, the exact motion has none"


def test_tendons_beyond_their_limits_are_said_with_how_far() -> None:
    model = mujoco.MjModel.from_xml_string(four_bar(more=TENDONS))
    lengths = np.array([[-1.25, 0.5, 9.0], [2.5, 1.0 + 9e-7, 9.0]])
    assert list(driven_runs._tendon_remarks(model, lengths)) == [
        f"the length of tendon t is up to 0.5 beyond its limits, -1 to 2: {RUNS}"
    ]
    ((name, length, ends),) = tendons_beyond_limits(model, np.array([[-1.25, 0.5, 0.0], [0.0, 0.5, 0.0]]))
    assert (name, length.tolist(), ends) == ("t", [-1.25, 0.0], (-1.0, 2.0))
    assert [one[0] for one in tendons_beyond_limits(model, np.array([[0.0, 1.1, 0.0]]))] == ["tendon 1"]
    for flag in ("LIMIT", "CONSTRAINT"):
        model.opt.disableflags = getattr(mujoco.mjtDisableBit, f"mjDSBL_{flag}")
        assert list(tendons_beyond_limits(model, lengths)) == []


def test_remarks_name_joints_beyond_limits_and_parts_in_contact() -> None:
    slide = '<body name="s"><joint name="s" type="slide" range="-0.1 0.2"/><geom size="0.1"/></body>'
    hinge = '<body name="h"><joint name="h" range="-0.5 1"/><geom size="0.1"/></body>'
    free = '<body name="f"><joint name="f"/><geom size="0.1"/></body>'
    model = mujoco.MjModel.from_xml_string(
        f'<mujoco><compiler angle="radian"/><worldbody>{slide}{hinge}{free}</worldbody></mujoco>'
    )
    tree = tree_at_rest(model)
    motion = SimpleNamespace(coordinates=np.array([[0.0, 0.25], [-1.0, 0.0], [0.0, 50.0]]))
    said = list(driven_runs._limit_remarks(SimpleNamespace(tree=tree), motion, ["a and b", "c and d"]))  # type: ignore[arg-type]
    assert said == [
        "parts touch on the way: a and b, c and d; the runs have these contacts, the exact motion has none",
        f"s is up to 50 mm beyond its limits, -100 to 200: {RUNS}",
        f"h is up to 28.6 deg beyond its limits, -28.65 to 57.3: {RUNS}",
    ]
    inside = SimpleNamespace(coordinates=np.array([[-0.1, 0.2 + 9e-7], [-0.5, 1.0], [0.0, 0.0]]))
    assert list(driven_runs._limit_remarks(SimpleNamespace(tree=tree), inside, [])) == []  # type: ignore[arg-type]


def tree_at_rest(model: mujoco.MjModel) -> SpatialTree:
    return tree_of(model, model.qpos0)


# -- the file as it is -------------------------------------------------------------------------------------------------


def swinging(rates: Array) -> Any:
    model = mujoco.MjModel.from_xml_string(four_bar())
    return driven_runs._chatter(tree_at_rest(model), model, rates)


def test_a_rate_that_turns_back_at_every_step_chatters() -> None:
    time = np.arange(100) / 100.0
    rates = np.array([time, 2.0 * time, 0.5 * time]).T
    assert swinging(rates) is None
    zigzag = rates.copy()
    zigzag[:, 1] += 0.1 * (-1.0) ** np.arange(100)
    name, share = swinging(zigzag)
    # Steps of 0.2 over a range of 2 + 0.2.
    assert (name, share) == ("coupler", pytest.approx(0.2 / 2.2, rel=0.15))
    # Of the last half alone, of which there are twenty steps at least.
    early = rates.copy()
    early[:50, 1] += 0.1 * (-1.0) ** np.arange(50)
    assert swinging(early) is None
    assert swinging(zigzag[:38]) is None
    assert swinging(zigzag[:40]) is not None
    # By a thousandth of its range, and as much of the largest of all.
    small = rates.copy()
    small[:, 1] += 0.0004 * (-1.0) ** np.arange(100)
    assert swinging(small) is None
    tiny = np.array([time, 1e-7 * (-1.0) ** np.arange(100), time]).T
    assert swinging(tiny) is None


def test_chattering_joint_without_a_name_has_its_number() -> None:
    model = mujoco.MjModel.from_xml_string(four_bar().replace('<joint name="coupler"', "<joint"))
    time = np.arange(100) / 100.0
    rates = np.array([time, 2.0 * time + 0.1 * (-1.0) ** np.arange(100), 0.5 * time]).T
    found = driven_runs._chatter(tree_at_rest(model), model, rates)
    assert found is not None
    assert found[0] == "joint 1"


def test_own_run_has_the_requested_length_and_names_its_drive() -> None:
    model = mujoco.MjModel.from_xml_string(four_bar(option='gravity="0 0 0"'))
    data = mujoco.MjData(model)
    still = shipped_run(machine().tree, model, data, 0.0304, "its own pose", TRAVEL)
    assert (still.start, still.seconds, still.outcome, still.reason) == (
        "its own pose", 0.0304, Outcome.COMPLETED, "",
    )  # fmt: skip
    assert (still.driven, still.chatter, still.acting) == (False, None, ())
    assert still.gap < 1e-9
    assert data.time == pytest.approx(0.030)
    data = mujoco.MjData(model)
    data.qvel[:] = exact().rates[0, :, 0]
    assert shipped_run(machine().tree, model, data, 0.0001, "", TRAVEL).driven
    assert data.time == pytest.approx(0.002)  # two steps at least
    # A loop that is open by more than a twentieth of what moves, or of the machine.
    apart = mujoco.MjData(model)
    apart.qpos[2] += 0.2
    opened = shipped_run(machine().tree, model, apart, 0.002, "", 0.0)
    assert opened.outcome is Outcome.OPENED
    assert opened.reason == f"pin opens by {1e3 * opened.gap:.3g} mm"
    apart = mujoco.MjData(model)
    apart.qpos[2] += 0.2
    assert shipped_run(machine().tree, model, apart, 0.002, "", 9.0).outcome is Outcome.COMPLETED
    broken = mujoco.MjData(model)
    broken.qvel[0] = 1e11
    model.opt.disableflags |= disable_bit("AUTORESET")
    found = shipped_run(machine().tree, model, broken, 0.05, "", TRAVEL)
    assert (found.outcome, found.chatter) == (Outcome.DIVERGED, None)
    assert found.reason.startswith("not finite")
    assert found.reason.endswith(" s")


def test_own_run_is_looked_at_in_each_of_a_few_steps() -> None:
    # A crank alone at 5 rad/s, of 40 steps: the way of its body is one of chords.
    text = """<mujoco><option timestep="0.01" gravity="0 0 0"/><worldbody><body name="a"><joint name="a" axis="0 0 1"/>
    <inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/><body name="b" pos="0.1 0 0"><geom size="0.01" mass="1e-9"/>
    </body></body></worldbody></mujoco>"""
    model = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(model)
    data.qvel[:] = 5.0
    found = shipped_run(tree_at_rest(model), model, data, 0.4, "", TRAVEL)
    assert found.path == pytest.approx(39 * 2.0 * 0.1 * np.sin(0.5 * 0.05), rel=1e-6)


def test_own_run_opens_by_the_largest_gap_on_its_way() -> None:
    # It starts open, and closes.
    model = mujoco.MjModel.from_xml_string(four_bar(option='gravity="0 0 0"'))
    data, again, gaps = mujoco.MjData(model), mujoco.MjData(model), list[float]()
    tree = tree_at_rest(model)
    for one in (data, again):
        one.qpos[2] += 0.01
    for _ in range(50):
        mujoco.mj_step(model, again)
        aside = mujoco.MjData(model)
        aside.qpos[:] = again.qpos
        mujoco.mj_fwdPosition(model, aside)
        gaps.append(closure_violations(tree, model, aside)["pin"])
    found = shipped_run(tree, model, data, 0.05, "", TRAVEL)
    assert found.gap == pytest.approx(max(gaps), rel=1e-9)
    assert gaps[-1] < 0.5 * max(gaps)


# -- runs --------------------------------------------------------------------------------------------------------------


def test_a_driven_run_is_at_its_laws_at_each_sample() -> None:
    model = mujoco.MjModel.from_xml_string(four_bar())
    tuned = with_settings(model, "tuned", 0.001, 1.0)
    motion = machine().motion(np.arange(0, 11, 5) * 0.001)
    points = site_points(model, ("B", "coupler"))
    assert [(point.name, point.kind, point.body) for point in points] == [("B", "site", 3), ("coupler", "body", 3)]
    found = driven_run(machine(), tuned, motion, points, 5)
    assert found.times.tolist() == motion.times.tolist()
    assert found.coordinates == pytest.approx(motion.coordinates, abs=1e-6)
    assert found.rates == pytest.approx(motion.rates[0], abs=1e-3)
    assert found.points["B"][0] == pytest.approx(motion.points["B"].position, abs=1e-6)
    assert found.points["B"][1] == pytest.approx(motion.points["B"].velocity, abs=1e-3)
    assert (found.outcome, found.reason) == (Outcome.COMPLETED, "")
    assert (list(found.drives), list(found.reactions), list(found.violations)) == (["crank"], ["pin"], ["pin"])
    assert found.reactions["pin"].shape == (3, 3)
    bare = driven_run(machine(), tuned, motion, points, 5, carried=False)
    assert (bare.drives, bare.reactions) == ({}, {})
    assert mujoco.get_mjcb_control() is None


def test_closures_are_named_with_their_rows_and_openings() -> None:
    more = '<joint name="gear" joint1="crank" joint2="rocker"/></equality>'
    model = mujoco.MjModel.from_xml_string(four_bar().replace("</equality>", more))
    data = mujoco.MjData(model)
    data.qpos[0] += 0.1
    mujoco.mj_forward(model, data)
    rows = {name: own.tolist() for name, own in closure_rows(model, data).items()}
    assert rows == {"pin": [0, 1, 2], "gear": [3]}
    tree = tree_at_rest(model)
    gaps = closure_violations(tree, model, data)
    assert list(gaps) == ["pin", "gear"]
    assert gaps["gear"] == pytest.approx(0.1 * tree.extent)
    assert widest_opening_words({"pin": 1e-3, "gear": 2.34567e-3}) == "gear opens by 2.35 mm"


def test_run_breaks_off_at_bad_numbers_and_reports_a_reset() -> None:
    model = mujoco.MjModel.from_xml_string(four_bar())
    data = mujoco.MjData(model)
    assert break_off_reason(model, data) == ""
    for field in ("qpos", "qvel"):
        data = mujoco.MjData(model)
        getattr(data, field)[0] = np.nan
        assert break_off_reason(model, data) == "not finite"
    data = mujoco.MjData(model)
    data.warning[mujoco.mjtWarning.mjWARN_BADQVEL].number = 1
    reset = break_off_reason(model, data)
    assert reset.startswith("MuJoCo reset its state (")
    model.opt.disableflags |= disable_bit("AUTORESET")
    assert break_off_reason(model, data) == reset.replace("MuJoCo reset its state", "not finite")
    assert break_reason(data) in reset
    data = mujoco.MjData(model)
    assert break_reason(data) == ""
    data.qpos[1] = np.inf
    assert break_reason(data) == "not finite"


BALLS = """<mujoco><option timestep="0.01" gravity="0 0 0"/><worldbody><geom name="wall" type="plane" size="1 1 1"/>
  <body name="a" pos="0 0 0.099"><freejoint/><geom name="a" size="0.1" pos="0 0 0"/></body>
  <body name="b" pos="9 0 5"><joint type="slide" axis="1 0 0"/><geom size="0.1" pos="0 0 1"/></body>
</worldbody></mujoco>"""


def test_a_run_has_evenly_spaced_states_points_and_contacts() -> None:
    model = mujoco.MjModel.from_xml_string(BALLS)
    data = mujoco.MjData(model)
    data.qvel[6] = 3.0
    made = run(model, state_of(model, data), 10, 4)
    assert (made.steps, made.states.shape[0], made.broke) == (10, 3, "")
    assert made.points.shape == (3, 4, 3)
    # Origins first, then centres of gravity; after 0, 4 and 8 steps of 10 ms at 3 m/s.
    assert made.points[:, 1] == pytest.approx(np.array([[9.0 + 0.12 * k, 0.0, 5.0] for k in range(3)]))
    assert made.centres[:, 1] == pytest.approx(np.array([[9.0 + 0.12 * k, 0.0, 6.0] for k in range(3)]))
    assert made.travel == pytest.approx(0.24)
    assert list(made.touched) == [(0, 1)]
    assert 1 <= made.touched[0, 1] <= 10
    assert [one.kind for one in made.acting] == ["contact"]
    assert made.constraint_violations(1.0).shape == (3, 0)
    long = run(model, state_of(model, data), 801)
    assert len(long.states) == 801 // 3 + 1
    broken = run(model, np.where(np.arange(len(made.states[0])) == 0, np.nan, made.states[0]), 10, 4)
    assert (broken.steps, len(broken.states), broken.broke, broken.travel) == (0, 0, "not finite", 0.0)


def test_a_stepper_begins_again_at_the_end_of_its_run() -> None:
    model = mujoco.MjModel.from_xml_string(BALLS)
    data = mujoco.MjData(model)
    data.qvel[6] = 3.0
    seen: list[int] = []
    step, reset = mujoco.mj_step, mujoco.mj_resetData
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(mujoco, "mj_step", lambda model, data, some: (seen.append(some), step(model, data, some)))
        patch.setattr(mujoco, "mj_resetData", lambda model, data: (seen.append(-1), reset(model, data)))
        advance = looping_stepper(model, state_of(model, data), 5)()
        for steps in (3, 4, 11):
            advance(steps)
    # At most five steps before each start.
    assert seen == [3, 2, -1, 2, 3, -1, 5, -1, 3]
    assert STATE & int(mujoco.mjtState.mjSTATE_WARMSTART)


def test_errors_of_a_users_model_have_its_file() -> None:
    for error in (InvalidInput("no"), mujoco.FatalError("no\n  way")):
        with pytest.raises(InvalidInput) as told, user_model_errors(Path("m.xml")):
            raise error
        words = "no" if isinstance(error, InvalidInput) else "MuJoCo gives up on it: no way"
        assert str(told.value) == f"m.xml: {words}"
