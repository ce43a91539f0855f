"""What must not matter in a MuJoCo model does not, or is found with its size."""

from __future__ import annotations

import copy
from pathlib import Path

import mujoco
import numpy as np
import pytest
from command_line import conrod

from conrod.execution.resolve_arguments import select_scene
from conrod.mjcf.loading import load_model
from conrod.mjcf.runs import run, state_of
from conrod.models.invariances import solvers
from conrod.models.invariances.accelerations import Similarity, accelerations, forward, with_converged_solver
from conrod.models.invariances.changes import SIMILARITIES, InvarianceBench, similarities
from conrod.models.invariances.results import InvarianceOutcome
from conrod.models.invariances.study import all_invariance_checks, study_declaration_orders

# Two loops on a tree with branches, a slide, a spring and a motor; with a box that falls on its friction.
LOOPS = """<mujoco><option timestep="0.001"/><worldbody>
<body name="a" pos="0 0 0.1"><joint name="a" axis="0 1 0" damping="0.1" armature="0.01"/>
  <geom type="capsule" fromto="0 0 0 0.3 0 0" size="0.02" contype="0" conaffinity="0"/>
  <body name="b" pos="0.3 0 0"><joint axis="0.2 1 0.1" stiffness="2" springref="0.4"/>
    <geom type="capsule" fromto="0 0 0 0.2 0.1 0.3" size="0.02" contype="0" conaffinity="0"/></body>
  <body name="c" pos="0.3 0 0"><joint axis="0.1 1 0"/>
    <geom type="capsule" fromto="0 0 0 0.1 0 -0.2" size="0.02" contype="0" conaffinity="0"/></body></body>
<body name="d" pos="0.5 0.1 0.4"><joint type="slide" axis="1 0 0" frictionloss="0.3"/>
  <geom type="box" size="0.05 0.04 0.03" pos="0.01 0 0" contype="0" conaffinity="0"/></body>
{more}</worldbody>
<equality><connect body1="b" body2="d" anchor="0.2 0 0.3"/><connect body1="c" anchor="0.1 0 -0.2"/></equality>
<actuator><motor joint="a" gear="2"/></actuator></mujoco>"""
BOX = """<geom type="plane" size="3 3 0.1" pos="0 0 -0.5"/><body name="box" pos="1 1 -0.401" euler="0 0 20"><freejoint/>
  <geom type="box" size="0.1 0.08 0.1" friction="0.8"/></body>"""


def bench_of(path: Path, more: str = "") -> InvarianceBench:
    path.write_text(LOOPS.format(more=more), encoding="utf-8")
    model = load_model(path)
    data = mujoco.MjData(model)
    data.ctrl[:], data.qvel[:], data.qvel[4:6] = 0.5, 0.1, 1.0  # the box slides
    states = run(model, state_of(model, data), 60).states[::20]
    return InvarianceBench.from_states(model, 0.02 * np.arange(len(states)), states)


def test_a_symmetric_state_has_a_bound_of_rounding_too() -> None:
    # Links that lie level: no rounding of the angles changes a cosine of 1, and turned worlds round otherwise.
    link = '<joint axis="0 1 0"/><geom type="capsule" fromto="0 0 0 0.5 0 0" size="0.02"/>'
    model = mujoco.MjModel.from_xml_string(
        f'<mujoco><worldbody><body>{link}<body pos="0.5 0 0">{link}</body></body></worldbody></mujoco>'
    )
    found = accelerations(model, state_of(model, mujoco.MjData(model)))
    assert 1e-15 * found.size < found.bound < 1e-13 * found.size


@pytest.fixture(scope="module")
def path(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("loops") / "loops.xml"


@pytest.fixture(scope="module")
def loops(path: Path) -> InvarianceBench:
    return bench_of(path)


def test_solver_units_place_and_order_do_not_matter_to_rounding(loops: InvarianceBench, path: Path) -> None:
    found = list(all_invariance_checks(loops, path))
    assert len(found) == 8
    assert all(one.outcome is InvarianceOutcome.HOLDS and one.difference < 1e-9 for one in found)


@pytest.mark.parametrize("field", ["body_mass", "eq_data", "dof_frictionloss", "jnt_stiffness", "actuator_gainprm"])
def test_a_number_that_is_off_by_1e_8_is_found(loops: InvarianceBench, field: str) -> None:
    off = with_converged_solver(loops.model)
    getattr(off, field)[:] *= 1.0 + 1e-8
    found = loops.judge_change("planted", lambda state: forward(off, state).qacc)
    assert found.outcome is InvarianceOutcome.BROKEN
    assert found.over_bound > 1.0


@pytest.mark.parametrize("field", ["body_inertia", "dof_armature", "gravity", "jnt_stiffness"])
def test_a_similarity_that_forgets_a_field_is_found(
    loops: InvarianceBench, field: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    applied = Similarity.apply

    def forgetful(self: Similarity, model: mujoco.MjModel) -> mujoco.MjModel:
        made = applied(self, model)
        owner = made.opt if field == "gravity" else made
        getattr(owner, field)[:] = getattr(model.opt if field == "gravity" else model, field)
        return made

    monkeypatch.setattr(Similarity, "apply", forgetful)
    assert any(one.outcome is InvarianceOutcome.BROKEN for one in similarities(loops))


def test_friction_pyramid_becomes_a_cone_in_a_turned_world(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    sliding = bench_of(tmp_path / "sliding.xml", BOX)
    assert [one.outcome for one in similarities(sliding)] == [InvarianceOutcome.HOLDS, InvarianceOutcome.HOLDS]
    monkeypatch.setattr("conrod.models.invariances.changes._with_elliptic_cone", lambda bench: bench)
    assert [one.outcome for one in similarities(sliding)] == [InvarianceOutcome.HOLDS, InvarianceOutcome.BROKEN]


def test_similarity_is_unsupported_with_reason_for_a_fluid(loops: InvarianceBench) -> None:
    windy = copy.copy(loops.model)
    windy.opt.density = 1.2
    assert all(one.refusal(windy) == "the model has a fluid" for one in SIMILARITIES.values())


def test_turned_world_of_many_geoms_turns_its_contact_boxes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    grid = [(0.1 * i - 0.25, 0.1 * j - 0.25) for i in range(6) for j in range(6)]
    floor = "".join(f'<geom type="box" size="0.05 0.05 0.05" pos="{x} {y} 0"/>' for x, y in grid)
    shapes = '<geom type="box" size="0.1 0.02 0.02"/><geom type="box" size="0.02 0.1 0.02"/>'
    body = f'<body pos="0 0 0.067"><freejoint/>{shapes}<geom size="0.05" pos="0.1 0.1 0.035"/></body>'
    path = tmp_path / "floor.xml"
    path.write_text(f"<mujoco><worldbody>{floor}{body}</worldbody></mujoco>", encoding="utf-8")
    model = load_model(path)
    states = run(model, state_of(model, mujoco.MjData(model)), 60).states[::20]
    bench = InvarianceBench.from_states(model, 0.04 * np.arange(len(states)), states)
    assert [one.outcome for one in similarities(bench)] == [InvarianceOutcome.HOLDS, InvarianceOutcome.HOLDS]
    # Negative control: with the boxes as they were compiled, contacts are missed.
    monkeypatch.setattr(mujoco.mjtDisableBit, "mjDSBL_MIDPHASE", 0)
    assert [one.outcome for one in similarities(bench)] == [InvarianceOutcome.HOLDS, InvarianceOutcome.BROKEN]


def test_other_solvers_agree_with_newton_within_their_residuals(loops: InvarianceBench, tmp_path: Path) -> None:
    for bench in (loops, bench_of(tmp_path / "sliding.xml", BOX)):
        found = list(solvers.other_solvers(bench))
        assert [one.change for one in found] == ["CG for Newton's method", "PGS for Newton's method"]
        assert all(one.outcome is InvarianceOutcome.HOLDS and one.bound == "residual" for one in found)


def test_solver_that_minimises_something_else_is_found(loops: InvarianceBench, monkeypatch: pytest.MonkeyPatch) -> None:
    def planted(model: mujoco.MjModel) -> mujoco.MjModel:
        made = with_converged_solver(model)
        made.body_mass[:] *= 1.0 + 1e-8
        return made

    monkeypatch.setattr(solvers, "with_converged_solver", planted)
    assert [one.outcome for one in solvers.other_solvers(loops)] == [InvarianceOutcome.BROKEN] * 2
    assert all(one.over_bound > 10.0 for one in solvers.other_solvers(loops))


def test_solver_that_stops_early_says_so_by_its_residual(
    loops: InvarianceBench, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(solvers, "MAX_ITERATIONS", 3)
    assert all("has not converged in 3 iterations" in one.reason for one in solvers.other_solvers(loops))
    # How far it is off is bounded by the residual, not by more than it is by a factor of a thousand.
    early = with_converged_solver(loops.model)
    early.opt.solver, early.opt.iterations = mujoco.mjtSolver.mjSOL_PGS, 3
    for state, reference in zip(loops.states, loops.reference, strict=True):
        data = forward(early, state)
        off = reference.difference(data.qacc)
        assert off <= solvers.solver_residual(early, data) <= 1e3 * off


def test_other_solvers_are_unsupported_with_noslip_iterations(loops: InvarianceBench) -> None:
    slipless = copy.copy(loops.model)
    slipless.opt.noslip_iterations = 3
    bench = InvarianceBench(slipless, loops.times, loops.states, loops.reference)
    assert all("noslip" in one.reason for one in solvers.other_solvers(bench))


def test_an_actuator_whose_force_is_not_linear_is_not_known(loops: InvarianceBench) -> None:
    muscle = copy.copy(loops.model)
    muscle.actuator_gaintype[0] = int(mujoco.mjtGain.mjGAIN_MUSCLE)
    assert SIMILARITIES["masses doubled"].refusal(loops.model) == ""
    assert SIMILARITIES["masses doubled"].refusal(muscle) == "an actuator's force is not linear in its numbers"


@pytest.mark.slow
def test_sparse_factorisation_breaks_in_4_0_0_and_holds_in_4_0_1() -> None:
    """MuJoCo 4.0.1's release notes: 4.0.0 merged rows with different descendants (#3767)."""
    sparse = next(
        one for one in study_declaration_orders(select_scene("four-bar-chain-5", [])[1]) if "sparse" in one.change
    )
    assert sparse.cases > 50
    assert sparse.outcome is (InvarianceOutcome.BROKEN if mujoco.__version__ == "4.0.0" else InvarianceOutcome.HOLDS)


def test_command_judges_any_model_and_refuses_unfit_options(tmp_path: Path) -> None:
    model, report, again = tmp_path / "m.xml", tmp_path / "r", tmp_path / "again"
    bench_of(model)
    done = conrod("invariances", str(model), "--seconds", "0.02", "--out", str(report))
    assert done.returncode == 0
    assert "None of 11 invariances is broken" in done.stdout
    assert conrod("report", str(report), "--out", str(again)).returncode == 0
    page = "m-invariances.md"
    assert (again / page).read_bytes() == (report / page).read_bytes()
    refused = conrod("invariances", str(model), "--preset", "stock")
    assert refused.returncode == 2
    assert "No such option '--preset'" in refused.stderr
    other = tmp_path / "other.xml"
    bench_of(other)
    refused = conrod("invariances", str(model), str(other), "--json", str(model))
    assert (refused.returncode, "same file as the model" in refused.stderr) == (2, True)
    twice = conrod("invariances", str(model), str(model))
    assert (twice.returncode, "another has the same name in the report" in twice.stderr) == (2, True)
