"""Every way that a run can end is recognised, and none but a completed run has errors."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from catalogue import CAM, DEFECTIVE_LINKAGES, LINKAGES, SAW, SCENES
from synthetic import TOGETHER, body_states, instants, longer_rod, other_branch, synthetic_trajectory

from conrod import Outcome, compare
from conrod.comparison.outcome import (
    MAX_CONTACT_GAP,
    MAX_JOINT_GAP,
    MAX_REACH_SIZES,
    MAX_SPEED_ERROR,
    RunVerdict,
    combine_verdicts,
    judge_outcome,
)
from conrod.comparison.trajectory import BodyStates, BodyTracks
from conrod.execution.resolve_arguments import select_scene
from conrod.scenes import ShearPress

Change = Callable[[BodyStates], BodyStates]


@cache
def exact_states(scene: Any) -> BodyStates:
    return body_states(scene.kinematics, instants(scene.speed, 2.0))


def verdict(scene: Any, change: Change = lambda states: states) -> RunVerdict:
    """The judgement of an exact run with a change to its body states."""
    states = change(exact_states(scene))
    return judge_outcome(scene.kinematics, BodyTracks(states, states, states), scene.speed)


def moved(body: int, way: tuple[float, float], first: int = 0) -> Change:
    """Shifts a body by `way` [m] from a sample on."""

    def change(states: BodyStates) -> BodyStates:
        poses = states.poses.copy()
        poses[first:, 3 * body : 3 * body + 2] += way
        return replace(states, poses=poses)

    return change


def with_rate(ratio: float, first: int) -> Change:
    """A crank that runs at a share of its speed from a sample on (its angles stay what they are)."""

    def change(states: BodyStates) -> BodyStates:
        rate = states.instants.rate.copy()
        rate[first:] *= ratio
        return replace(states, instants=replace(states.instants, rate=rate))

    return change


@pytest.mark.parametrize("name", SCENES)
def test_exact_run_is_completed_without_reason(name: str) -> None:
    assert verdict(SCENES[name]) == RunVerdict(Outcome.COMPLETED)


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
@pytest.mark.parametrize("field", ["poses", "rates", "accelerations"])
@pytest.mark.parametrize("level", ["position", "velocity", "acceleration"])
def test_run_is_diverged_when_state_is_not_finite(level: str, field: str, bad: float) -> None:
    scene = SAW
    states = exact_states(scene)
    values = getattr(states, field).copy()
    values[17, 4] = bad
    tracks = replace(BodyTracks(states, states, states), **{level: replace(states, **{field: values})})
    found = judge_outcome(scene.kinematics, tracks, scene.speed)
    assert found.outcome is Outcome.DIVERGED
    assert found.reason == f"not finite from {states.instants.times[17]:.6g} s on"


@pytest.mark.parametrize("name", SCENES)
def test_run_is_exploded_when_body_is_out_of_reach(name: str) -> None:
    scene = SCENES[name]
    far = 1.5 * MAX_REACH_SIZES * scene.kinematics.size
    found = verdict(scene, moved(1, (far, 0.0), first=31))
    assert found.outcome is Outcome.EXPLODED
    # Counted from where it starts, not from the crank's axis: the slider of a saw starts a size away from that.
    far = 0.95 * MAX_REACH_SIZES * SAW.kinematics.size
    assert verdict(SAW, moved(SAW.mechanism().body_index["slider"], (far, 0.0))).outcome is Outcome.OPENED
    assert f"from {exact_states(scene).instants.times[31]:.6g} s on" in found.reason


@pytest.mark.parametrize("name", LINKAGES)
@pytest.mark.parametrize("ratio", [0.0, 0.49, -1.0, 1.6])
def test_run_is_stalled_when_drive_loses_half_its_speed(name: str, ratio: float) -> None:
    # Away from every singular pose of the linkage: these linkages have none.
    found = verdict(LINKAGES[name], with_rate(ratio, 100))
    assert found.outcome is Outcome.STALLED
    assert found.reason.endswith(f" at {np.degrees(exact_states(LINKAGES[name]).instants.angle[100]):.1f} deg")


@pytest.mark.parametrize("ratio", [0.5, 0.99, 1.5])
def test_run_is_not_stalled_when_drive_keeps_half_its_speed(ratio: float) -> None:
    assert abs(ratio - 1.0) <= MAX_SPEED_ERROR
    assert verdict(SAW, with_rate(ratio, 100)).outcome is Outcome.COMPLETED


def test_run_is_locked_when_crank_stops_at_singular_pose() -> None:
    # Crank and rod all but equally long: at a quarter of a turn the rod lies across the slide.
    scene = ShearPress(crank=0.38999)
    quarter = int(np.argmax(exact_states(scene).instants.angle >= math.pi / 2))
    assert verdict(scene, with_rate(0.0, quarter)).outcome is Outcome.LOCKED

    def stop_early(states: BodyStates) -> BodyStates:
        poses = states.poses.copy()
        poses[quarter // 2 :] = poses[quarter // 2]
        return with_rate(0.0, quarter // 2)(replace(states, poses=poses))

    # The same stop at 45 degrees, far from there, is the drive's.
    assert verdict(scene, stop_early).outcome is Outcome.STALLED


@pytest.mark.parametrize("name", LINKAGES)
def test_run_is_opened_when_gap_is_a_twentieth_of_travel(name: str) -> None:
    scene = LINKAGES[name]
    slider = scene.mechanism().body_index["slider"]
    along = (0.0, 1.0) if isinstance(scene, ShearPress) else (1.0, 0.0)
    for share, expected in ((1.05, Outcome.OPENED), (0.95, Outcome.COMPLETED)):
        gap = share * MAX_JOINT_GAP * scene.kinematics.travel
        found = verdict(scene, moved(slider, (gap * along[0], gap * along[1]), first=40))
        assert found.outcome is expected
        assert ("slider-pin" in found.reason) == (expected is Outcome.OPENED)
        assert found.reason.endswith(f"gap up to {gap:.3g} m") == (expected is Outcome.OPENED)


def test_run_is_lost_contact_when_follower_leaves_cam() -> None:
    cam = CAM
    for share, expected in ((1.05, Outcome.LOST_CONTACT), (0.9, Outcome.COMPLETED)):
        lift = share * MAX_CONTACT_GAP * cam.kinematics.travel
        found = verdict(cam, moved(1, (0.0, lift), first=0))
        assert found.outcome is expected
    first = f"{np.degrees(exact_states(cam).instants.angle[100]):.1f}"
    found = verdict(cam, moved(1, (0.0, 0.01), first=100))
    assert found.sized_reason is not None
    assert (
        found.reason
        == f"{cam.mechanism().cam_contacts[0].name}: gap up to {found.sized_reason[1]:.3g} m, first near {first} deg"
    )


def test_run_is_tunnelled_when_roller_centre_is_inside_cam() -> None:
    cam = CAM
    found = verdict(cam, moved(1, (0.0, -2.0 * cam.roller_radius), first=50))
    assert found.outcome is Outcome.TUNNELLED
    assert found.sized_reason is not None
    name, deep = cam.mechanism().cam_contacts[0].name, found.sized_reason[1]
    assert deep == pytest.approx(2.0 * cam.roller_radius)
    assert found.reason == f"{name}: the roller's centre is {deep:.3g} m deep"


@pytest.mark.parametrize("name", DEFECTIVE_LINKAGES)
def test_run_is_flipped_when_linkage_is_on_other_branch(name: str) -> None:
    scene = DEFECTIVE_LINKAGES[name]
    other = body_states(other_branch(scene), instants(scene.speed, 2.0))

    def flip_half_way(states: BodyStates) -> BodyStates:
        half = len(states.poses) // 2
        poses = np.vstack([states.poses[:half], other.poses[half:]])
        return replace(states, poses=poses)

    found = verdict(scene, flip_half_way)
    assert found.outcome is Outcome.FLIPPED
    assert "360.0 deg" in found.reason  # half of two turns


def test_run_is_not_flipped_near_change_point() -> None:
    scene = select_scene("parallelogram", ())[1]
    states = exact_states(scene)
    assert verdict(scene).outcome is Outcome.COMPLETED
    # Negative control: the same poses a third of a turn later.
    later = replace(states, instants=replace(states.instants, angle=states.instants.angle - 2.0))
    assert verdict(scene, lambda _: later).outcome is Outcome.FLIPPED


def test_combine_verdicts_keeps_worse_outcome_and_larger_gap() -> None:
    slider = SAW.mechanism().body_index["slider"]
    small, large = (verdict(SAW, moved(slider, (share * SAW.kinematics.travel, 0.0))) for share in (0.1, 0.2))
    assert combine_verdicts(small, large) == combine_verdicts(large, small) == large
    stalled = verdict(SAW, with_rate(0.0, 100))
    assert combine_verdicts(small, stalled) == combine_verdicts(stalled, small) == stalled
    # A gap of another joint, or a depth, is not one of this: the earlier is told.
    other = replace(large, reason="other", sized_reason=("other: gap up to", 1.0, " m"))
    assert combine_verdicts(small, other) == small
    assert combine_verdicts(other, small) == other
    deep = RunVerdict.of_size(Outcome.LOST_CONTACT, "slider-pin: gap up to", 1.0)
    assert combine_verdicts(small, deep) == deep
    states = exact_states(SAW)
    assert judge_outcome(SAW.kinematics, BodyTracks(states, states, states), SAW.speed, small) == small


@pytest.mark.parametrize("name", DEFECTIVE_LINKAGES)
def test_run_with_small_defect_is_completed(name: str) -> None:
    scene = DEFECTIVE_LINKAGES[name]
    states = body_states(longer_rod(scene), instants(scene.speed, 2.0))
    tracks = BodyTracks(states, states, states)
    assert judge_outcome(scene.kinematics, tracks, scene.speed).outcome is Outcome.COMPLETED
    assert compare(synthetic_trajectory(scene, longer_rod(scene), stamps=TOGETHER), scene).worst("position") > 1e-5


def test_a_run_judged_in_blocks_has_the_verdict_of_the_whole(monkeypatch: pytest.MonkeyPatch) -> None:
    late = len(exact_states(SAW).poses) - 3
    far = moved(1, (2.0 * MAX_REACH_SIZES * SAW.kinematics.size, 0.0), late)
    whole, healthy = verdict(SAW, far), verdict(SAW)
    monkeypatch.setattr("conrod.comparison.outcome.BLOCK_SAMPLES", 7)
    assert verdict(SAW, far) == whole
    assert whole.outcome is Outcome.EXPLODED
    assert verdict(SAW) == healthy == RunVerdict(Outcome.COMPLETED)
