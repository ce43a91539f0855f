"""Links' rotations of engines against the exact ones: judged like points, with slips planted in one link."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from conrod.comparison.compare import ComparedPiece
from conrod.comparison.plain_values import plain_values, restore
from conrod.comparison.run_errors import LinkSizes
from conrod.comparison.trajectory import BodyStates, BodyTracks, Piece
from conrod.engines import engine_named
from conrod.engines.run import run_in_one_piece
from conrod.exact.link_rotations import ROTATIONS, rotation_scales
from conrod.exact.motion import Array
from conrod.execution.result import Plan
from conrod.report.results import verdict_words
from conrod.scenes import catalogue_names, scene_named
from conrod.studies.detection.defects import Recording
from conrod.studies.detection.qualification import motion_judge
from conrod.studies.validation.dynamic_mode import prepare_run
from conrod.studies.validation.results import ValidationResult
from conrod.studies.validation.study import ValidationCase

SAW = scene_named("saw-40rpm")
RANGE = SAW.kinematics.rotation_ranges["rod"]
Judged = tuple[Recording, Callable[[Recording], ValidationResult]]


@pytest.fixture(scope="module", params=["mujoco", "pymunk"])
def run(request: pytest.FixtureRequest) -> Judged:
    """A recorded run of the saw at 500 steps a revolution, and its judge."""
    engine = engine_named(request.param)
    result, settings, start = prepare_run("saw-40rpm", SAW, engine, "tuned", Plan(500, 1.0))
    given = Recording.from_engine(engine, SAW, settings, result.revolutions, start)
    return given, motion_judge(result, SAW, None)


def plant(given: Recording, quantity: str, name: str, link: str, change: Callable[[Array], Array]) -> Recording:
    """The run with one link's column changed in the states that a quantity is taken from."""
    bodies = given.run.trajectory.bodies
    assert bodies is not None
    states: BodyStates = getattr(bodies, quantity)
    values, column = getattr(states, name).copy(), 3 * SAW.kinematics.mechanism.body_index[link] + 2
    values[:, column] = change(values[:, column])
    changed = BodyTracks(**{**vars(bodies), quantity: replace(states, **{name: values})})
    piece: Piece = replace(given.run, trajectory=replace(given.run.trajectory, bodies=changed))
    return replace(given, run=piece)


def test_healthy_links_are_within_and_their_law_is_sharp(run: Judged) -> None:
    given, judge = run
    result = judge(given)
    assert result.passed
    assert set(result.links or {}) == {"rod", "slider"}
    for quantity in ROTATIONS:
        link, size = result.largest_rotation(quantity)
        assert link == "rod"
        assert 0.5 * result.limits[quantity] < (size or 0.0) <= result.limits[quantity]


@pytest.mark.parametrize(("quantity", "name", "change", "words"), [
    ("position", "poses", lambda phi: phi + 1e-4, "rotation of rod"),
    ("velocity", "rates", lambda omega: 1.001 * omega, "angular velocity of rod"),
    ("acceleration", "accelerations", lambda alpha: 1.001 * alpha, "angular acceleration of rod"),
])  # fmt: skip
def test_slip_of_one_link_is_named_by_link_and_quantity(
    run: Judged, quantity: str, name: str, change: Callable[[Array], Array], words: str
) -> None:
    given, judge = run
    result = judge(plant(given, quantity, name, "rod", change))
    assert result.passed is False
    assert list(result.out_of_tolerance()) == [words]
    assert verdict_words(result).startswith(f"OUT OF TOLERANCE: {words} ")


def test_slipped_turn_is_an_error_of_a_whole_turn(run: Judged) -> None:
    given, judge = run
    slipped = plant(given, "position", "poses", "rod", lambda phi: phi + 2.0 * math.pi * (np.arange(len(phi)) > 200))
    assert judge(slipped).largest_rotation("rotation") == ("rod", pytest.approx(2.0 * math.pi / RANGE, rel=1e-3))


def test_link_that_does_not_rotate_is_compared_in_radians(run: Judged) -> None:
    given, judge = run
    tilted = judge(plant(given, "position", "poses", "slider", lambda phi: phi + 0.03))
    assert tilted.links is not None
    assert tilted.links["slider"]["rotation"]["max"] == pytest.approx(0.03)
    assert rotation_scales(SAW.kinematics) == {"rod": RANGE, "slider": 1.0}
    assert list(tilted.out_of_tolerance()) == ["rotation of slider"]


def test_sample_that_is_no_number_fails_the_link(run: Judged) -> None:
    given, judge = run

    def spoil(omega: Array) -> Array:
        return np.where(np.arange(len(omega)) == 7, math.nan, omega)

    assert judge(plant(given, "velocity", "rates", "rod", spoil)).passed is False


def test_link_errors_do_not_depend_on_how_a_run_is_cut() -> None:
    engine, settings = engine_named("pymunk"), engine_named("pymunk").presets["tuned"](SAW, 100)
    whole, cut = LinkSizes(), LinkSizes()
    whole.add(ComparedPiece(run_in_one_piece(engine, SAW, settings, 1.0), SAW))
    for piece in engine.run(SAW, settings, 1.0, steps=23):
        cut.add(ComparedPiece(piece.trajectory, SAW, 101 - piece.first_step - len(piece.clock)))
    assert cut.errors == whole.errors


def test_tolerance_of_a_rotation_may_be_asked_for() -> None:
    case = ValidationCase("saw-40rpm", SAW, "pymunk", "tuned", Plan(40, 1.0))
    found = case.perform()
    assert found.passed
    strict: Any = found.with_verdict({"angular_velocity": 1e-9})
    assert (strict.passed, list(strict.out_of_tolerance())) == (False, ["angular velocity of rod"])
    # A report of before has neither errors of links nor their tolerances.
    saved = plain_values(found)
    del saved["links"]
    for quantity in ROTATIONS:
        del saved["tolerance"][quantity]
    old = restore(ValidationResult, saved)
    assert (old.links, old.largest_rotation("rotation"), old.with_verdict().passed) == (None, ("", None), True)


@pytest.mark.parametrize("name", ["mujoco", "pymunk"])
def test_rotation_that_a_model_solves_wrongly_is_no_proof(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    engine, case = engine_named(name), ValidationCase("saw-40rpm", SAW, name, None, Plan())
    assert case.perform().passed
    solve, column = engine.solve_kinematics, 3 * SAW.kinematics.mechanism.body_index["rod"] + 2  # type: ignore[attr-defined]

    def solve_with_a_turned_rod(machine: Any, angle: Array) -> Any:
        solved = solve(machine, angle)
        poses = solved.poses.copy()
        poses[5, column] += 1e-9
        return replace(solved, poses=poses)

    monkeypatch.setattr(type(engine), "solve_kinematics", staticmethod(solve_with_a_turned_rod))
    result = case.perform()
    assert (result.passed, list(result.out_of_tolerance())) == (False, ["rotation of rod"])


# The parallelogram has a change point, and no engine a law there; cams have no link that rotates.
FEW = ("crank-shaper", "planetary-gear", "geneva")
MANY = [name for name in catalogue_names() if name not in FEW and not name.startswith("cam-")]


@pytest.mark.parametrize("name", [*FEW, *(pytest.param(name, marks=pytest.mark.slow) for name in MANY)])
def test_links_of_a_scene_are_within_the_law_in_mujoco(name: str) -> None:
    scene = scene_named(name)
    result = ValidationCase(name, scene, "mujoco", "tuned", Plan(250, 1.0)).perform()
    assert result.completed
    for quantity in ROTATIONS:
        limit, (link, size) = result.limits.get(quantity), result.largest_rotation(quantity)
        assert (limit is None) == ("position" not in result.limits)
        assert limit is None or (link and size is not None and size <= limit)
