"""How far bodies are off, for moving drawings: the same wherever a run is cut, and what the errors of points say."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from conrod.engines import engine_named
from conrod.scenes import SCENES
from conrod.studies.validation.plan import POSES, Plan, validate_dynamic
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
