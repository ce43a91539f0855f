"""Errors told from the joints' gaps alone are the errors measured against the exact motion (guard 6)."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from conrod.engines import engine_named
from conrod.engines.running import whole_run
from conrod.runs.comparison import compare, predicted_errors, signed_error
from conrod.scenes import SCENES, CamFollower, Saw, Scene, ShearPress

QUANTITIES = ("position", "velocity", "acceleration")
RUNS = [
    *(
        (name, engine, preset)
        for name in ("shear-press", "saw-500rpm")
        for engine, presets in (("mujoco", ("stock", "tuned", "hardened")), ("pymunk", ("stock", "tuned")))
        for preset in presets
    ),
    *(("cam-follower", engine, "tuned") for engine in ("mujoco", "pymunk")),
]


def run(scene: Scene, engine: str, preset: str) -> Any:
    steps = 4000 if isinstance(scene, CamFollower) else 500
    made = engine_named(engine)
    return whole_run(made, scene, made.presets[preset](scene, steps), 1.0)


def largest_difference(scene: Scene, trajectory: Any, ruler: Scene) -> dict[str, float]:
    """Measured against a ruler minus told from the scene's joints, normalised."""
    told = predicted_errors(scene.kinematics, trajectory.points, trajectory.bodies)
    sizes = {}
    for k, quantity in enumerate(QUANTITIES):
        sizes[quantity] = 0.0
        for name, tracks in trajectory.points.items():
            measured = signed_error(getattr(tracks, quantity), ruler, name, quantity)
            off = np.linalg.norm(measured - told[name][quantity], axis=1).max()
            sizes[quantity] = max(sizes[quantity], float(off) / (scene.lengths[name] * abs(scene.speed) ** k))
    return sizes


@pytest.mark.parametrize(("name", "engine", "preset"), RUNS)
def test_the_error_told_from_the_gaps_is_the_measured_one_to_second_order(name: str, engine: str, preset: str) -> None:
    scene = SCENES[name]
    trajectory = run(scene, engine, preset)
    measured = compare(trajectory, scene)
    for quantity, off in largest_difference(scene, trajectory, scene).items():
        # One Newton step leaves the square of the position error, by a curvature of order one, in every quantity.
        remainder = measured.worst("position") * max(measured.worst("position"), measured.worst(quantity))
        assert off <= 2.0 * remainder + 1e-13, (quantity, off)


@pytest.mark.parametrize(
    ("scene", "wrong"),
    [(Saw(), Saw(rod=0.3 * 1.0001)), (ShearPress(), ShearPress(rod=0.390 * 1.0001))],
    ids=["saw", "press"],
)
def test_a_wrong_ruler_is_told_from_a_wrong_engine(scene: Scene, wrong: Scene) -> None:
    trajectory = run(scene, "mujoco", "hardened")
    assert largest_difference(scene, trajectory, scene)["position"] < 1e-12
    # Negative control: a rod 0.01 % too long in the ruler, and the gaps do not account for what is measured.
    assert largest_difference(scene, trajectory, wrong)["position"] > 1e-5
