"""Gears, racks, sliders on moving links and inputs of one pass in both engines: what they reach, and defects."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from rolling_machines import (
    MACHINES,
    PIN,
    SPEED,
    TOOTH,
    WHEEL,
    driven,
    gear_pair,
    planetary_gear,
    poses_of,
    swinging_four_bar,
)

from conrod.engines import engine_named
from conrod.engines.engine import run_of
from conrod.engines.pymunk.gears import gears_refusal
from conrod.engines.running import run, whole_run
from conrod.engines.tree import mesh_row, spanning_tree
from conrod.errors import InvalidInput
from conrod.exact.joint_equations import joint_residual, pose_jets
from conrod.exact.reference import GenericReference
from conrod.mechanism.mechanism import Mechanism
from conrod.runs.comparison import compare
from conrod.runs.outcome import joint_gaps
from conrod.runs.trajectory import Outcome, Trajectory

# What pymunk refuses, and a word of its reason.
REFUSED = {
    "rack and wheel": "rack",
    "wheel on a track": "rack",
    "rack and wheel, one pass": "rack",
}
KINEMATIC = 1e-10
IN_ENGINES = [(name, engine) for name in MACHINES for engine in ("mujoco", "pymunk") if (name, engine) not in
              {(refused, "pymunk") for refused in REFUSED}]  # fmt: skip


@pytest.mark.parametrize(("name", "engine"), IN_ENGINES)
def test_kinematic_mode_meets_the_exact_motion(name: str, engine: str) -> None:
    machine = driven(MACHINES[name])
    angle = machine.kinematics.angles(24)
    solved, exact = engine_named(engine).solve_kinematics(machine, angle), machine.motion(angle, SPEED)
    for point, (position, velocity) in solved.points.items():
        length, truth = machine.lengths[point], exact.point(point)
        assert velocity is not None
        assert np.abs(position - truth.position).max() < KINEMATIC * length
        assert np.abs(velocity - truth.velocity).max() < KINEMATIC * length * SPEED


@pytest.mark.parametrize(("name", "engine"), IN_ENGINES)
def test_runs_stay_within_what_the_engines_laws_allow(name: str, engine: str) -> None:
    machine, of = driven(MACHINES[name]), engine_named(engine)
    settings = of.presets["tuned"](machine, 500)
    assert of.refusal(machine, settings) is None
    found, allowed = compare(_run(machine, engine, "tuned", 500), machine), of.expected_error(machine, settings)
    for quantity in ("position", "velocity", "acceleration"):
        bound = getattr(allowed, quantity)
        assert bound is not None
        assert found.worst(quantity) <= bound


def _run(machine: GenericReference, engine: str, preset: str, steps: int, turns: float = 1.0) -> Trajectory:
    of, (start, revolutions) = engine_named(engine), run_of(machine, steps, turns)
    trajectory = whole_run(of, machine, of.presets[preset](machine, steps), revolutions, start)
    assert trajectory.outcome is Outcome.COMPLETED, trajectory.reason
    return trajectory


def test_run_that_leaves_the_span_is_refused_with_the_pass_that_fits() -> None:
    machine = driven(swinging_four_bar((-0.4, 0.3)))
    settings = engine_named("mujoco").presets["tuned"](machine, 300)
    start, revolutions = run_of(machine, 300, 2.0)
    assert run(machine, settings, revolutions, start).outcome is Outcome.COMPLETED
    for asked in ((2.0, 0.0), (revolutions, start - 0.1), (revolutions, start + 0.1)):
        with pytest.raises(InvalidInput, match=r"starts at -0.4 rad and takes 0.111408\d* revolutions"):
            run(machine, settings, *asked)


def test_pass_takes_whole_steps_within_the_span_from_the_end_that_the_sense_tells() -> None:
    forth, back = driven(swinging_four_bar((-0.4, 0.3))), GenericReference(swinging_four_bar((-0.4, 0.3)), -SPEED)
    for machine, start, stop in ((forth, -0.4, 0.3), (back, 0.3, -0.4)):
        run = _run(machine, "mujoco", "tuned", 300)
        step = 2.0 * math.pi / 300
        angle = run.points["joint"].position.instants.angle
        assert angle[0] == pytest.approx(start, abs=1e-12)
        assert abs(stop - angle[-1]) < step
        assert angle.min() + 1e-12 >= -0.4
        assert angle.max() - 1e-12 <= 0.3
        assert compare(run, machine).worst("position") < 1e-3


@pytest.mark.parametrize("name", REFUSED)
def test_pymunk_says_which_rolling_pairs_it_cannot_have_and_why(name: str) -> None:
    machine, engine = driven(MACHINES[name]), engine_named("pymunk")
    reason = engine.refusal(machine, engine.presets["tuned"](machine, 500))
    assert reason is not None
    assert REFUSED[name] in reason
    with pytest.raises(InvalidInput, match="pymunk"):
        engine.solve_kinematics(machine, np.zeros(1))


def test_pymunk_solves_gears_of_three_turns_for_pairs_or_says_that_they_are_none() -> None:
    assert gears_refusal(planetary_gear("sun")) is None
    two_inputs = planetary_gear("sun")
    two_inputs = replace(two_inputs, joints=tuple(j for j in two_inputs.joints if j.name not in ("first", "second")))
    assert gears_refusal(two_inputs) == (
        "pymunk's gear joint ties the turns of two bodies; here planet and sun and arm hang together"
    )


@pytest.mark.parametrize("name", [name for name in MACHINES if MACHINES[name].meshes])
def test_tendon_of_a_rolling_pair_is_its_equation_whatever_the_pose(name: str) -> None:
    kinematics = driven(MACHINES[name]).kinematics
    tree = spanning_tree(kinematics.mechanism, kinematics.start[0])
    poses, slopes = kinematics.derivatives(kinematics.angles(5), 1)
    gone = np.random.default_rng(5).normal(size=(5, len(tree.branches)))
    coordinates = tree.coordinates(poses)
    moved, rates = tree.forward(coordinates, gone)
    for mesh in kinematics.mechanism.meshes:
        gap = joint_residual(mesh, pose_jets(kinematics.mechanism, [moved, rates]))[0]
        np.testing.assert_allclose(gone @ mesh_row(tree, mesh), gap.coefficients[1], atol=1e-12)
    assert np.isfinite(slopes).all()


# -- defects ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("engine", ["mujoco", "pymunk"])
@pytest.mark.parametrize("other", [gear_pair(TOOTH + 0.0001, WHEEL - 0.0001), gear_pair(-TOOTH - 0.18, TOOTH)])
def test_wrong_ratio_and_wrong_sense_are_seen_in_both_modes(engine: str, other: Mechanism) -> None:
    right, wrong = driven(gear_pair()), driven(other)
    solved = engine_named(engine).solve_kinematics(wrong, np.array([1.0]))
    exact = right.motion(np.array([1.0]), SPEED).point("mark").position - poses_of(right, "wheel", np.zeros(1))[:, :2]
    place = solved.points["mark"][0] - poses_of(wrong, "wheel", np.zeros(1))[:, :2]
    assert np.abs(place - exact).max() > 1e6 * KINEMATIC * PIN
    run = _run(wrong, engine, "tuned", 200)
    assert run.bodies is not None
    gap = joint_gaps(right.described, [run.bodies.position.poses])["mesh"]
    assert np.abs(gap).max() > 1e-4
