"""Gears, racks, sliders on moving links and inputs of one pass in both engines: what they reach, and defects."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from kinematic_mode import kinematic_errors
from rolling_machines import (
    PIN,
    SPEED,
    TOOTH,
    WHEEL,
    at_test_speed,
    gear_pair,
    poses_of,
    swinging_four_bar,
    wheel_on_a_track,
)

from conrod.comparison.compare import compare
from conrod.comparison.outcome import joint_gaps
from conrod.comparison.trajectory import Outcome, Trajectory
from conrod.engines import engine_named
from conrod.engines.engine import run_extent
from conrod.engines.pymunk.gears import gears_refusal
from conrod.engines.run import run, run_in_one_piece
from conrod.engines.spanning_tree import grow_spanning_tree, rolling_coefficients
from conrod.errors import InvalidInput
from conrod.exact.joint_equations import joint_residual, pose_jets
from conrod.exact.kinematics import GenericReference
from conrod.mechanism.mechanism import Mechanism
from conrod.scenes import catalogue_scene

# A ring gear, and wheels that roll along racks, which pymunk has no joint for.
RING, TRACK = gear_pair(TOOTH, -WHEEL), wheel_on_a_track()
KINEMATIC = 1e-10


@pytest.mark.parametrize(("mechanism", "engine"), [(RING, "mujoco"), (RING, "pymunk"), (TRACK, "mujoco")])
def test_error_laws_bound_rolling_machines_in_both_modes(mechanism: Mechanism, engine: str) -> None:
    machine, of = at_test_speed(mechanism), engine_named(engine)
    assert max(kinematic_errors(engine, machine, machine.kinematics.angles(24))) < KINEMATIC
    settings = of.presets["tuned"](machine, 500)
    found, allowed = compare(_run(machine, engine, "tuned", 500), machine), of.expected_error(machine, settings)
    for quantity in ("position", "velocity", "acceleration"):
        assert found.worst(quantity) <= getattr(allowed, quantity)


def _run(machine: GenericReference, engine: str, preset: str, steps: int, turns: float = 1.0) -> Trajectory:
    of, (start, revolutions) = engine_named(engine), run_extent(machine, steps, turns)
    trajectory = run_in_one_piece(of, machine, of.presets[preset](machine, steps), revolutions, start)
    assert trajectory.outcome is Outcome.COMPLETED, trajectory.reason
    return trajectory


def test_a_run_beyond_the_span_is_refused_with_the_right_pass() -> None:
    machine = at_test_speed(swinging_four_bar((-0.4, 0.3)))
    settings = engine_named("mujoco").presets["tuned"](machine, 300)
    start, revolutions = run_extent(machine, 300, 2.0)
    assert run(machine, settings, revolutions, start).outcome is Outcome.COMPLETED
    for asked in ((2.0, 0.0), (revolutions, start - 0.1), (revolutions, start + 0.1)):
        with pytest.raises(InvalidInput, match=r"starts at -0.4 rad and takes 0.111408\d* revolutions"):
            run(machine, settings, *asked)


def test_a_pass_takes_whole_steps_from_one_end_of_the_span() -> None:
    forth, back = (
        at_test_speed(swinging_four_bar((-0.4, 0.3))),
        GenericReference(swinging_four_bar((-0.4, 0.3)), -SPEED),
    )
    for machine, start, stop in ((forth, -0.4, 0.3), (back, 0.3, -0.4)):
        run = _run(machine, "mujoco", "tuned", 300)
        step = 2.0 * math.pi / 300
        angle = run.points["joint"].position.instants.angle
        assert angle[0] == pytest.approx(start, abs=1e-12)
        assert abs(stop - angle[-1]) < step
        assert angle.min() + 1e-12 >= -0.4
        assert angle.max() - 1e-12 <= 0.3
        assert compare(run, machine).worst("position") < 1e-3


def test_gears_of_three_bodies_are_solved_for_pairs_or_refused() -> None:
    gear = catalogue_scene("planetary-gear").mechanism()
    assert gears_refusal(gear) is None
    still = next(joint for joint in gear.meshes if "ground" in (joint.a, joint.b))
    one_pair = replace(gear, joints=tuple(joint for joint in gear.joints if joint is not still))
    assert "ties the turns of two bodies; here" in (gears_refusal(one_pair) or "")
    assert "a rack needs" in (gears_refusal(TRACK) or "")


@pytest.mark.parametrize("name", ["planetary-gear", "rack-and-wheel"])
def test_tendon_of_a_rolling_pair_is_exact_at_any_pose(name: str) -> None:
    kinematics = catalogue_scene(name).kinematics
    tree = grow_spanning_tree(kinematics.mechanism, kinematics.start[0])
    poses = kinematics.poses(kinematics.angles(5))
    gone = np.random.default_rng(5).normal(size=(5, len(tree.branches)))
    coordinates = tree.coordinates(poses)
    moved, rates = tree.forward_kinematics(coordinates, gone)
    for mesh in kinematics.mechanism.meshes:
        gap = joint_residual(mesh, pose_jets(kinematics.mechanism, [moved, rates]))[0]
        np.testing.assert_allclose(gone @ rolling_coefficients(tree, mesh), gap.coefficients[1], atol=1e-12)


# -- defects ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("engine", ["mujoco", "pymunk"])
@pytest.mark.parametrize("other", [gear_pair(TOOTH + 0.0001, WHEEL - 0.0001), gear_pair(-TOOTH - 0.18, TOOTH)])
def test_wrong_gear_ratio_or_sense_is_detected_in_both_modes(engine: str, other: Mechanism) -> None:
    right, wrong = at_test_speed(gear_pair()), at_test_speed(other)
    solved = engine_named(engine).solve_kinematics(wrong, np.array([1.0]))
    exact = right.motion(np.array([1.0]), SPEED).point("mark").position - poses_of(right, "wheel", np.zeros(1))[:, :2]
    place = solved.points["mark"][0] - poses_of(wrong, "wheel", np.zeros(1))[:, :2]
    assert np.abs(place - exact).max() > 1e6 * KINEMATIC * PIN
    run = _run(wrong, engine, "tuned", 200)
    assert run.bodies is not None
    gap = joint_gaps(right.described, [run.bodies.position.poses])["mesh"]
    assert np.abs(gap).max() > 1e-4
