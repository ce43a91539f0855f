"""Engines on machines in space: errors against closed forms, laws of drives, balls, welds, and another machine."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest

from conrod.comparison.trajectory import Outcome
from conrod.engines import installed_extras
from conrod.engines.mujoco import space as mujoco_space
from conrod.engines.space import SpatialStart, widest_gaps
from conrod.exact.motion import Array
from conrod.exact.space import SpatialPoint
from conrod.exact.space.forward_kinematics import rotation_matrices
from conrod.exact.space.motion import DrivenTree
from conrod.mjcf.driven_runs import with_settings
from conrod.mjcf.driving import driven_run, site_points
from conrod.mjcf.reading import machine_tree
from conrod.scenes.space import MACHINES, SpatialMachine
from conrod.scenes.space.tree import spatial_tree
from conrod.studies.space import plan, study
from conrod.studies.space.results import SpatialResult, StepRun
from conrod.studies.space.study import SpatialCell, prepare_bench, run_cell
from conrod.testing import spinning_start

NEEDS_EXUDYN = pytest.mark.skipif("exudyn" not in installed_extras(), reason="Exudyn is not installed")
NEEDS_DRAKE = pytest.mark.skipif("drake" not in installed_extras(), reason="Drake is not installed")
IN_SPACE = ["mujoco", pytest.param("exudyn", marks=NEEDS_EXUDYN), pytest.param("drake", marks=NEEDS_DRAKE)]
# The preset of each engine whose positions are the most exact.
EXACT_PRESETS = {"mujoco": "hardened", "exudyn": "stock", "drake": "tuned"}
# Between them: oblique axes (bennett), a ball beside a loop, a law that is no constant speed, a weld, six drives.
SLOW = [pytest.param(name, marks=pytest.mark.slow) for name in ("sarrus", "stewart")]
TAKEN = ("bennett", "rssr-idle-spin", "tilted-slider-crank", *SLOW)


@pytest.fixture(autouse=True)
def untimed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(study, "step_cost", lambda make, steps: 1.0)


def ran(machine: str, engine: str, preset: str, *steps: int) -> SpatialResult:
    return run_cell(SpatialCell(machine, engine, preset, steps or (50,), 1))


def machine_of(monkeypatch: pytest.MonkeyPatch, machine: SpatialMachine) -> str:
    """Make a machine known by the text of its first drive; return this name."""
    name = next(iter(machine.drives.values()))
    monkeypatch.setattr(study, "MACHINES", {name: lambda: machine})
    return name


@NEEDS_EXUDYN
@pytest.mark.parametrize("name", TAKEN)
def test_exudyn_has_exact_positions_in_space(name: str) -> None:
    found = ran(name, "exudyn", "stock")
    assert found.outcome == Outcome.COMPLETED.slug, found.reason
    assert found.largest("position") < 1e-8  # type: ignore[operator] # what Newton's iteration leaves of 1e-8
    assert found.largest("velocity") < 5e-2  # type: ignore[operator]
    assert found.largest("closure") < 1e-8  # type: ignore[operator]


@pytest.mark.parametrize("name", TAKEN)
def test_hardened_mujoco_is_of_order_four_in_space(name: str) -> None:
    found = ran(name, "mujoco", "hardened", 100, 200)
    assert found.outcome == Outcome.COMPLETED.slug, found.reason
    # MuJoCo 3.8.0 leaves the hardened loop beside an idle spin softer: docs/versions.md, "Older releases".
    softer = name == "rssr-idle-spin" and int(mujoco.__version__.split(".")[0]) < 4
    for quantity, order in (found.order or {}).items():
        assert order == pytest.approx(2.0 if softer else 4.0, abs=0.25), quantity


@NEEDS_EXUDYN
def test_trapezoidal_rule_is_of_order_two_in_space() -> None:
    found = ran("tilted-slider-crank", "exudyn", "tuned", 100, 200)
    assert found.order is not None
    assert all(order == pytest.approx(2.0, abs=0.05) for order in found.order.values())


@NEEDS_EXUDYN
def test_trapezoidal_rule_diverges_on_some_loops() -> None:
    found = ran("bennett", "exudyn", "tuned")
    assert (found.outcome, found.largest("position")) == (Outcome.DIVERGED.slug, None)
    assert "Newton's iteration did not converge" in found.reason


@NEEDS_DRAKE
@pytest.mark.parametrize(
    "name", ["bennett", "tilted-slider-crank", pytest.param("rssr-idle-spin", marks=pytest.mark.slow), *SLOW]
)
def test_drake_is_of_order_two_in_space(name: str) -> None:
    loose, tight = (ran(name, "drake", preset, 100, 200) for preset in ("stock", "tuned"))
    for found in (loose, tight):
        assert found.outcome == Outcome.COMPLETED.slug, found.reason
    assert loose.order is not None
    assert loose.order["position"] == pytest.approx(2.0, abs=0.15)
    assert loose.order["velocity"] == pytest.approx(1.0, abs=0.25)
    # Bushings hold the loops by far closer than constraints.
    for quantity, share in (("position", 1e-2), ("velocity", 0.1), ("closure", 1e-2)):
        assert tight.largest(quantity) < share * loose.largest(quantity), quantity  # type: ignore[operator]


LAWS = {"constant": "60rpm", "sine": "sine:40deg,2Hz", "move": "move:0deg,80deg,0.5s", "table": "table:{}"}


def machine_with_law(law: str, monkeypatch: pytest.MonkeyPatch, folder: Path) -> str:
    """Make Cardan's joint with a law of its input known; return its name."""
    file, times = folder / "law.csv", np.linspace(0.0, 0.5, 9)
    np.savetxt(file, np.column_stack([times, 0.3 * np.sin(5.0 * times)]), delimiter=",")
    return machine_of(monkeypatch, replace(MACHINES["cardan"](), drives={"input": LAWS[law].format(file)}))


@NEEDS_EXUDYN
@pytest.mark.parametrize("law", ["constant", "sine", "move", pytest.param("table", marks=pytest.mark.slow)])
def test_engines_follow_laws_in_space(law: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Any) -> None:
    name = machine_with_law(law, monkeypatch, tmp_path)
    assert ran(name, "exudyn", "stock").largest("position") < 1e-8  # type: ignore[operator]
    assert ran(name, "mujoco", "hardened").largest("position") < 1e-3  # type: ignore[operator]


@NEEDS_DRAKE
@pytest.mark.parametrize("law", ["constant", "sine", "move", pytest.param("table", marks=pytest.mark.slow)])
def test_drake_follows_laws_in_space(law: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Any) -> None:
    name = machine_with_law(law, monkeypatch, tmp_path)
    assert ran(name, "drake", "stock", 100).largest("position") < 2e-3  # type: ignore[operator]
    assert ran(name, "drake", "tuned", 100).largest("position") < 2e-5  # type: ignore[operator]


@NEEDS_EXUDYN
def test_exudyn_runs_on_from_block_to_block() -> None:
    # 1024 steps are one call of its solver; its clock begins again with each, and the law must not.
    found = ran("sarrus", "exudyn", "stock", 1100)
    assert found.largest("position") < 1e-8  # type: ignore[operator]
    assert found.largest("velocity") < 1e-4  # type: ignore[operator]


@pytest.mark.parametrize("engine", IN_SPACE)
def test_every_second_sample_is_a_sample_of_all(engine: str) -> None:
    bench = prepare_bench("rssr")
    start = replace(bench.start, step=bench.start.period / 100)
    runs = study.require_capability(study.engine_named(engine), study.SpatialRuns)
    every, second = (runs.run_in_space(start, "stock", 60, n) for n in (1, 2))
    assert np.array_equal(every.times[::2], second.times)
    for name, moved in every.points.items():
        assert np.array_equal(moved[:, ::2], second.points[name])


def test_mujoco_runs_a_tree_as_its_own_file() -> None:
    bench, machine = prepare_bench.__wrapped__("rssr"), MACHINES["rssr"]()
    start = replace(bench.start, step=bench.start.period / 200)
    own = mujoco.MjModel.from_xml_string(machine.mjcf)
    names = tuple(plan.exact_points(machine, np.zeros(1)))
    start.machine.track_branch(start.machine.knots[0].coordinates, 0.2)
    motion = start.machine.motion(start.step * np.arange(41.0))
    model = with_settings(own, "tuned", start.step, start.period)
    filed = driven_run(start.machine, model, motion, site_points(own, names), 1, carried=False)
    made = mujoco_space.run_in_space(start, "tuned", 40)
    for name in names:
        for k, size in enumerate((1.0, 10.0, 100.0)):
            assert np.abs(made.points[name][k] - filed.points[name][k]).max() < 1e-9 * size


# -- negative controls -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("engine", IN_SPACE)
def test_a_crank_of_another_length_is_seen_in_space(engine: str, monkeypatch: pytest.MonkeyPatch) -> None:
    exact = plan.exact_points

    def longer(machine: SpatialMachine, times: Array) -> Mapping[str, Array]:
        return exact(MACHINES["rssr"](crank=0.0801), times)

    monkeypatch.setattr(study, "exact_points", longer)
    preset = EXACT_PRESETS[engine]
    assert ran("rssr", engine, preset).largest("position") > 1e-4  # type: ignore[operator]


def test_an_open_loop_has_no_errors(monkeypatch: pytest.MonkeyPatch) -> None:
    bench = prepare_bench("rssr")
    run = mujoco_space.run_in_space(replace(bench.start, step=0.01), "stock", 20)
    torn = {name: moved + 0.1 * name.endswith("end 2") for name, moved in run.points.items()}
    found = study.judge_run(100, replace(run, points=torn), bench, plan.motion_scales(bench.machine))
    assert (found.outcome, found.errors) == (Outcome.OPENED.slug, None)
    assert "rocker_pin opens by" in found.reason
    assert study.judge_run(100, run, bench, plan.motion_scales(bench.machine)).outcome == Outcome.COMPLETED.slug


def test_joints_that_no_engine_is_given_are_refused() -> None:
    bench = prepare_bench("rssr")
    closure = replace(bench.start.tree.closures[0], kind="tendon", points=(), sums=({0: 1.0}, {}))
    tree = replace(bench.start.tree, closures=(closure,))
    start = replace(bench.start, machine=DrivenTree(tree, bench.start.machine.laws))
    for engine in ("mujoco", *(name for name in installed_extras() if name in (*EXACT_PRESETS, "newton"))):
        runs = study.require_capability(study.engine_named(engine), study.SpatialRuns)
        assert ", no tendon" in (runs.refusal_in_space(start, "stock") or "")
        assert runs.refusal_in_space(bench.start, "stock") is None


@NEEDS_EXUDYN
def test_ball_of_three_hinges_is_singular_at_a_right_angle() -> None:
    # A rod with the inertia of a block spins about its second hinge: its axis has neither most nor least inertia.
    start = spinning_start()
    ball = next(joint for joint in start.tree.joints if joint.kind == "ball")
    along = np.linalg.eigh(start.tree.bodies[ball.body].inertia)[1]
    block = replace(start.tree.bodies[ball.body], inertia=along @ np.diag([2e-3, 1e-3, 3e-3]) @ along.T)
    bodies = tuple(block if body.name == block.name else body for body in start.tree.bodies)
    tree = replace(start.tree, bodies=bodies)
    blocked = replace(start, machine=DrivenTree(tree, start.machine.laws), step=start.period / 200)
    runs = study.require_capability(study.engine_named("exudyn"), study.SpatialRuns)
    found = runs.run_in_space(blocked, "stock", 100)
    assert len(found.times) < 101
    assert "ball rod is made of are nearly singular there" in found.failure
    assert runs.run_in_space(replace(start, step=blocked.step), "stock", 100).failure == ""


@pytest.mark.parametrize(
    ("errors", "order"),
    [
        ((4e-3, 1e-3), 2.0),
        ((4e-10, 1e-10), None),  # rounding
        ((1e-3, 1e-3), None),
        ((1.6e-7, 1e-8, 1e-10, 1.1e-10), 6.64),  # the last pair is rounding: the one before counts
        ((4e-3, 1e-3, 1e-3), None),  # an error that has stopped to fall has no order, however it fell before
    ],
)
def test_order_is_that_of_the_last_pair_above_rounding(errors: tuple[float, ...], order: float | None) -> None:
    names = ("position", "velocity", "acceleration")
    runs = [StepRun(50 * 2**k, "completed", errors=dict.fromkeys(names, size)) for k, size in enumerate(errors)]
    found = study.observed_orders(tuple(runs))["position"]
    assert found == (None if order is None else pytest.approx(order, abs=0.01))


@pytest.mark.parametrize("name", MACHINES)
def test_tree_of_links_is_that_of_the_exported_model(name: str) -> None:
    own, filed = spatial_tree(MACHINES[name]()), machine_tree(name)
    for one, other in zip(own.bodies[1:], filed.bodies[1:], strict=True):
        assert (one.name, one.parent, len(one.joints)) == (other.name, other.parent, len(other.joints))
        for field in ("place", "turn", "mass", "centre"):
            assert np.abs(getattr(one, field) - getattr(other, field)).max() < 1e-14, field
        assert np.abs(one.inertia - other.inertia).max() < 1e-14 * np.abs(other.inertia).max()
        for joint, written in zip(one.joints, other.joints, strict=True):
            assert (joint.name, joint.kind, joint.rate) == (written.name, written.kind, written.rate)
            assert joint.kind == "ball" or np.abs(joint.axis - written.axis).max() < 1e-14
    for closure, written_closure in zip(own.closures, filed.closures, strict=True):
        assert (closure.name, closure.kind) == (written_closure.name, written_closure.kind)
        for end, written_end in zip(closure.points, written_closure.points, strict=True):
            assert end.body == written_end.body
            assert np.abs(end.offset - written_end.offset).max() < 1e-14
    assert all(np.abs(own.points[one].offset - filed.points[one].offset).max() < 1e-14 for one in own.points)


def with_turned_frame(start: SpatialStart, name: str, turn: Array, weld: bool = True) -> SpatialStart:
    """Turn the frame of a body by a rotation (3, 3), and say the same machine in it; or forget it in the weld."""
    tree, number = start.tree, next(k for k, body in enumerate(start.tree.bodies) if body.name == name)

    def moved(point: SpatialPoint) -> SpatialPoint:
        return replace(point, offset=turn.T @ point.offset) if point.body == number else point

    bodies = list(tree.bodies)
    own = bodies[number]
    joints = tuple(replace(one, axis=turn.T @ one.axis, anchor=turn.T @ one.anchor) for one in own.joints)
    about = {"centre": turn.T @ own.centre, "inertia": turn.T @ own.inertia @ turn}
    bodies[number] = replace(own, turn=own.turn @ turn, joints=joints, **about)
    assert all(one.points[1].body == number for one in tree.closures)
    held = turn if weld else np.eye(3)
    closures = tuple(
        replace(one, points=tuple(map(moved, one.points)), turn=np.asarray(one.turn) @ held) for one in tree.closures
    )
    points = {point: moved(place) for point, place in start.points.items()}
    other = replace(tree, bodies=tuple(bodies), closures=closures)
    return replace(start, machine=DrivenTree(other, start.machine.laws), points=points)


@pytest.mark.parametrize("engine", IN_SPACE)
def test_weld_of_frames_that_are_turned_holds_the_same(engine: str) -> None:
    bench = prepare_bench("tilted-slider-crank")
    # All points of the closed form lie where the weld's rotation does not show: one more, aside of them.
    aside = SpatialPoint(bench.start.points["closure 0 arm 0 end 2"].body, np.array([0.05, 0.02, 0.1]))
    start = replace(bench.start, step=bench.start.period / 100, points={**bench.start.points, "aside": aside})
    turn = rotation_matrices(np.array([[0.5], [0.1], [-0.7], [0.5]]))[:, :, 0]
    runs = study.require_capability(study.engine_named(engine), study.SpatialRuns)
    preset = EXACT_PRESETS[engine]
    plain, turned = (runs.run_in_space(one, preset, 50) for one in (start, with_turned_frame(start, "rod_end", turn)))
    for name in plain.points:
        assert np.abs(plain.points[name][0] - turned.points[name][0]).max() < 1e-9
    forgotten = runs.run_in_space(with_turned_frame(start, "rod_end", turn, weld=False), preset, 50)
    apart = [np.abs(plain.points[name][0][: len(one[0])] - one[0]).max() for name, one in forgotten.points.items()]
    assert forgotten.failure or max(apart) > 1e-3
    gaps = [widest_gaps(start.tree, run)["rod_weld"] for run in (turned, forgotten)]
    assert gaps[0] < 1e-6
    assert forgotten.failure or gaps[1] > 1e-3
