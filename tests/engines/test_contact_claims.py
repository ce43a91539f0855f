"""What contact is judged by: the cam's polygon, the stamps of velocities, the bar of the force."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from benchmarks.healthy import variant
from conrod.engines import engine_named
from conrod.engines.capabilities import expected_error
from conrod.engines.running import whole_run
from conrod.runs.comparison import ExactMotions
from conrod.scenes.catalogue import scene_named

CAM = "cam-3-4-5"


@pytest.mark.parametrize("cam", [CAM, "cam-follower"], ids=["of laws", "of arcs"])
@pytest.mark.parametrize("engine", ["mujoco", "pymunk"])
def test_the_polygons_error_is_the_one_that_its_shape_has(engine: str, cam: str) -> None:
    """Held still, the follower is off by the polygon alone: by no more than is said, and by a good part of it."""
    scene, made = scene_named(cam), engine_named(engine)
    angles = scene.kinematics.angles(90)
    solved: Any = made.solve_kinematics(scene, angles)  # type: ignore[attr-defined]
    exact = scene.motion(angles, scene.speed)
    off = max(np.abs(position - exact.point(name).position).max() for name, (position, _) in solved.points.items())
    assert 0.3 * solved.shape_error < off <= solved.shape_error


def test_a_pushed_followers_velocity_belongs_to_its_sample() -> None:
    """Half a step early or late it would be off by half a step of its acceleration."""
    scene, made = scene_named(CAM), engine_named("pymunk")
    run = whole_run(made, scene, made.presets["tuned"](scene, 4000), 1.0)
    ((name, tracks),) = run.points.items()
    at = tracks.velocity.instants
    off = ExactMotions(scene).error(tracks.velocity, name, "velocity")
    exact = scene.motion(at.angle, at.rate, at.acceleration).point(name).acceleration
    axis = int(np.abs(exact).sum(axis=0).argmax())
    pushed = exact[:, axis] > 0.0
    off, exact = off[pushed, axis], exact[pushed, axis]
    lag = float((off * exact).sum() / (exact**2).sum()) / run.settings.timestep  # [steps]
    assert abs(lag) < 0.15


def test_a_follower_that_does_not_touch_yet_falls_in_the_first_step_and_the_law_says_so() -> None:
    """The least error of a start without contact is the fall: it is the law's position, and more than any sinking."""
    scene, steps, _ = variant(scene_named(CAM), 1)
    made = engine_named("mujoco")
    settings = made.presets["tuned"](scene, steps)
    run = whole_run(made, scene, settings, 1.0)
    ((name, tracks),) = run.points.items()
    off = ExactMotions(scene).error(tracks.position, name, "position")
    sizes = np.linalg.norm(off, axis=1) / scene.lengths[name]
    law = expected_error(made, scene, settings)
    assert int(np.argmax(sizes)) == 1
    assert law.position is not None
    assert 0.9 * law.position < sizes.max() <= law.position
    assert np.sort(sizes)[-3] < 0.9 * sizes.max()  # which no other part of the law explains
