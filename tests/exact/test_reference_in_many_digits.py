"""The generic solver against an independent one in 40 digits: poses, observed points, and derivatives to jerk."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from many_digits import ManyDigits

from conrod.exact.kinematics import Kinematics
from conrod.exact.motion import Array
from conrod.mechanism.mechanism import Mechanism, Revolute
from conrod.scenes import SCENES, catalogue_names, catalogue_scene

PARTS = np.array([0.05, 0.23, 0.41, 0.59, 0.77, 0.95])  # of the turn or the pass
# Of each kind one: a turn, a pass, wheels, a rack, arcs, a law, a change point; the rest with `make test-all`.
QUICK = ("cam-follower", "parallelogram", "planetary-gear", "saw-40rpm")
AGREED = 1e-12


def kinematics_of(name: str) -> Kinematics:
    return (SCENES[name] if name in SCENES else catalogue_scene(name)).kinematics


def disagreement(kinematics: Kinematics, mechanism: Mechanism) -> tuple[list[float], list[float]]:
    """Of poses and observed points with three derivatives: largest differences, over the largest value of each."""
    low, high = kinematics.span
    angles = low + (high - low) * PARTS
    poses, points = kinematics.derivatives(angles), kinematics.motion(angles, 1.0).points
    scale = np.tile([kinematics.size, kinematics.size, 1.0], len(mechanism.bodies))
    exact = ManyDigits(mechanism)
    walked = exact.walk([float(angle) for angle in angles])
    of_poses, of_points = np.zeros((2, 4))
    for j, angle in enumerate(angles):
        places, tracks = exact.derivatives(walked[float(angle)], float(angle))
        for k in range(4):
            of_poses[k] = max(of_poses[k], _off(poses[k][j] / scale, places[k] / scale, 1.0))
        for name, track in tracks.items():
            moved = points[name]
            found = (moved.position, moved.velocity, moved.acceleration, moved.jerk)
            for k in range(4):
                of_points[k] = max(of_points[k], _off(found[k][j], track[k], kinematics.lengths[name]))
    return list(of_poses), list(of_points)


def _off(found: Array, exact: Array, least: float) -> float:
    return float(np.abs(found - exact).max() / max(least, np.abs(exact).max()))


def slow_but_for_a_few(name: str) -> object:
    return name if name in QUICK else pytest.param(name, marks=pytest.mark.slow)


@pytest.mark.parametrize("name", [slow_but_for_a_few(name) for name in (*SCENES, *catalogue_names())])
def test_the_solver_has_twelve_digits_up_to_jerk(name: str) -> None:
    kinematics = kinematics_of(name)
    of_poses, of_points = disagreement(kinematics, kinematics.mechanism)
    assert max(of_poses) < AGREED
    assert max(of_points) < AGREED


def test_a_length_wrong_in_its_tenth_digit_is_seen() -> None:
    kinematics = kinematics_of("web-cutter")
    mechanism = kinematics.mechanism
    joint = next(j for j in mechanism.joints if isinstance(j, Revolute) and j.point_b[0] != 0.0)
    (x, y), rest = joint.point_b, [j for j in mechanism.joints if j is not joint]
    wrong = replace(mechanism, joints=(*rest, replace(joint, point_b=(x * (1.0 + 1e-10), y))))
    assert min(max(found) for found in disagreement(kinematics, wrong)) > AGREED


def test_another_assembly_is_seen() -> None:
    """The start of a parallelogram's other branch: the follower's end mirrored at the line from A to its shaft."""
    kinematics = kinematics_of("parallelogram")
    mechanism = kinematics.mechanism
    turns = {name: pose[2] for name, pose in mechanism.poses.items()}
    poses = dict(mechanism.poses)
    poses["coupler"] = (*poses["coupler"][:2], turns["coupler"] - 0.8)
    poses["follower"] = (*poses["follower"][:2], turns["follower"] - 2.0)
    of_poses, _ = disagreement(kinematics, replace(mechanism, poses=poses))
    assert of_poses[0] > 1e-3
