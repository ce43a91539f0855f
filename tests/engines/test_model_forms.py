"""A rod as a distance joint: complete motion, the right order, and what each engine makes of it."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pymunk
import pytest
from catalogue import CAM, EVERY_SCENE, LINKAGES, PRESS, SAW, WITH_A_ROD

from conrod import Comparison, InvalidInput, MuJoCoSettings, Outcome, PymunkSettings, Trajectory, compare, run
from conrod.engines import ENGINES, engine_named
from conrod.engines.massless_rod import BODY, DISTANCE_JOINT, model_form
from conrod.engines.mujoco import dynamics as mujoco_dynamics
from conrod.engines.mujoco.model import build as build_model
from conrod.engines.pymunk import space as pymunk_space
from conrod.engines.pymunk.space import build as build_space
from conrod.exact.joint_equations import pose_jets
from conrod.mechanism.mechanism import ConstantForce, ObservedPoint
from conrod.runs.comparison import ExactMotions
from conrod.runs.convergence import observed_order
from conrod.scenes.catalogue import scene_named
from conrod.studies.frame.run import predicted_errors

QUANTITIES = ("position", "velocity", "acceleration")
TURN = 2.0 * math.pi
FORMED = list(WITH_A_ROD)


def pymunk_form(scene: Any, steps: int, iterations: int = 10, rod: str = DISTANCE_JOINT) -> PymunkSettings:
    return replace(PymunkSettings.tuned(scene, steps), iterations=iterations, rod=rod)


def mujoco_form(scene: Any, steps: int, closure: float = 8.0, rod: str = DISTANCE_JOINT) -> MuJoCoSettings:
    """The tuned preset with a closure time constant of so many steps."""
    tuned = MuJoCoSettings.tuned(scene, steps)
    return replace(tuned, solref=(closure * tuned.timestep, 1.0), rod=rod)


@cache
def ran(scene: Any, settings: Any, revolutions: float = 2.0, start_angle: float = 0.0) -> Trajectory:
    return run(scene, settings, revolutions, start_angle)


@cache
def measured(scene: Any, settings: Any) -> Comparison:
    trajectory = ran(scene, settings)
    assert trajectory.outcome is Outcome.COMPLETED, trajectory.reason
    return compare(trajectory, scene)


# -- the model -------------------------------------------------------------------------------------------------------


def test_the_engines_are_given_no_rod_but_its_exact_length() -> None:
    saw: Any = SAW
    space = build_space(saw, pymunk_form(saw, 100)).space
    (joint,) = (c for c in space.constraints if isinstance(c, pymunk.PinJoint))
    assert joint.distance == saw.rod
    assert len(space.bodies) == 2
    model = build_model(saw, mujoco_form(saw, 100)).model
    assert (model.nbody, model.nv, model.ntendon, model.neq) == (3, 2, 1, 1)
    assert model.tendon_length0[0] == pytest.approx(saw.rod, rel=1e-15)


@pytest.mark.parametrize("name", FORMED)
def test_the_rods_own_motion_is_told_exactly_from_its_pins(name: str) -> None:
    scene: Any = EVERY_SCENE[name]
    form = model_form(scene.kinematics.mechanism, DISTANCE_JOINT)
    assert [joint.link for joint in form.distances] == ["rod"]
    angles = np.linspace(0.0, 3.0 * TURN, 500)
    exact = scene.kinematics.derivatives(angles, 2)
    told = form.completed([form.kept(values) for values in exact])
    for values, derivative in zip(told, exact, strict=True):
        # The turn too: whole turns are counted, not folded.
        np.testing.assert_allclose(values, derivative, rtol=0.0, atol=1e-13 * scene.kinematics.size * 100.0)


def test_links_that_carry_more_than_two_pins_are_not_left_out() -> None:
    mechanism = SAW.kinematics.mechanism
    pushed = replace(mechanism, forces=(ConstantForce("rod", (1.0, 0.0)),))
    sprung = scene_named("slider-crank-spring").kinematics.mechanism  # from its crank to its rod
    for kept in (CAM.kinematics.mechanism, pushed, sprung):
        with pytest.raises(InvalidInput, match="no link carries nothing but two pins"):
            model_form(kept, DISTANCE_JOINT)
    # What is only observed on it is no load.
    marked = replace(mechanism, observed=(*mechanism.observed, ObservedPoint("P", "rod", (0.1, 0.02))))
    assert model_form(marked, DISTANCE_JOINT).distances


@pytest.mark.parametrize("engine", ENGINES)
def test_a_machine_without_such_a_link_is_refused(engine: str) -> None:
    made = engine_named(engine)
    settings = replace(made.presets["tuned"](CAM, 1000), rod=DISTANCE_JOINT)
    assert "two pins" in (made.refusal(CAM, settings) or "")
    with pytest.raises(InvalidInput, match="two pins"):
        run(CAM, settings)
    others = [made.refusal(s, replace(made.presets["tuned"](s, 1000), rod=DISTANCE_JOINT)) for s in LINKAGES.values()]
    assert others == [None] * len(LINKAGES)


FORMS = {"pymunk": pymunk_form, "mujoco": mujoco_form}


def test_near_a_limit_of_the_linkage_neither_form_always_holds_longer() -> None:
    """At as many iterations; the preset takes as many as a rod as a body needs, here 11 000 and 97 000."""
    saw: Any = SAW
    for other, holds in (({"offset": 0.0, "crank": 0.299}, BODY), ({"offset": 0.1999}, DISTANCE_JOINT)):
        machine = saw.with_parameters(**other)
        for rod in (BODY, DISTANCE_JOINT):
            ended = run(machine, replace(PymunkSettings.tuned(machine, 2000), rod=rod, iterations=300)).outcome
            assert (ended is Outcome.COMPLETED) == (rod == holds)


@pytest.mark.parametrize("scene", [PRESS, SAW], ids=["press", "saw"])
@pytest.mark.parametrize("engine", ENGINES)
def test_the_error_told_from_the_gaps_is_the_measured_one(engine: str, scene: Any) -> None:
    settings = FORMS[engine](scene, 500)
    trajectory, found = ran(scene, settings), measured(scene, settings)
    assert trajectory.bodies is not None
    told = predicted_errors(scene.kinematics, trajectory.points, trajectory.bodies)
    for k, quantity in enumerate(QUANTITIES):
        remainder = found.worst("position") * max(found.worst("position"), found.worst(quantity))
        for name, tracks in trajectory.points.items():
            error = ExactMotions(scene).error(getattr(tracks, quantity), name, quantity)
            off = np.linalg.norm(error - told[name][quantity], axis=1).max()
            assert off / (scene.lengths[name] * abs(scene.speed) ** k) <= 3.0 * remainder + 1e-13


# -- pymunk ----------------------------------------------------------------------------------------------------------

PATH = (250, 500, 1000, 2000)


def orders(scene: Any, settings: Any) -> dict[str, float]:
    """Slopes of the errors over PATH, for settings of a number of steps."""
    found = [measured(scene, settings(steps)) for steps in PATH]
    return {q: float(-np.polyfit(np.log(PATH), np.log([f.worst(q) for f in found]), 1)[0]) for q in QUANTITIES}


@pytest.mark.parametrize("quantity", QUANTITIES)
@pytest.mark.parametrize("name", LINKAGES)
def test_pymunks_distance_joint_is_of_order_two_at_ten_iterations(name: str, quantity: str) -> None:
    scene = LINKAGES[name]
    assert orders(scene, lambda n: pymunk_form(scene, n))[quantity] == pytest.approx(2.0, abs=0.02)


@pytest.mark.parametrize("name", LINKAGES)
def test_as_a_body_the_rod_needs_many_more_iterations(name: str) -> None:
    # Negative control: the body form at the same ten iterations has lost the order of velocity and acceleration.
    scene = LINKAGES[name]
    found = orders(scene, lambda n: pymunk_form(scene, n, rod=BODY))
    assert found["velocity"] == pytest.approx(1.0, abs=0.1)
    assert found["acceleration"] == pytest.approx(0.0, abs=0.1)


# -- MuJoCo ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", LINKAGES)
def test_mujocos_distance_joint_is_wrong_in_acceleration(name: str) -> None:
    # A tendon's equality leaves the curvature of the path out of the acceleration: what no step mends.
    scene = LINKAGES[name]
    found = [measured(scene, mujoco_form(scene, n)) for n in PATH]
    errors = [f.worst("acceleration") for f in found]
    assert observed_order(PATH, errors).claimed is None
    assert errors[-1] > 0.9 * errors[0] > 0.2
    assert orders(scene, lambda n: mujoco_form(scene, n))["position"] == pytest.approx(2.0, abs=0.05)
    as_body = measured(scene, mujoco_form(scene, 1000, rod=BODY)).worst("position")
    assert measured(scene, mujoco_form(scene, 1000)).worst("position") > 100.0 * as_body


@pytest.mark.parametrize("name", LINKAGES)
def test_its_gap_is_the_curvature_times_the_square_of_the_closures_time_constant(name: str) -> None:
    scene = LINKAGES[name]
    short, long = (measured(scene, mujoco_form(scene, 2000, closure=k)).worst("position") for k in (4.0, 8.0))
    assert long / short == pytest.approx(4.0, rel=0.02)


# -- a planted defect ------------------------------------------------------------------------------------------------

TOO_LONG = 1e-4


def size_of_the_defect(scene: Any) -> float:
    """Largest shift of the slider where the rod alone is too long: the length over the cosine of rod and slide."""
    (rod,), kinematics = model_form(scene.kinematics.mechanism, DISTANCE_JOINT).distances, scene.kinematics
    poses = pose_jets(kinematics.mechanism, [kinematics.poses(kinematics.angles(720))])
    one, other = (
        np.column_stack([x.coefficients[0] for x in poses[body].point(point)])
        for body, point in ((rod.a, rod.point_a), (rod.b, rod.point_b))
    )
    travel = scene.motion(kinematics.angles(720), 1.0).point(scene.output).position
    along = travel[travel @ (1.0, 1.0) == (travel @ (1.0, 1.0)).max()][0] - travel.mean(axis=0)
    cosine = np.abs((other - one) @ along) / (rod.length * np.linalg.norm(along))
    return float(TOO_LONG * rod.length / cosine.min()) / scene.lengths[scene.output]


def output_error(scene: Any, settings: Any) -> float:
    return float(compare(run(scene, settings), scene).points[scene.output].position.error.max())


@pytest.mark.parametrize("scene", [PRESS, SAW], ids=["press", "saw"])
def test_pymunks_distance_joint_a_ten_thousandth_too_long_is_seen(scene: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    right = pymunk_space._rod

    def too_long(*arguments: Any) -> Any:
        joint = right(*arguments)
        joint.distance *= 1.0 + TOO_LONG
        return joint

    settings = pymunk_form(scene, 4000)
    before = output_error(scene, settings)
    monkeypatch.setattr(pymunk_space, "_rod", too_long)
    found = output_error(scene, settings)
    assert before < 0.01 * found
    assert found == pytest.approx(size_of_the_defect(scene), rel=0.01)


@pytest.mark.parametrize("scene", [PRESS, SAW], ids=["press", "saw"])
def test_mujocos_distance_joint_a_ten_thousandth_too_long_is_seen(scene: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    right = mujoco_dynamics.build

    def too_long(*arguments: Any) -> Any:
        made = right(*arguments)
        made.model.tendon_length0[:] *= 1.0 + TOO_LONG
        return made

    settings = mujoco_form(scene, 8000, closure=2.0)
    before = output_error(scene, settings)
    monkeypatch.setattr(mujoco_dynamics, "build", too_long)
    found = output_error(scene, settings)
    assert before < 0.02 * found
    assert found == pytest.approx(size_of_the_defect(scene), rel=0.03)
