"""How far bodies are off, for moving drawings: the same wherever a run is cut, and what the errors of points say."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from conrod.engines import engine_named
from conrod.engines.running import followed
from conrod.runs.comparison import Stretch
from conrod.scenes import SCENES
from conrod.studies.validation.plan import POSES, DrawnPoses, Plan, validate_dynamic
from conrod.studies.validation.results import ValidationResult

SCENE = SCENES["saw-500rpm"]


def off(run: ValidationResult) -> float:
    """Largest distance of the point C from its place [L], by the bodies' poses."""
    assert run.poses is not None
    poses = SCENE.kinematics.poses(run.poses.angle) + run.poses.values
    places = SCENE.kinematics.point_derivatives([poses])["C"][0]
    exact = SCENE.motion(run.poses.angle, SCENE.speed).point("C").position
    return float(np.linalg.norm(places - exact, axis=1).max() / SCENE.lengths["C"])


def test_errors_of_poses_are_those_of_the_points_and_a_planted_one_is_not() -> None:
    run = validate_dynamic("saw-500rpm", SCENE, engine_named("pymunk"), "stock", Plan(240))
    assert run.errors is not None
    assert run.poses is not None
    assert run.errors["C"]["position"] is not None
    assert run.poses.values.shape == (POSES + 1, 9)
    assert off(run) == pytest.approx(run.errors["C"]["position"]["max"], rel=0.02)
    planted = replace(run.poses, values=1.1 * run.poses.values)
    assert off(replace(run, poses=planted)) != pytest.approx(run.errors["C"]["position"]["max"], rel=0.02)


def test_they_do_not_depend_on_how_a_run_is_cut() -> None:
    engine, whole, found = engine_named("pymunk"), DrawnPoses(SCENE, 240), []

    class Kept:
        def add(self, stretch: Stretch) -> None:
            found.append(stretch)

    followed(engine, SCENE, engine.presets["stock"](SCENE, 240), 2.0, 0.0, whole, Kept())
    one = found[0]
    assert len(found) == 1
    cut = DrawnPoses(SCENE, 240)
    states, count = one.bodies.position, len(one.bodies.position.poses)
    for first, last in ((0, 7), (7, 300), (300, count)):
        part = replace(
            states, instants=states.instants[first:last], poses=states.poses[first:last],
        )  # fmt: skip
        trajectory = replace(one.trajectory, bodies=replace(one.bodies, position=part))
        cut.add(replace(one, trajectory=trajectory, left=count - last))
    np.testing.assert_array_equal(cut.errors.angle, whole.errors.angle)
    np.testing.assert_array_equal(cut.errors.values, whole.errors.values)
