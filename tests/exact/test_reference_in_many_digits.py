"""The exact motion against equations of its own in 50 digits: poses, observed points, and derivatives to jerk."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from catalogue import CAMS, EVERY_SCENE, slow_but_for_a_few
from many_digits import ManyDigits

from conrod.exact.motion import Array
from conrod.mechanism.mechanism import Mechanism, Revolute
from conrod.scenes import SCENES, Scene, catalogue_names, catalogue_scene

PARTS = np.array([0.05, 0.23, 0.41, 0.59, 0.77, 0.95])  # of the turn or the pass
# Of each kind one: a change point, wheels, laws; the rest with `make test-all`.
QUICK = ("parallelogram", "planetary-gear", "cam-simple-harmonic", "cam-4-5-6-7")
AGREED, CLOSED_FORM = 1e-12, 1e-13
MACHINES = {**EVERY_SCENE, **CAMS}


def disagreement(scene: Scene, mechanism: Mechanism, turns: float = 1.0, bend: float = 0.7) -> tuple[float, float]:
    """Of poses and of observed points with three derivatives: largest difference, over the largest value of each.

    Points move at an angular acceleration of `bend` times the square of the speed.
    """
    kinematics, exact = scene.kinematics, ManyDigits(mechanism)
    low, high = kinematics.span
    angles = low + turns * (high - low) * PARTS
    poses, moved = kinematics.derivatives(angles), scene.motion(angles, 1.0, 0.7).points
    scale = np.tile([kinematics.size, kinematics.size, 1.0], len(mechanism.bodies))
    of_poses = of_points = 0.0
    for j, angle in enumerate(angles):
        places, tracks = exact.derivatives(poses[0][j], float(angle))
        of_poses = max(of_poses, *(_off(p[j] / scale, q / scale, 1.0) for p, q in zip(poses, places, strict=True)))
        for name, (place, first, second, third) in tracks.items():
            in_time = (place, first, second + bend * first, third + 3.0 * bend * second)
            found = vars(moved[name]).values()
            of_points = max(
                of_points, *(_off(f[j], t, scene.lengths[name]) for f, t in zip(found, in_time, strict=True))
            )
    return of_poses, of_points


def _off(found: Array, exact: Array, least: float) -> float:
    return float(np.abs(found - exact).max() / max(least, np.abs(exact).max()))


@pytest.mark.parametrize("name", [*EVERY_SCENE, *slow_but_for_a_few(CAMS)])
def test_closed_forms_have_thirteen_digits_up_to_jerk_over_ten_turns(name: str) -> None:
    scene = MACHINES[name]
    of_poses, of_points = disagreement(scene, scene.mechanism(), turns=10.0)
    assert of_poses < AGREED
    assert of_points < CLOSED_FORM


@pytest.mark.parametrize(
    "name", [name if name in QUICK else pytest.param(name, marks=pytest.mark.slow) for name in catalogue_names()]
)
def test_the_solver_has_twelve_digits_up_to_jerk(name: str) -> None:
    scene = catalogue_scene(name)
    assert max(disagreement(scene, scene.mechanism())) < AGREED


def test_a_length_wrong_in_its_tenth_digit_is_seen() -> None:
    for scene in (SCENES["saw-40rpm"], catalogue_scene("web-cutter")):
        mechanism = scene.mechanism()
        joint = next(j for j in mechanism.joints if isinstance(j, Revolute) and (j.point_a[0] or j.point_b[0]))
        (x, y), rest = joint.point_a, [j for j in mechanism.joints if j is not joint]
        wrong = replace(mechanism, joints=(*rest, replace(joint, point_a=(x * (1.0 + 1e-10), y))))
        assert min(disagreement(scene, wrong)) > AGREED


def test_a_swapped_sign_of_the_angular_acceleration_is_seen() -> None:
    scene = SCENES["saw-40rpm"]
    assert disagreement(scene, scene.mechanism(), bend=-0.7)[1] > 0.1
