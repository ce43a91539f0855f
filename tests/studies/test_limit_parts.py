"""Parts of a study of limits, each by numbers worked out by hand: spacing, setups, plans, flights, torques, cams."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from catalogue import CAM, PRESS, SAW
from synthetic import completed_result

from conrod import InvalidInput
from conrod.engines import engine_named
from conrod.exact.dynamics import load_forces
from conrod.exact.equations import inertia_forces
from conrod.execution.run import RunResult
from conrod.scenes import CamFollower, Saw, Scene, scene_named
from conrod.studies.limits.axes import AXES, MIN_CONTACT_SHARE
from conrod.studies.limits.axis import Scale, spaced_values
from conrod.studies.limits.case import LimitCase, ReorderedMachine, Setup
from conrod.studies.limits.changed_machines import (
    MAX_ONE_CIRCLE_EXCESS,
    output_mass,
    with_flank_excess,
    with_nose_radius,
)
from conrod.studies.limits.follower_float import ONSET_REVOLUTIONS, FollowerFloat, OnsetProbe, onset_case
from conrod.studies.limits.maps import classify_grid, grid_values, map_class
from conrod.studies.limits.plan import check_applicable, plan_limits, pursue_plans
from conrod.studies.limits.recorders import ExactTorque, FlightRecorder
from conrod.studies.limits.records import Level, LimitResult, is_undetected, level_of
from conrod.studies.limits.results import STUDY_PARTS, Walk


def setup(scene: Scene = SAW, engine: str = "mujoco", preset: str = "hardened", steps: int | None = None) -> Setup:
    return Setup(scene.kind, scene, engine, preset, steps)


def one_pass() -> Setup:
    """A machine of the catalogue whose crank goes from one angle to another."""
    scene = next(s for s in map(scene_named, ("double-rocker", "geneva")) if s.kinematics.mechanism.driver.span)
    return Setup(scene.kind, scene, "mujoco", "hardened")


# -- spacing ---------------------------------------------------------------------------------------------------------


def test_values_are_spaced_evenly_on_their_scale() -> None:
    assert spaced_values(Scale.LOG, 1.0, 1e4, 5) == pytest.approx((1.0, 10.0, 100.0, 1e3, 1e4), rel=1e-12)
    assert spaced_values(Scale.NEARNESS, 0.9, 1.0 - 1e-5, 5) == pytest.approx(
        (0.9, 0.99, 0.999, 0.9999, 0.99999), rel=1e-12
    )  # fmt: skip
    assert spaced_values(Scale.COUNT, 8.0, 1.0, 4) == (8.0, 4.0, 2.0, 1.0)
    assert spaced_values(Scale.COUNT, 3.0, 1.0, 9) == (3.0, 2.0, 1.0), "whole numbers are not run twice"


def test_midpoint_is_half_way_on_scale_and_ends_at_two_per_cent() -> None:
    near = replace(AXES["nearness"], nearest=lambda value: value)
    assert near.scale is Scale.NEARNESS
    assert near.midpoint(0.9, 0.999) == pytest.approx(0.99, rel=1e-12)
    assert near.midpoint(1.0 - 1e-3, 1.0 - 1.01e-3) is None
    assert near.midpoint(1.0 - 1e-3, 1.0 - 1.03e-3) is not None


# -- setups ----------------------------------------------------------------------------------------------------------


def test_fewest_steps_leave_a_pass_the_samples_of_a_turn() -> None:
    setting = one_pass()
    span = setting.mechanism.driver.span
    assert span is not None
    from conrod.execution.case import MIN_PASS_STEPS

    share = (span[1] - span[0]) / (2.0 * math.pi)
    assert MIN_PASS_STEPS <= setting.min_steps * share < MIN_PASS_STEPS + share
    assert setup().min_steps == 2


def test_run_has_its_scenes_name_and_refusal_its_settings_reason() -> None:
    assert Setup("called", SAW, "mujoco", "hardened").case_with().name == "called"
    assert setup().refusal() is None
    refusal = setup(CAM).refusal()
    assert refusal is not None
    assert refusal == engine_named("mujoco").refusal(CAM, setup(CAM).settings())
    assert setup(CAM, "mujoco", "tuned").refusal() is None


def test_an_engine_whose_settings_cannot_be_varied_says_so() -> None:
    assert setup().variation_refusal() is None
    lacking = Setup("saw", SAW, "exudyn", next(iter(engine_named("exudyn").presets)))
    assert lacking.variation_refusal()
    assert "exudyn" in str(lacking.variation_refusal()).lower()


def test_redeclared_machine_moves_as_its_scene_at_speed_and_side() -> None:
    machine = ReorderedMachine(SAW.kinematics.mechanism, SAW.speed, SAW)
    angles = np.linspace(0.0, 6.0, 7)
    for side in ("left", "right"):
        given, exact = (one.motion(angles, 3.0, 0.5, side) for one in (machine, SAW))
        assert np.array_equal(given.point("C").acceleration, exact.point("C").acceleration)
    assert not np.array_equal(
        machine.motion(angles, 3.0).point("C").velocity, SAW.motion(angles, 1.0).point("C").velocity
    )
    # Without a side it is the right one, of a cam where it jumps.
    cam = ReorderedMachine(CAM.kinematics.mechanism, CAM.speed, CAM)
    jump = np.array(CAM.break_angles())
    point = CAM.output
    right, left = (CAM.motion(jump, 1.0, 0.0, side).point(point).acceleration for side in ("right", "left"))
    assert not np.allclose(right, left)
    assert np.array_equal(cam.motion(jump, 1.0).point(point).acceleration, right)


# -- axes ------------------------------------------------------------------------------------------------------------


def test_axes_refuse_what_a_machine_or_a_range_does_not_have() -> None:
    span = one_pass()
    refused = {name: axis.refusal(span) for name, axis in AXES.items() if name in ("run-length", "start-pose")}
    assert any(reason and "makes one pass" in reason and span.scene.kind in reason for reason in refused.values())
    assert AXES["run-length"].refusal(setup()) is None
    cam = setup(CAM, "mujoco", "tuned", 2000)
    axis = AXES["regularisation"]
    assert axis.refusal(cam) is None
    with pytest.raises(InvalidInput, match=r"^regularisation of a contact"):
        axis.case(cam, 1.5)
    with pytest.raises(InvalidInput, match=r"regularisation of a contact"):
        axis.case(cam, 0.5 * MIN_CONTACT_SHARE)
    assert axis.case(cam, 1.0)


@pytest.mark.parametrize(("name", "one", "many"), [("run-length", "1 revolution", "12 revolutions")])
def test_counts_are_written_with_their_noun(name: str, one: str, many: str) -> None:
    axis = AXES[name]
    assert axis.text(setup(), 1.0) == one
    assert axis.text(setup(), 12.0) == many


def test_masses_and_radii_of_changed_machines() -> None:
    assert output_mass(SAW) == "slider_mass"
    highest = SAW.parameter_facts()["slider_mass"].highest
    heavy = SAW.with_parameters(slider_mass=highest) if math.isfinite(highest) else SAW
    assert output_mass(heavy) == "slider_mass"
    cam = setup(CAM, "mujoco", "tuned")
    nose = with_nose_radius(cam, 3.0)
    assert isinstance(nose, CamFollower)
    assert nose.nose_radius == pytest.approx(3e-3)
    assert nose.full_lift == pytest.approx(CAM.full_lift, rel=1e-12)
    circle, next_to_it = (
        with_flank_excess(cam, MAX_ONE_CIRCLE_EXCESS),
        with_flank_excess(cam, 1.01 * MAX_ONE_CIRCLE_EXCESS),
    )
    assert isinstance(circle, CamFollower)
    assert isinstance(next_to_it, CamFollower)
    assert circle.flank_radius == circle.least_flank_radius
    assert next_to_it.flank_radius == pytest.approx(
        next_to_it.least_flank_radius + 1.01e-3 * MAX_ONE_CIRCLE_EXCESS, rel=1e-12
    )


# -- torque of the drive -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("gravity", [False, True])
def test_the_exact_torque_is_the_rate_of_energy_over_the_speed(gravity: bool) -> None:
    """Torque x speed = d/dt of (kinetic + potential energy), by differences of the energies themselves."""
    scene = SAW.with_parameters(speed=7.0)
    mechanism = replace(scene.kinematics.mechanism, gravity=(0.0, -9.81))
    kinematics = type(scene.kinematics)(mechanism)
    torque = ExactTorque(kinematics, 7.0, gravity=gravity)
    masses = np.array([[body.mass, body.mass, body.inertia] for body in mechanism.bodies])
    centres = np.array([body.centre_of_gravity for body in mechanism.bodies])

    def energy(angles: Any) -> Any:
        poses, first, _ = kinematics.derivatives(angles, 2)
        poses, rates = (one.reshape(len(angles), -1, 3) for one in (poses, first * 7.0))
        cosine, sine = np.cos(poses[:, :, 2]), np.sin(poses[:, :, 2])
        aside = np.stack([cosine * centres[:, 0] - sine * centres[:, 1], sine * centres[:, 0] + cosine * centres[:, 1]])
        moved = rates.copy()
        moved[:, :, 0] -= rates[:, :, 2] * aside[1]
        moved[:, :, 1] += rates[:, :, 2] * aside[0]
        kinetic = 0.5 * np.sum(masses * moved**2, axis=(1, 2))
        return kinetic + (9.81 * np.sum(masses[:, 0] * (poses[:, :, 1] + aside[1]), axis=1) if gravity else 0.0)

    angles, small = np.linspace(0.1, 6.2, 40), 1e-5
    by_energy = (energy(angles + small) - energy(angles - small)) / (2.0 * small)
    assert torque.evaluate(angles) == pytest.approx(by_energy, rel=1e-6, abs=1e-6 * torque.peak)
    dense = np.abs(torque.evaluate(np.linspace(0.0, 2.0 * np.pi, 20001)))
    assert torque.peak == pytest.approx(dense.max(), rel=1e-6)
    assert torque.peak >= dense.max() * (1.0 - 1e-12)
    assert not torque.is_negligible


def test_redeclared_gravity_load_is_subtracted_from_inertia() -> None:
    mechanism = replace(SAW.kinematics.mechanism, gravity=(0.0, -9.81))
    kinematics = type(SAW.kinematics)(mechanism)
    angle = np.array([0.7, 2.0])
    poses, first, second = kinematics.derivatives(angle, 2)
    rates = first * 5.0
    forces = inertia_forces(mechanism, poses, rates, second * 25.0) - load_forces(mechanism, poses, rates, angle / 5.0)
    expected = np.sum(forces * first, axis=1)
    assert ExactTorque(kinematics, 5.0, gravity=True).evaluate(angle) == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("speed", [1e-4, 1.0, 1e4])
def test_a_drive_that_takes_something_does_so_at_any_speed(speed: float) -> None:
    assert not ExactTorque(SAW.kinematics, speed, gravity=False).is_negligible


# -- flights ---------------------------------------------------------------------------------------------------------


def flights(gap: list[float], held: int = 3, pieces: int = 1) -> FlightRecorder:
    found = FlightRecorder(held, travel=1.0)
    angles = np.arange(float(len(gap)))
    for angle, part in zip(np.array_split(angles, pieces), np.array_split(np.array(gap), pieces), strict=True):
        found.add(angle, part)
    return found


DEPTH = -1e-3  # so the threshold is 1e-2


@pytest.mark.parametrize("pieces", [1, 2, 5, 9])
def test_flight_starts_and_ends_when_gap_passes_threshold(pieces: int) -> None:
    found = flights([DEPTH, DEPTH, DEPTH, 0.0, 0.02, 0.02, 0.0, 0.0, 0.0, 0.0], pieces=pieces)
    longest = found.longest_flight()
    assert longest is not None
    assert (longest.start, longest.landing) == pytest.approx((3.5, 5.5))
    assert found.threshold == pytest.approx(1e-2)


def test_open_flight_starts_or_lands_at_the_end_of_samples() -> None:
    open_end = flights([DEPTH, DEPTH, DEPTH, 0.0, 0.02, 0.02, 0.02]).longest_flight()
    assert open_end is not None
    assert (open_end.start, open_end.landing) == pytest.approx((3.5, 6.0))
    from_start = flights([0.02, 0.02, DEPTH, DEPTH, 0.0, 0.0]).longest_flight()
    assert from_start is not None
    assert from_start.start == 0.0
    assert flights([DEPTH] * 6).longest_flight() is None


@pytest.mark.parametrize("pieces", [1, 2, 6])
def test_penetration_is_that_of_all_first_samples_in_any_pieces(pieces: int) -> None:
    assert flights([0.0, 0.0, DEPTH, 0.02, 0.0, -2.0 * DEPTH], held=3, pieces=pieces).longest_flight() is not None
    found = flights([0.0, 0.0, DEPTH, 0.0, 0.0, 2.0 * DEPTH], held=3, pieces=pieces)
    assert found.longest_flight() is None
    assert found.penetration == -DEPTH


# -- plans -----------------------------------------------------------------------------------------------------------


def planned(*asked: str, preset: str | None = "hardened", scene: Scene = SAW, span: Any = None) -> Any:
    return plan_limits("named", scene, [engine_named("mujoco")], preset, asked, span)


def test_plan_has_a_search_for_each_axis_and_its_findings() -> None:
    plans = [planned("steps", span=(1000.0, 900.0)), planned("mass-ratio", span=(1.0, 1.5))]
    seen: list[LimitCase] = []

    def run(cases: list[Any]) -> dict[str, RunResult]:
        seen.extend(cases)
        return {case.key: completed_result(1e-5, LimitResult, samples=1) for case in cases}

    steps, mass = pursue_plans(plans, run)
    assert [(walk.axis, walk.scene, walk.engine, walk.preset) for walk in steps.walks] == [
        ("steps", "named", "mujoco", "hardened")
    ]
    assert [walk.axis for walk in mass.walks] == ["mass-ratio"]
    (walk,) = mass.walks
    assert isinstance(walk, Walk)
    assert walk.probes[0].errors is not None
    assert walk.probes[0].errors["position"] == 1e-5
    assert steps.lengths == dict(SAW.lengths)
    assert {case.settings.steps_per_revolution for case in seen} >= {1000, 900}


def test_walks_are_reported_in_the_order_of_the_axes() -> None:
    def run(cases: list[Any]) -> dict[str, RunResult]:
        return {case.key: completed_result(1e-5, LimitResult, samples=1) for case in cases}

    asked = ["steps", "iterations", "mass-ratio"]
    for order in (asked, asked[::-1]):
        (found,) = pursue_plans([planned(*order)], run)
        walked = list(dict.fromkeys(walk.axis for walk in found.walks))
        assert walked == sorted(asked, key=list(AXES).index)


def test_plan_of_a_map_searches_its_setup_and_axis(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("conrod.studies.limits.plan.map_search", lambda *given: given)
    (search,) = planned("steps-x-nearness").searches
    assert search() == (Setup("named", SAW, "mujoco", "hardened"), "nearness")


def test_plan_begins_with_a_study_whose_parts_are_empty() -> None:
    empty = planned("steps").empty
    assert [getattr(empty, part) for part in STUDY_PARTS] == [()] * len(STUDY_PARTS)


@pytest.mark.parametrize("name", ["double-rocker", "geneva"])
def test_peak_of_one_pass_is_within_the_pass(name: str) -> None:
    scene = scene_named(name)
    torque, span = ExactTorque(scene.kinematics, scene.speed, gravity=True), scene.kinematics.span
    dense = np.abs(torque.evaluate(np.linspace(*span, 40_001)))
    assert torque.peak == pytest.approx(dense.max(), rel=1e-5)


def test_axis_is_refused_with_reason_when_machine_lacks_it() -> None:
    plan = planned("flank-radius", "steps", span=None)
    assert "flank-radius" in plan.unfit
    assert "cam" in plan.unfit["flank-radius"]
    (refused,) = plan.empty.walks
    assert (refused.axis, refused.refusal) == ("flank-radius", plan.unfit["flank-radius"])
    assert len(plan.searches) == 1
    with pytest.raises(InvalidInput, match=r"^flank-radius: .*cam"):
        check_applicable([plan])
    check_applicable([plan, planned("flank-radius", preset="tuned", scene=CAM)])


def test_unfit_preset_is_named_with_the_engines_reason() -> None:
    plan = planned("steps", scene=CAM)
    assert set(plan.unfit) == {"hardened"}
    assert plan.unfit["hardened"] == engine_named("mujoco").refusal(CAM, setup(CAM).settings())
    assert plan.searches == ()


def test_a_range_is_tried_at_its_ends_before_anything_is_run() -> None:
    with pytest.raises(InvalidInput):
        planned("mass-ratio", span=(1.0, -1.0))


# -- maps and grades ---------------------------------------------------------------------------------------------------


def test_a_coarse_grid_has_every_strides_line_and_the_last_one() -> None:
    asked: list[Any] = []

    def ask(nodes: Any) -> Any:
        asked.append(list(nodes))
        return dict.fromkeys(nodes, "same")
        yield

    found = classify_grid((10, 9), ask, 4)
    with pytest.raises(StopIteration):
        next(found)
    assert asked == [[(i, j) for i in (0, 4, 8, 9) for j in (0, 4, 8)]]


def test_a_map_is_divided_into_its_levels_and_what_failed() -> None:
    assert [map_class(level) for level in ("safe", "rough", "wrong", "broken")] == ["safe", "rough", "wrong", "failed"]


def test_a_maps_rows_begin_where_the_axis_does() -> None:
    steps, nearness = grid_values(setup(steps=1000), "nearness", (5, 4))
    assert (steps[0], steps[-1]) == (1000.0, 4.0)
    assert (nearness[0], nearness[-1]) == pytest.approx((0.1, 1.0 - 1e-9))
    _, stabilisation = grid_values(setup(steps=1000), "stabilisation", (5, 4))
    assert stabilisation[0] == 1000.0


@pytest.mark.parametrize(
    ("error", "level"), [(0.01, Level.SAFE), (0.0101, Level.ROUGH), (0.1, Level.ROUGH), (0.101, Level.WRONG)]
)
def test_a_grade_takes_in_its_own_limit(error: float, level: Level) -> None:
    assert level_of(completed_result(error, LimitResult, samples=1)) is level


def test_a_run_without_a_sample_is_not_undetected() -> None:
    opened = LimitResult("opened")
    assert not is_undetected(opened)
    assert is_undetected(LimitResult("opened", samples=1))


# -- follower float ----------------------------------------------------------------------------------------------------


def test_flight_flies_when_it_shrinks_less_than_root_of_step() -> None:
    assert OnsetProbe(1.0, (1.0, 0.71)).flies
    assert not OnsetProbe(1.0, (1.0, 0.70)).flies
    assert not OnsetProbe(1.0, (1.0, 0.5**0.5)).flies
    assert not OnsetProbe(1.0, (0.0, None)).flies


def test_an_onset_lies_between_what_held_and_what_flew() -> None:
    whole = FollowerFloat("cam", "mujoco", "tuned", 5.0, 0.9, 1.1, ())
    assert whole.onset == pytest.approx(math.sqrt(0.99))
    assert replace(whole, held=None).onset is None
    assert replace(whole, flown=None).onset is None


def test_a_run_at_a_float_speed_lasts_long_enough_to_land() -> None:
    assert onset_case(setup(CAM, "pymunk", "tuned"), 1.1, 0).revolutions == ONSET_REVOLUTIONS


def test_a_press_and_a_saw_have_machines_of_their_own() -> None:
    assert isinstance(setup(PRESS).variant(crank=0.9 * PRESS.crank), type(PRESS))
    assert isinstance(setup().variant(speed=1.0), Saw)
