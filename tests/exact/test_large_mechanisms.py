"""Mechanisms of many loops: read, solved, translated and run.

With lower pairs alone, n links of mobility 3 (n - 1) - 2 j = 1 have j = (3 n - 4) / 2 joints and L = j - n + 1 =
n / 2 - 1 independent loops; each higher pair adds half a loop. So 50 links of mobility 1 have 24 loops or more, and
20 loops are those of 42 links: both are taken.
"""

from __future__ import annotations

import numpy as np
import pytest
from large_mechanisms import large_mechanism

from conrod.engines import engine_named
from conrod.engines.running import whole_run
from conrod.engines.tree import tree_of
from conrod.exact.elimination import triangular_blocks
from conrod.exact.joint_equations import joint_residual, pose_jets
from conrod.runs.comparison import compare
from conrod.runs.trajectory import Outcome
from conrod.scenes.described_scene import DescribedScene, scene_of

DEEP = "bodies.rocker19.points.P.y"


@pytest.fixture(scope="module")
def largest() -> DescribedScene:
    return scene_of(large_mechanism(24))


def faulty(scene: DescribedScene) -> DescribedScene:
    """With one length of a deep loop a thousandth off."""
    return scene.with_parameters(**{DEEP: scene.parameters[DEEP] + 3e-4})


def test_exact_motion_closes_every_joint_up_to_jerk(largest: DescribedScene) -> None:
    derivatives = largest.kinematics.derivatives(largest.kinematics.angles(90), 3)
    factorials = (1.0, 1.0, 2.0, 6.0)
    mechanism = largest.mechanism()
    bodies = pose_jets(mechanism, [d / f for d, f in zip(derivatives, factorials, strict=True)])
    for joint in mechanism.joints:
        for equation in joint_residual(joint, bodies):
            for order, left in enumerate(equation.coefficients):
                assert np.abs(left).max() < 1e-12 * max(1.0, np.abs(derivatives[order]).max()), (joint.name, order)


def test_a_wrong_length_in_a_deep_loop_is_seen(largest: DescribedScene) -> None:
    angles = largest.kinematics.angles(90)
    exact, other = (scene.motion(angles, scene.speed).points for scene in (largest, faulty(largest)))
    off = {name: np.abs(exact[name].position - other[name].position).max() for name in exact}
    assert off["P"] > 1e-5
    assert off["A"] < 1e-12  # the first loop knows nothing of it


def test_loops_of_a_chain_are_closed_one_at_a_time_and_each_in_the_models(largest: DescribedScene) -> None:
    factors = largest.kinematics._equations.elimination(largest.kinematics.start)
    assert len(factors.order.blocks) == 24
    assert max(len(rows) for rows, _ in factors.order.blocks) == 2
    assert len(tree_of(largest).cuts) == 24


def test_what_cannot_be_told_apart_is_one_block() -> None:
    assert len(triangular_blocks({0: (0, 1), 1: (1, 2), 2: (2, 0)}, (0, 1, 2))) == 1
    assert len(triangular_blocks({0: (0, 1), 1: (0, 1), 2: (2, 0)}, (0, 1, 2))) == 2


@pytest.mark.slow
def test_both_engines_place_it_to_rounding_and_see_a_wrong_length(largest: DescribedScene) -> None:
    angles = largest.kinematics.angles(5)
    exact = largest.motion(angles, largest.speed).point("P").position
    for name in ("mujoco", "pymunk"):
        for scene, wrong in ((largest, False), (faulty(largest), True)):
            solved = engine_named(name).solve_kinematics(scene, angles).points["P"][0]
            off = np.abs(solved - exact).max() / largest.lengths["P"]
            assert off > 1e-5 if wrong else off < 1e-12, (name, off)


@pytest.mark.slow
def test_hardened_mujoco_runs_it_at_its_accuracy(largest: DescribedScene) -> None:
    engine = engine_named("mujoco")
    trajectory = whole_run(engine, largest, engine.presets["hardened"](largest, 500), 0.25)
    assert trajectory.outcome is Outcome.COMPLETED
    assert compare(trajectory, largest).worst("position") < 1e-8
    assert compare(trajectory, faulty(largest)).worst("position") > 1e-5
