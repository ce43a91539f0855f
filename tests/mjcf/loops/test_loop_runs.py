"""Models of machines in space: what they have otherwise is named with what it does, and runs converge."""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path

import mujoco
import numpy as np
import pytest
from four_bars import GRASHOF, driven, four_bar, rocker_pin

from conrod.comparison.convergence import claimed_order
from conrod.comparison.trajectory import Outcome
from conrod.errors import InvalidInput
from conrod.exact.motion import Array
from conrod.exact.space.mobility import forces
from conrod.exact.space.motion import DrivenTree
from conrod.mjcf.differences import MachineComparison, compare_with_machine
from conrod.mjcf.driven_runs import compare_kinematics, judge_run, with_settings
from conrod.mjcf.driving import LoopRecording, driven_run
from conrod.mjcf.loop_results import KINEMATIC_TOLERANCE, OWN_SETTINGS, LoopRequest, LoopRun
from conrod.mjcf.reading import machine_tree
from conrod.models.loops.study import _LoopBench, study_loops
from conrod.scenes.space import MACHINES

TIMES = np.linspace(0.0, 1.0, 25)
Edit = Callable[[ET.Element], None]


def named(root: ET.Element, tag: str, name: str) -> ET.Element:
    return next(one for one in root.iter(tag) if one.get("name") == name)


def shifted(tag: str, name: str, field: str, change: Callable[[Array], Array]) -> Edit:
    def edit(root: ET.Element) -> None:
        one = named(root, tag, name)
        values = np.array([float(x) for x in str(one.get(field)).split()])
        one.set(field, " ".join(repr(float(x)) for x in change(values)))

    return edit


def without_a_loop(root: ET.Element) -> None:
    del root.find("equality")[0]


def edited(machine: str, edit: Edit) -> str:
    root = ET.fromstring(MACHINES[machine]().mjcf)
    edit(root)
    return ET.tostring(root, encoding="unicode")


def comparison(machine: str, mjcf: str) -> MachineComparison:
    """A model against a machine, by the exact motions of both."""
    question = LoopRequest(dict(MACHINES[machine]().drives), seconds=1.0)
    own = _LoopBench.from_request(mujoco.MjModel.from_xml_string(mjcf), question).machine
    return compare_with_machine(
        machine, own.tree, machine_tree(machine), own.laws, own.held, own.motion(TIMES, order=2), tracked=own
    )


TILT = np.tan(np.radians(0.1))
DEFECTS: dict[str, tuple[Edit, str]] = {
    "a leg 0.1 % long": (
        shifted("site", "rod_end", "pos", lambda v: 1.001 * v),
        "rod is 0.1 % longer to rocker_pin: 420.42 mm instead of 420 mm",
    ),
    "an axis 0.1 deg off": (
        shifted("joint", "output", "axis", lambda v: v + np.array([0.0, TILT, 0.0])),
        "the axis of output is 0.1 deg off",
    ),
    "a closure anchored 0.1 mm off": (
        shifted("site", "rocker_pin", "pos", lambda v: v + np.array([0.0, 1e-4, 0.0])),
        "rocker_pin is 0.1 mm off its place on rocker",
    ),
}  # fmt: skip


@pytest.mark.parametrize("defect", DEFECTS)
def test_a_planted_defect_is_named_with_what_it_moves(defect: str) -> None:
    edit, words = DEFECTS[defect]
    found = comparison("rssr", edited("rssr", edit))
    assert found.differences == (words,)
    assert found.off > 1e-5


@pytest.mark.parametrize("branch", [1.0, -1.0])
def test_comparison_names_other_branch_and_no_healthy_model(branch: float) -> None:
    found = comparison("rssr", MACHINES["rssr"](branch=branch).mjcf)
    assert found.other_branch == (branch < 0.0)
    assert (found.off < 1e-12) == (branch > 0.0)
    assert found.differences == ()


def test_motion_of_the_same_machine_is_tracked_once(monkeypatch: pytest.MonkeyPatch) -> None:
    question, machine = LoopRequest(dict(MACHINES["rssr"]().drives), seconds=1.0), machine_tree("rssr")
    own = _LoopBench.from_request(mujoco.MjModel.from_xml_string(MACHINES["rssr"]().mjcf), question).machine
    tracked, motion, track = list[DrivenTree](), own.motion(TIMES, order=2), DrivenTree.track_branch

    def count(self: DrivenTree, start: Array, duration: float) -> None:
        tracked.append(self)
        track(self, start, duration)

    monkeypatch.setattr(DrivenTree, "track_branch", count)
    once, twice = (
        compare_with_machine("rssr", own.tree, machine, own.laws, own.held, motion, tracked=known)
        for known in (own, None)
    )
    assert (once, len(tracked)) == (twice, 1)


def test_knots_are_the_same_when_tracked_one_by_one(monkeypatch: pytest.MonkeyPatch) -> None:
    question = LoopRequest(dict(MACHINES["bennett"]().drives))
    bench = _LoopBench.from_request(mujoco.MjModel.from_xml_string(MACHINES["bennett"]().mjcf), question)
    together, calls, close = bench.machine.knots, list[int](), DrivenTree.close_loops

    def count(self: DrivenTree, coordinates: Array, time: Array | float) -> tuple[Array, float]:
        calls.append(np.size(time))
        return close(self, coordinates, time)

    monkeypatch.setattr(DrivenTree, "close_loops", count)
    monkeypatch.setattr("conrod.exact.space.motion.KNOTS_TOGETHER", 1)
    bench.machine.track_branch(together[0].coordinates, bench.seconds)
    assert calls == [1] * 48
    for one, other in zip(together, bench.machine.knots, strict=True):
        assert one.time == other.time
        assert np.abs(one.coordinates - other.coordinates).max() < 1e-13
        assert np.abs(one.rates - other.rates).max() < 1e-9  # jerks of 250 rad/s^3


def test_poses_closed_together_are_those_closed_alone() -> None:
    machine = driven(four_bar(), {"crank": "60rpm"})
    start, times = machine.knots[0].coordinates, np.array([0.0, 0.02, 0.05])
    found, gap = machine.close_loops(np.repeat(start, 3, axis=1), times)
    alone = [machine.close_loops(start, float(time)) for time in times]
    assert np.abs(found - np.concatenate([pose for pose, _ in alone], axis=1)).max() < 1e-14
    assert gap == pytest.approx(max(one for _, one in alone), abs=1e-15)
    # Negative control: the one that cannot be closed is named by where its crank is.
    start = np.repeat(start, 3, axis=1)
    start[1:, 1] = math.nan
    with pytest.raises(InvalidInput, match=f"its loops do not close {machine.describe_drives(0.02)}"):
        machine.close_loops(start, times)


def test_other_branch_is_named_with_the_point_furthest_off() -> None:
    machine, own = (driven(four_bar(frame="", branch=branch), {"crank": "60rpm"}) for branch in (1.0, -1.0))
    motion, exact = own.motion(TIMES, order=2), machine.motion(TIMES, order=2)
    found = compare_with_machine("bar", own.tree, machine.tree, machine.laws, (), motion)
    apart = {
        name: np.linalg.norm(motion.points[name].position - exact.points[name].position, axis=1).max()
        for name in motion.points
    }
    assert found.other_branch
    assert found.point == max(apart, key=lambda name: apart[name]) != "A"
    assert found.off == pytest.approx(apart[found.point])


def test_other_branch_is_tracked_to_the_last_of_few_instants() -> None:
    # The last instant is more than half a turn after the one before it: from there the pose is not found.
    machine, own = (driven(four_bar(frame="", branch=branch), {"crank": "60rpm"}) for branch in (1.0, -1.0))
    motion = own.motion(np.array([0.0, 0.01, 0.6]), order=2)
    assert compare_with_machine("bar", own.tree, machine.tree, machine.laws, (), motion).other_branch


def test_other_branch_is_told_by_where_both_motions_begin() -> None:
    # The branches are mirror images about the ground. A point M of the coupler that is on the ground with the crank at
    # -1 rad on one branch is there with the crank at 1 rad on the other: where that begins, this one ends.
    height = {name: pin[1] for name, pin in (("A", 0.1 * np.sin([0.0, -1.0])), ("B", rocker_pin(GRASHOF, -1.0)))}
    along = GRASHOF[1] * height["A"] / (height["A"] - height["B"])
    text = f'<site name="M" pos="{float(along)!r} 0 0"/><site name="B"'
    law, way = {"crank": f"move:{math.degrees(1.0)!r}deg,{math.degrees(-1.0)!r}deg,1s"}, np.array([0.0, 1.0])
    machine, own = (driven(four_bar(frame="", branch=b).replace('<site name="B"', text), law) for b in (1.0, -1.0))
    motion, exact = own.motion(way, order=2), machine.motion(way, order=2)
    motion = replace(motion, points={"M": motion.points["M"]})
    assert exact.points["M"].position[1] == pytest.approx(motion.points["M"].position[0], abs=1e-12)
    assert np.abs(exact.points["M"].position[0] - motion.points["M"].position[0]).max() > 0.01
    assert compare_with_machine("bar", own.tree, machine.tree, machine.laws, (), motion).other_branch


def test_a_defect_that_stops_the_study_is_named_in_its_line(tmp_path: Path) -> None:
    path = tmp_path / "own.xml"
    path.write_text(edited("rssr", without_a_loop), encoding="utf-8")
    with pytest.raises(InvalidInput, match="it has no closed loop; against rssr: loop rocker_pin is missing"):
        study_loops(path, LoopRequest(dict(MACHINES["rssr"]().drives), machine="rssr"), "own")


def bench_of(text: str, drives: dict[str, str], seconds: float | None = None, step: float = 5e-3) -> _LoopBench:
    model = mujoco.MjModel.from_xml_string(text)
    model.opt.timestep = step
    return _LoopBench.from_request(model, LoopRequest(drives, seconds=seconds))


@cache
def machine_bench(name: str, seconds: float | None = None, step: float = 5e-3) -> _LoopBench:
    machine = MACHINES[name]()
    return bench_of(machine.mjcf, dict(machine.drives), seconds, step)


def travel(bench: _LoopBench) -> float:
    motion = bench.machine.motion(np.linspace(0.0, bench.seconds, 60))
    return max(np.ptp(motion.points[point.name].position, axis=0).max() for point in bench.points)


# -- convergence -------------------------------------------------------------------------------------------------------

# A drive at constant speed, and three that turn back at once. Steps [s] of tuned and hardened.
CASES = [("rssr", 0.4, 1e-3, 4e-3), pytest.param("delta", 1.0, 1e-3, 5e-3, marks=pytest.mark.slow)]


@pytest.mark.parametrize(("name", "seconds", "tuned", "hardened"), CASES)
def test_hardened_converges_with_order_4_and_tuned_with_2(
    name: str, seconds: float, tuned: float, hardened: float
) -> None:
    for label, step, orders in (("tuned", tuned, {"position": 2.0}),
                                ("hardened", hardened, {"position": 4.0, "velocity": 4.0})):  # fmt: skip
        bench = machine_bench(name, seconds, step)
        runs = {n: bench._run(label, n, travel(bench), {}) for n in (1.0, 2.0, 4.0)}
        assert all(run.outcome is Outcome.COMPLETED for run in runs.values())
        for quantity, order in orders.items():
            claimed = claimed_order((int(n), run.errors[quantity]) for n, run in runs.items())
            assert claimed == pytest.approx(order, abs=0.25), (label, quantity)
    assert runs[4.0].errors["position"] < 1e-8 * travel(bench)


def test_forces_of_a_hardened_run_are_the_exact_ones() -> None:
    run = machine_bench("rssr", 0.4, 4e-3)._run("hardened", 4.0, 1.0, {})
    assert max(run.drives["input"], run.reactions["rocker_pin"]) < 1e-6


# -- kinematic mode, and defects of the engine's model alone -----------------------------------------------------------


@pytest.mark.parametrize("name", [n if n in ("rssr", "cardan") else pytest.param(n, marks=pytest.mark.slow)
                                  for n in MACHINES])  # fmt: skip
def test_mujoco_places_a_machine_as_its_exact_motion_does(name: str) -> None:
    bench = machine_bench(name, 0.5)
    shares, remarks = compare_kinematics(
        bench.model, bench.machine, bench.points, bench.machine.motion(np.linspace(0.0, 0.5, 12))
    )
    assert max(shares.values()) < 1e-12
    assert remarks == ()


@pytest.mark.parametrize("defect", DEFECTS)
def test_engine_model_defect_shows_in_kinematic_mode_and_runs(defect: str) -> None:
    bench, model = machine_bench("rssr", 0.4, 4e-3), mujoco.MjModel.from_xml_string(edited("rssr", DEFECTS[defect][0]))
    model.opt.timestep = bench.model.opt.timestep
    shares, _ = compare_kinematics(model, bench.machine, bench.points, bench.machine.motion(np.linspace(0, 0.4, 9)))
    assert max(shares["position"], shares["closures"]) > 1e4 * KINEMATIC_TOLERANCE
    # And so much more than a healthy run is off.
    healthy, planted = (
        b._run("hardened", 4.0, travel(bench), {}).errors["position"] for b in (bench, replace(bench, model=model))
    )
    assert planted > 1e-5 > 1e3 * healthy


# -- defects of a recorded run -----------------------------------------------------------------------------------------


def recorded(bench: _LoopBench, label: str = "hardened") -> tuple[LoopRecording, Callable[[LoopRecording], LoopRun]]:
    """A run, and how it is judged."""
    step = float(bench.model.opt.timestep)
    motion = bench.machine.motion(step * np.arange(int(bench.seconds / step + 1e-9) + 1))
    model, size = with_settings(bench.model, label, step, bench.seconds), travel(bench)
    run = driven_run(bench.machine, model, motion, bench.points, 1)
    exact = forces(bench.machine, motion)
    return run, lambda other: judge_run(label, step, other, motion, bench.machine, exact, size)


@cache
def four_bar_run(branch: float = 1.0) -> tuple[LoopRecording, Callable[[LoopRecording], LoopRun]]:
    return recorded(bench_of(four_bar(branch=branch), {"crank": "60rpm"}, seconds=0.4))


def test_a_run_on_the_other_branch_is_flipped_and_not_completed() -> None:
    (right, judge), (wrong, other_judge) = four_bar_run(), four_bar_run(-1.0)
    assert judge(right).outcome is other_judge(wrong).outcome is Outcome.COMPLETED
    flipped = judge(wrong)
    assert flipped.outcome is Outcome.FLIPPED
    assert flipped.reason.startswith("on another branch with crank at ")
    assert flipped.errors == {}
    assert flipped.gap < 1e-6  # closed, all the same


def test_a_soft_run_that_is_far_off_is_on_its_branch() -> None:
    # As it is, the rocker of the RSSR is off by more than a twentieth of its travel: softness, and no flip.
    bench = machine_bench("rssr", None, 2e-3)
    assert bench._run(OWN_SETTINGS, 1.0, travel(bench), {}).outcome is Outcome.COMPLETED


def test_late_stamp_is_an_error_and_open_or_ended_run_an_outcome() -> None:
    run, judge = four_bar_run()
    late = {name: np.concatenate([found[:, :1], found[:, :-1]], axis=1) for name, found in run.points.items()}
    shifted, healthy = judge(replace(run, points=late)), judge(run)
    assert shifted.errors["position"] > max(1e-4, 1e3 * healthy.errors["position"])
    opened = judge(replace(run, violations={"pin": np.full(len(run.times), 0.1)}))
    assert (opened.outcome, opened.reason, opened.errors) == (Outcome.OPENED, "pin opens by 100 mm", {})
    ended = judge(replace(run, outcome=Outcome.DIVERGED, reason="not finite at 0.1 s"))
    assert (ended.outcome, ended.errors) == (Outcome.DIVERGED, {})


def test_actuation_that_the_model_switches_off_stays_off() -> None:
    motor, points = '<actuator><position joint="rocker" kp="500"/></actuator>', {}
    for flag in ("enable", "disable"):
        text = four_bar(more=motor).replace("<flag ", f'<flag actuation="{flag}" ')
        points[flag] = recorded(bench_of(text, {"crank": "60rpm"}, seconds=0.1), OWN_SETTINGS)[0].points["C"]
    plain = recorded(bench_of(four_bar(), {"crank": "60rpm"}, seconds=0.1), OWN_SETTINGS)[0].points["C"]
    assert points["disable"] == pytest.approx(plain, abs=1e-12)
    assert np.abs(points["enable"] - plain).max() > 1e-6
