"""Kinematic mode far from the start, and near the limits of an input."""

from __future__ import annotations

import numpy as np
import pytest

from conrod.engines import engine_named
from conrod.engines import numerics as approach
from conrod.engines.pymunk import engine as pymunk_kinematic
from conrod.exact.motion import Array
from conrod.scenes.catalogue import catalogue_scene

# At -60 deg slider C has two places on its line that the rod BC reaches.
FAR = np.radians([-60.0])
LINKAGE = "two-slider-linkage"


def off(engine: str, angle: Array, rate: bool = False) -> float:
    """Largest error of a point's position over L, or of its velocity over L times the crank's speed."""
    scene = catalogue_scene(LINKAGE).with_parameters(**{"driver.to": float(np.radians(60.0))})
    solved, exact = engine_named(engine).solve_kinematics(scene, angle), scene.motion(angle, scene.speed)
    worst = 0.0
    for name, (position, velocity) in solved.points.items():
        assert velocity is not None
        error = (velocity - exact.point(name).velocity) / scene.speed if rate else position - exact.point(name).position
        worst = max(worst, float(np.linalg.norm(error, axis=1).max()) / scene.lengths[name])
    return worst


@pytest.mark.parametrize("engine", ["mujoco", "pymunk"])
def test_an_angle_far_from_the_start_is_solved_on_the_branch_of_the_start(engine: str) -> None:
    assert off(engine, FAR) < 1e-12
    assert off(engine, FAR, rate=True) < 1e-9


def test_newton_iteration_from_the_start_alone_finds_another_assembly(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(approach, "LONGEST_STEP", 10.0)
    assert off("mujoco", FAR) > 0.1


def test_rates_of_badly_conditioned_joints_are_solved_until_they_fit(monkeypatch: pytest.MonkeyPatch) -> None:
    # Where rod BC stands nearly across the slide of C.
    angle = np.radians(np.linspace(25.0, 45.0, 5))
    assert off("pymunk", angle, rate=True) < 1e-11
    monkeypatch.setattr(pymunk_kinematic, "RATE_SOLVES", 1)
    assert off("pymunk", angle, rate=True) > 1e-9
