"""Change points: the exact motion goes on smoothly through them, and nowhere else."""

from __future__ import annotations

import math
from functools import cache
from typing import Any

import numpy as np
import pytest
from described import CATALOGUE, tables, with_entry

from conrod.comparison.outcome import judge_outcome
from conrod.comparison.trajectory import BodyStates, BodyTracks, Outcome
from conrod.engines import engine_named
from conrod.errors import InvalidInput
from conrod.exact import branch_tracking as smooth_course
from conrod.exact.kinematics import Kinematics
from conrod.exact.motion import Array, Instants
from conrod.execution.result import Plan
from conrod.scenes.described_scene import DescribedScene, scene_from_tables
from conrod.studies.validation.dynamic_mode import validate_dynamic

PARALLELOGRAM, DOUBLE_ROCKER = CATALOGUE / "parallelogram.toml", CATALOGUE / "double-rocker.toml"
START, CRANK, GROUND = math.radians(60.0), 0.1, 0.25
CHANGES = np.radians([120.0, 300.0])
# Beside a change point, from rounding to outside the window of its series, and in later turns.
BESIDE = [0.0, 1e-15, 1e-12, 1e-9, 1e-6, 1e-3, 0.05, 0.0799, 0.0801, 0.12]
CENTRES = (*CHANGES, CHANGES[0] - 2.0 * math.pi)
ANGLES = np.concatenate(
    [np.linspace(-7.0, 14.0, 401), *(centre + side * np.array(BESIDE) for centre in CENTRES for side in (1.0, -1.0))]
)


@pytest.fixture(scope="module")
def parallelogram() -> DescribedScene:
    return scene_from_tables(tables(PARALLELOGRAM))


def circle(turn: Array, centre: float) -> list[Array]:
    """Position of the end of a crank of the ground, and its derivatives by the turn."""
    away = np.column_stack([np.cos(turn), np.sin(turn)]) * CRANK
    across = np.column_stack([-np.sin(turn), np.cos(turn)]) * CRANK
    return [away + np.array([centre, 0.0]), across, -away, -across]


def errors(scene: DescribedScene, point: str, centre: float, angle: Array, start: float = START) -> list[float]:
    """Largest errors of position, velocity, acceleration and jerk at unit speed, over the travel."""
    motion = scene.motion(angle, 1.0).point(point)
    found = (motion.position, motion.velocity, motion.acceleration, motion.jerk)
    exact = circle(angle + start, centre)
    return [float(np.abs(f - e).max()) / (2.0 * CRANK) for f, e in zip(found, exact, strict=True)]


def with_third_crank() -> dict[str, Any]:
    """Three coupled wheels, as of a locomotive: both loops have their change points at once."""
    whole = tables(PARALLELOGRAM)
    whole["bodies"]["rod"] = {"points": {"B": [0, 0], "C": [0.3, 0]}, "uniform": "bar", "mass": 2.0}
    whole["bodies"]["third"] = {"points": {"O": [0, 0], "C": [CRANK, 0]}, "uniform": "bar", "mass": 1.0}
    whole["ground"]["points"]["O6"] = [GROUND + 0.3, 0]
    pins = {"B2": ["follower.B", "rod.B"], "C": ["rod.C", "third.C"], "O6": ["ground.O6", "third.O"]}
    whole["joints"] |= {name: {"kind": "revolute", "connects": ends} for name, ends in pins.items()}
    whole["start"]["rod"] = {"turn": 0}
    whole["observed"]["C"] = "third.C"
    return whole


def test_parallelogram_change_points_have_all_links_in_line(
    parallelogram: DescribedScene,
) -> None:
    assert parallelogram.kinematics.turns_fully
    assert np.abs(parallelogram.kinematics.change_angles - CHANGES).max() < 1e-12


def test_motion_at_change_points_matches_closed_form(parallelogram: DescribedScene) -> None:
    position, velocity, acceleration, jerk = errors(parallelogram, "B", GROUND, ANGLES)
    assert position < 1e-13
    assert velocity < 1e-12
    assert acceleration < 2e-11
    assert jerk < 1e-9


def test_crank_is_blocked_without_change_point_steps(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(smooth_course, "find_change_point", lambda *_: None)
    # Another name, so that no solved machine is at hand.
    with pytest.raises(InvalidInput, match="cannot turn fully"):
        scene_from_tables(with_entry(PARALLELOGRAM, "name", "not-stepped-over"))


def test_loops_may_share_one_change_point() -> None:
    scene = scene_from_tables(with_third_crank())
    assert np.abs(scene.kinematics.change_angles - CHANGES).max() < 1e-12
    found = errors(scene, "C", GROUND + 0.3, ANGLES[::3])
    assert found[0] < 1e-13
    assert found[3] < 1e-9


@cache
def antiparallelogram() -> Kinematics:
    """The other assembly of the same links."""
    whole = tables(PARALLELOGRAM)
    a, o = np.array([CRANK * math.cos(START), CRANK * math.sin(START)]), np.array([GROUND, 0.0])
    along = (o - a) / np.linalg.norm(o - a)
    b = a + np.array([GROUND, 0.0])
    whole["start"] = {"coupler": {"B": list(map(float, 2.0 * (a + along * (along @ (b - a))) - b))}}
    return scene_from_tables(whole).kinematics


def test_antiparallelogram_stays_on_its_branch() -> None:
    """tan(crank / 2) / tan(follower / 2) is constant, -(ground - crank) / (ground + crank) (half-angle formulas)."""
    kinematics, angle = antiparallelogram(), np.linspace(0.01, 6.28, 300)
    follower = kinematics.poses(angle)[:, 3 * kinematics.mechanism.body_index["follower"] + 2]
    ratio = np.tan(0.5 * (angle + START)) / np.tan(0.5 * follower)
    assert np.abs(kinematics.change_angles - CHANGES).max() < 1e-9
    assert np.abs(ratio + (GROUND - CRANK) / (GROUND + CRANK)).max() < 1e-8


@pytest.mark.parametrize("before", [1e-4, 0.5])
def test_start_just_before_change_point_is_accepted(before: float) -> None:
    start = math.pi - math.radians(before)
    scene = scene_from_tables(with_entry(PARALLELOGRAM, "driver.start", start))
    assert scene.kinematics.change_angles[0] == pytest.approx(math.radians(before), abs=1e-11)
    assert errors(scene, "B", GROUND, np.linspace(0.0, 7.0, 200), start)[0] < 1e-12


@pytest.mark.parametrize("start", [0.0, math.pi])
def test_start_at_change_point_is_refused_with_hint(start: float) -> None:
    with pytest.raises(InvalidInput, match="a dead centre or a change point"):
        scene_from_tables(with_entry(PARALLELOGRAM, "driver.start", start))


@pytest.mark.parametrize("stop", [119.9, 120.0, 120.1])
def test_pass_may_end_at_change_point(stop: float) -> None:
    whole = with_entry(PARALLELOGRAM, "driver.from", 0.0)
    whole["driver"]["to"] = math.radians(stop)
    scene = scene_from_tables(whole)
    assert max(errors(scene, "B", GROUND, np.linspace(0.0, math.radians(stop), 50))[:2]) < 1e-12


def test_near_parallelogram_has_no_change_point() -> None:
    scene = scene_from_tables(with_entry(PARALLELOGRAM, "bodies.follower.points.B", [CRANK + 1e-8, 0]))
    assert not scene.kinematics.change_angles.size
    follower = scene.kinematics.poses(np.linspace(0.0, 2.0 * math.pi, 100))[:, -1]
    assert np.ptp(follower) < math.pi  # it rocks; that of a parallelogram goes round


def test_dead_centre_is_no_change_point() -> None:
    """The double rocker's input ends where coupler and follower lie in line, b + c = 100 mm apart: at acos(0.4)."""
    whole = with_entry(DOUBLE_ROCKER, "driver.from", None)
    del whole["driver"]["to"]
    with pytest.raises(InvalidInput, match=r"reaches -22.67 to 21.42 deg"):
        scene_from_tables(whole)
    kinematics = scene_from_tables(tables(DOUBLE_ROCKER)).kinematics
    assert kinematics.reachable_angle(math.pi) == pytest.approx(math.acos(0.4) - math.radians(45.0), abs=1e-7)
    assert not kinematics.change_angles.size


def test_run_flips_when_it_leaves_smooth_continuation(
    parallelogram: DescribedScene,
) -> None:
    kinematics, angle = parallelogram.kinematics, np.linspace(0.0, 4.0 * math.pi, 2001)
    smooth = kinematics.poses(angle)
    assert set(kinematics.branch(smooth)) == {-1.0, 1.0}  # though the determinant changes its sign
    other = np.where((angle > CHANGES[0])[:, None], antiparallelogram().poses(angle), smooth)
    for poses, outcome in ((smooth, Outcome.COMPLETED), (other, Outcome.FLIPPED)):
        still = np.zeros_like(poses)
        states = BodyStates(Instants(angle, angle, np.ones_like(angle), np.zeros_like(angle)), poses, still, still)
        assert judge_outcome(kinematics, BodyTracks(states, states, states), 1.0).outcome is outcome


def test_run_through_change_points_is_not_judged(parallelogram: DescribedScene) -> None:
    slider_crank = scene_from_tables(tables(CATALOGUE / "slider-crank.toml"))
    for scene, judged in ((parallelogram, False), (slider_crank, True)):
        plan = Plan(steps_per_revolution=80, revolutions=1.0)
        assert (validate_dynamic(scene.kind, scene, engine_named("pymunk"), "tuned", plan).passed is None) is not judged
