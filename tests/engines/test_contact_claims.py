"""What contact is judged by: the cam's polygon, the stamps of velocities, the bar of the force."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import mujoco
import numpy as np
import pytest
from catalogue import CAM, CAMS

from conrod import MuJoCoSettings
from conrod.comparison.compare import ExactMotions
from conrod.engines import engine_named
from conrod.engines.capabilities import expected_error
from conrod.engines.mujoco.mjcf import mjcf_text
from conrod.engines.mujoco.model import compile_mjcf
from conrod.engines.run import run_in_one_piece
from conrod.engines.spanning_tree import machine_tree
from conrod.mjcf.document import first_difference
from conrod.scenes import scene_named
from docs.studies.healthy import variant

OF_LAWS = "cam-3-4-5"


@pytest.mark.parametrize("cam", [OF_LAWS, "cam-follower"], ids=["of laws", "of arcs"])
@pytest.mark.parametrize("engine", ["mujoco", "pymunk"])
def test_polygon_error_bounds_the_static_lift_error(engine: str, cam: str) -> None:
    """Held still, the follower is off by the polygon alone: by no more than is said, and by a good part of it."""
    scene, made = scene_named(cam), engine_named(engine)
    angles = scene.kinematics.angles(90)
    solved: Any = made.solve_kinematics(scene, angles)  # type: ignore[attr-defined]
    exact = scene.motion(angles, scene.speed)
    off = max(np.abs(position - exact.point(name).position).max() for name, (position, _) in solved.points.items())
    assert 0.3 * solved.shape_error < off <= solved.shape_error


def test_velocity_of_a_cam_follower_belongs_to_its_sample() -> None:
    """Half a step early or late it would be off by half a step of its acceleration."""
    scene, made = scene_named(OF_LAWS), engine_named("pymunk")
    run = run_in_one_piece(made, scene, made.presets["tuned"](scene, 4000), 1.0)
    ((name, tracks),) = run.points.items()
    at = tracks.velocity.instants
    off = ExactMotions(scene).error(tracks.velocity, name, "velocity")
    exact = scene.motion(at.angle, at.rate, at.acceleration).point(name).acceleration
    axis = int(np.abs(exact).sum(axis=0).argmax())
    pushed = exact[:, axis] > 0.0
    off, exact = off[pushed, axis], exact[pushed, axis]
    lag = float((off * exact).sum() / (exact**2).sum()) / run.settings.timestep  # [steps]
    assert abs(lag) < 0.15


def test_error_law_includes_the_fall_of_a_start_without_contact() -> None:
    """The least error of a start without contact is the fall: it is the law's position, and more than any sinking."""
    scene, steps, _ = variant(scene_named(OF_LAWS), 1)
    made = engine_named("mujoco")
    settings = made.presets["tuned"](scene, steps)
    run = run_in_one_piece(made, scene, settings, 1.0)
    ((name, tracks),) = run.points.items()
    off = ExactMotions(scene).error(tracks.position, name, "position")
    sizes = np.linalg.norm(off, axis=1) / scene.lengths[name]
    law = expected_error(made, scene, settings)
    assert int(np.argmax(sizes)) == 1
    assert law.position is not None
    assert 0.9 * law.position < sizes.max() <= law.position
    assert np.sort(sizes)[-3] < 0.9 * sizes.max()  # which no other part of the law explains


# -- meshes whose convex hull MuJoCo keeps -----------------------------------------------------------------------------


def text_of(scene: Any, steps: int = 1000, **changes: Any) -> str:
    settings = replace(MuJoCoSettings.tuned(scene, steps), **changes)
    return mjcf_text(machine_tree(scene), settings, "model")


def test_a_cached_mesh_gives_the_same_model_bit_for_bit() -> None:
    cam = {"cam_vertices": 400}
    for steps in (1000, 2000):  # the second time the hull is at hand, for another step
        text = text_of(CAM, steps, **cam)
        plain = mujoco.MjModel.from_xml_string(text)
        assert plain.nmeshgraph > 0
        assert first_difference(compile_mjcf(text), plain) == ""
    # Negative control: another step, and one vertex off by a bit.
    assert first_difference(compile_mjcf(text_of(CAM, 1000, **cam)), plain) == "pair_solref"  # which follows the step
    first = text.split('vertex="')[1].split()[0]
    off = text.replace(first, f"{np.nextafter(np.float32(first), np.float32(1.0)):.9g}", 1)
    assert first_difference(compile_mjcf(off), plain) != ""


def test_two_cams_of_one_name_are_not_confused() -> None:
    made = [compile_mjcf(text_of(CAMS[name], cam_vertices=400)) for name in ("cam-36-118", "cam-66-88", "cam-36-118")]
    assert made[0].mesh_vert.tobytes() == made[2].mesh_vert.tobytes() != made[1].mesh_vert.tobytes()
