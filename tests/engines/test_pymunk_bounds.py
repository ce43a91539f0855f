"""pymunk's error law: each part of it against the scheme itself, a formula written apart, or a number by hand."""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from catalogue import CAM, SAW

from conrod.comparison.compare import compare
from conrod.engines.cam_polygon import FollowerMotion
from conrod.engines.capabilities import ExpectedError
from conrod.engines.engine import run_extent
from conrod.engines.numerics import NO_BOUND_AT_CHANGE_POINT, centres_from_frames
from conrod.engines.pymunk import ITERATION_ERROR_SHARE, PymunkSettings, error_bound
from conrod.engines.pymunk.dynamics import point_tracks, sample_instants
from conrod.engines.pymunk.engine import PYMUNK_ENGINE
from conrod.engines.pymunk.error_bound import (
    _point_lags,
    expected_error,
    first_sample_errors,
    largest_lags,
    scheme_states,
    shape_error,
    weight_rounding,
)
from conrod.engines.pymunk.space import rounded_polygon, wedges, with_crank_centred
from conrod.engines.run import run_in_one_piece
from conrod.exact.motion import QUANTITIES
from conrod.mechanism.loads import Displacement, Elastic, Load, LoadLaw, Steady, TimePulse
from conrod.scenes import catalogue_scene

STEPS = 400
REVERSED: Any = SAW.with_parameters(speed=-SAW.speed)
SIX_BAR: Any = catalogue_scene("six-bar")
LEG: Any = catalogue_scene("jansen-leg")
PASS: Any = catalogue_scene("swinging-four-bar")


def step_of(machine: Any, steps: int = STEPS) -> float:
    return 2.0 * math.pi / (steps * abs(machine.speed))


# -- the scheme --------------------------------------------------------------------------------------------------------


def test_first_samples_are_judged_at_the_cranks_acceleration(monkeypatch: pytest.MonkeyPatch) -> None:
    def accelerated(*given: Any) -> Any:
        at = sample_instants(*given)
        gained = at.acceleration.acceleration + SAW.speed**2
        return replace(at, acceleration=replace(at.acceleration, acceleration=gained))

    *before, acceleration = first_sample_errors(SAW, STEPS, 1.0)
    monkeypatch.setattr(error_bound, "sample_instants", accelerated)
    *others, off = first_sample_errors(SAW, STEPS, 1.0)
    assert others == before
    assert off > acceleration + 0.1


@pytest.mark.parametrize("machine", [SAW, REVERSED], ids=["saw", "reversed"])
def test_scheme_states_obey_the_scheme(machine: Any) -> None:
    """x_(n+1) = x_n + h v_n at the centres of gravity, and v_n removes what the joint equations leave in one step."""
    kinematics, h, start = machine.kinematics, step_of(machine, 100), 0.3
    poses, rates = scheme_states(machine, h, start, 30)
    angles = start + machine.speed * h * np.arange(31)
    assert poses.shape == rates.shape == (31, 3 * len(kinematics.mechanism.bodies))
    assert poses[0] == pytest.approx(kinematics.poses(angles[:1])[0], abs=1e-14)
    centres, speeds = centres_from_frames(with_crank_centred(kinematics.mechanism), poses, rates)
    assert np.diff(centres, axis=0) == pytest.approx(h * speeds[:-1], abs=1e-12)
    speed = np.full(31, machine.speed)
    left = kinematics.residual([poses], angles)
    assert kinematics.residual([poses, rates], speed) == pytest.approx(-left / h, abs=1e-9)
    # It lags behind the exact motion: else the equations would leave nothing to remove.
    assert np.abs(left[1:]).max() > 1e-6


def scheme_errors(machine: Any, steps: int, start: float = 0.3) -> list[float]:
    """Largest errors over L, omega L, omega^2 L of a turn of the scheme, all samples but those after an exact start."""
    h, kinematics = step_of(machine, steps), machine.kinematics
    mechanism = with_crank_centred(kinematics.mechanism)
    poses, rates = scheme_states(machine, h, start, steps + 10)
    centres, speeds = centres_from_frames(mechanism, poses, rates)
    times = start / machine.speed + h * np.arange(len(poses))
    at = sample_instants(mechanism, h, times, centres, speeds)
    tracks, largest = point_tracks(mechanism, at, centres, speeds), [0.0, 0.0, 0.0]
    for k, quantity in enumerate(QUANTITIES):
        instants = getattr(at, quantity)
        exact = machine.motion(instants.angle, instants.rate, instants.acceleration)
        for name, found in tracks.items():
            off = getattr(found, quantity).values - getattr(exact.point(name), quantity)
            size = np.linalg.norm(off[5:], axis=1).max() / (machine.lengths[name] * abs(machine.speed) ** k)
            largest[k] = max(largest[k], float(size))
    return largest


@pytest.mark.parametrize("machine", [SAW, REVERSED, LEG], ids=["saw", "reversed", "leg"])
def test_errors_of_the_scheme_are_lags_times_the_step_squared(machine: Any) -> None:
    step = 2.0 * math.pi / 2000
    assert np.array(largest_lags(machine)) * step**2 == pytest.approx(scheme_errors(machine, 2000), rel=0.01)


@pytest.mark.parametrize(
    ("machine", "start"),
    [(SAW, 0.0), (SAW, 4.7), (REVERSED, 1.0), (SIX_BAR, 2.0), (PASS, 0.0)],
    ids=["saw", "saw at 4.7", "reversed", "six-bar", "pass"],
)
def test_first_sample_errors_are_those_of_a_run(machine: Any, start: float) -> None:
    settings = replace(PymunkSettings.tuned(machine, STEPS), iterations=4000)
    begin, _ = run_extent(machine, STEPS, 1.0)
    begin = begin if machine is PASS else start
    made = compare(run_in_one_piece(PYMUNK_ENGINE, machine, settings, 4.0 / STEPS, begin), machine)
    found = first_sample_errors(machine, STEPS, start)
    # 4000 iterations leave up to 0.3 % of them.
    assert found == pytest.approx([made.worst(q) for q in QUANTITIES], rel=0.004)


# -- rounding of weight ------------------------------------------------------------------------------------------------


def loaded_machine(machine: Any, law: LoadLaw, direction: float = 0.0) -> Any:
    """Machine with weight, and a load on its last body along a direction [rad]."""
    load = Load("push", Displacement(machine.mechanism().bodies[-1].name, (0.0, 0.0), direction), law)
    mechanism = replace(machine.kinematics.mechanism, loads=(load,), gravity=(0.0, -9.81))
    kinematics = type(machine.kinematics)(mechanism)
    return SimpleNamespace(kinematics=kinematics, speed=machine.speed, lengths=machine.lengths)


def gain(machine: Any) -> float:
    """Displacement of an observed point over L where all joint equations are off by one, by differences of them."""
    kinematics, size, largest = machine.kinematics, 1e-6, 0.0
    for poses in kinematics.poses(np.linspace(0.0, 2.0 * math.pi, 60, endpoint=False)):
        aside = size * np.eye(len(poses))
        ahead, back = (kinematics.residual([poses + sign * aside], np.zeros(len(poses))) for sign in (1.0, -1.0))
        inverse = np.linalg.inv((ahead - back).T / (2.0 * size))
        moved = kinematics.point_derivatives([np.tile(poses, (len(poses), 1)), inverse.T])
        for name, length in machine.lengths.items():
            largest = max(largest, float(np.linalg.norm(moved[name][1], axis=1).sum() / length))
    return largest


@pytest.mark.parametrize(
    ("machine", "law", "force"),
    [
        (REVERSED, Steady(0.0), 0.0),
        (REVERSED, Steady(5000.0), 5000.0),
        (SAW, TimePulse(5000.0, 2.0, 4.0), 0.0),  # which comes when the turn of 1.5 s is over
    ],
    ids=["weight", "force", "late"],
)
def test_weight_rounding_is_three_eps_of_acceleration_in_a_step(machine: Any, law: LoadLaw, force: float) -> None:
    machine, h = loaded_machine(machine, law), 0.01
    mass = machine.kinematics.mechanism.bodies[-1].mass
    rounded = 3.0 * 2.0**-52 * math.hypot(force / mass, 9.81) * h * gain(machine)
    speed = abs(machine.speed)
    expected = [rounded * h, rounded / speed, 2.0 * rounded / (speed**2 * h)]
    assert weight_rounding(machine, h) == pytest.approx(expected, rel=0.01)


# -- the whole law -----------------------------------------------------------------------------------------------------


@pytest.fixture
def parts(monkeypatch: pytest.MonkeyPatch) -> dict[str, Any]:
    """Parts of the law, each a number of its own; keys are their functions."""
    values: dict[str, Any] = {
        "largest_derivatives": [1.0, 1.0, 1.0, 5.0, 7.0, 11.0, 13.0],
        "rounding_bound": 0.0,
        "largest_lags": (1.0, 2.0, 3.0),
        "first_sample_errors": [0.0, 0.0, 0.0],
        "weight_rounding": [0.0, 0.0, 0.0],
    }

    def answer(name: str) -> None:
        monkeypatch.setattr(error_bound, name, lambda *_: values[name])

    for name in tuple(values):
        answer(name)
    return values


def law_of(machine: Any = SAW, steps: int = 100) -> list[float]:
    found = expected_error(machine, PymunkSettings.tuned(machine, steps), 0.5)
    return [getattr(found, quantity) for quantity in QUANTITIES]


STEP = 2.0 * math.pi / 100
# Lag, and the next term in the step: 1/2, 11/24 and 5/12 of the third, fourth and fifth derivative.
LAGS = [
    STEP**2 * (1.0 + STEP * 5.0 / 2.0),
    STEP**2 * (2.0 + STEP * 7.0 * 11.0 / 24.0),
    STEP**2 * (3.0 + STEP * 11.0 * 5.0 / 12.0),
]


def test_error_law_is_the_lag_with_its_next_term_and_rounding(parts: dict[str, Any]) -> None:
    assert law_of() == pytest.approx(LAGS, rel=1e-14)
    parts["rounding_bound"] = 1e-4
    assert law_of() == pytest.approx([lag + 1e-4 / STEP**k for k, lag in enumerate(LAGS)], rel=1e-14)


def test_error_law_is_of_the_first_samples_if_these_are_larger(parts: dict[str, Any]) -> None:
    parts["first_sample_errors"] = [1.0, 0.0, 3.0]
    first = 1.0 + ITERATION_ERROR_SHARE
    assert law_of() == pytest.approx([first, LAGS[1], 3.0 * first], rel=1e-14)


def test_weight_rounding_counts_if_more_than_a_millionth(parts: dict[str, Any]) -> None:
    parts["weight_rounding"] = [1.01e-6 * LAGS[0], 0.99e-6 * LAGS[1], 2.0]
    found = law_of()
    assert found[0] == pytest.approx(LAGS[0] * (1.0 + 1.01e-6), rel=1e-14)
    assert found[1:] == pytest.approx([LAGS[1], LAGS[2] + 2.0], rel=1e-14)


def test_parts_of_error_law_get_the_same_machine_steps_and_start(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: dict[str, Any] = {}

    def answer(name: str, value: Any) -> None:
        monkeypatch.setattr(error_bound, name, lambda *given: (asked.__setitem__(name, given), value)[1])

    answer("largest_derivatives", [1.0] * 6)
    answer("rounding_bound", 0.0)
    answer("largest_lags", (1.0, 1.0, 1.0))
    answer("first_sample_errors", [1.0, 1.0, 1.0])
    answer("weight_rounding", [0.0, 0.0, 0.0])
    law_of(SAW, 250)
    assert asked == {
        "largest_derivatives": (SAW.kinematics, 5),
        "rounding_bound": (SAW.kinematics, 250),
        "largest_lags": (SAW,),
        "first_sample_errors": (SAW, 250, 0.5),
        "weight_rounding": (SAW, pytest.approx(step_of(SAW, 250))),
    }


def test_error_law_requires_full_correction_and_no_change_point() -> None:
    assert expected_error(SAW, PymunkSettings.stock(SAW, 100)) == ExpectedError()
    flat: Any = catalogue_scene("parallelogram")
    assert expected_error(flat, PymunkSettings.tuned(flat, 100)) == ExpectedError(law=NO_BOUND_AT_CHANGE_POINT)
    assert expected_error(SAW, PymunkSettings.tuned(SAW, 100)).law == error_bound.LAW


# -- cams --------------------------------------------------------------------------------------------------------------


def test_cam_shape_error_is_polygon_error_over_pressure_cosine() -> None:
    settings = PymunkSettings.tuned(CAM, 2000)
    contact = CAM.kinematics.mechanism.cam_contacts[0]
    polygon = rounded_polygon(contact.profile, settings.cam_vertices)
    # Pressure angle of an in-line follower: its velocity ds/dtheta over its distance from the shaft.
    angles = np.linspace(0.0, 2.0 * math.pi, 7200, endpoint=False)
    motion = CAM.motion(angles, 1.0).point(CAM.output)
    tangent = np.linalg.norm(motion.velocity, axis=1) / np.linalg.norm(motion.position, axis=1)
    assert shape_error(CAM, settings) == pytest.approx(polygon.error * math.hypot(1.0, tangent.max()), rel=1e-6)


def cam_law(machine: Any, settings: Any, falls: Any) -> tuple[float, float]:
    """Position and rms of velocity by the text of the module, from accelerations of free fall (T,) [m/s^2]."""
    follower, h, speed = FollowerMotion.from_machine(machine), settings.timestep, abs(machine.speed)
    polygon = rounded_polygon(follower.contact.profile, settings.cam_vertices)
    fall, curve = falls.max(), -follower.acceleration
    drop = fall * h**2 + np.abs(curve).max() * h**2 / 2.0 + speed * follower.largest_slope_jump(polygon) * h
    position = (drop + polygon.error / follower.cosine.min()) / follower.lift
    away = np.where(curve > 0.0, curve, 0.0) / falls
    share = np.where(away <= 0.25, away, np.minimum(1.0, 2.0 * away)).mean()
    starts = sum(curve[i] > 0.0 and not curve[i - 1] > 0.0 for i in range(len(curve)))
    share += (1 + starts + len(wedges(polygon))) / settings.steps_per_revolution
    velocity = (math.sqrt(min(1.0, share)) * fall * h / speed + follower.facet_slope_rms(polygon)) / follower.lift
    return float(position), float(velocity)


@pytest.mark.parametrize("speed", [1.0, -8.0, 60.0], ids=["slow", "reversed", "fast"])
def test_error_law_of_a_cam_adds_fall_corners_and_polygon(speed: float) -> None:
    machine: Any = CAM.with_parameters(speed=speed)
    settings = PymunkSettings.tuned(machine, 2000)
    mechanism = machine.kinematics.mechanism
    mass = mechanism.body(mechanism.cam_contacts[0].b).mass
    x, y = mechanism.constant_force_on(mechanism.cam_contacts[0].b)
    fall = np.full(7200, math.hypot(mechanism.gravity[0] + x / mass, mechanism.gravity[1] + y / mass))
    assert fall[0] > 0.0
    position, velocity = cam_law(machine, settings, fall)
    found = expected_error(machine, settings)
    assert (found.position, found.velocity_rms) == pytest.approx((position, velocity), rel=1e-9)
    assert (found.velocity, found.acceleration, found.law) == (None, None, error_bound.CONTACT_LAW)


def test_loaded_follower_falls_by_weight_preload_and_spring() -> None:
    """A released follower is moved by weight, preload and spring, whatever its motion in contact."""
    stiffness, lift = 2000.0, CAM.kinematics.travel
    machine = loaded_machine(CAM.with_parameters(speed=60.0), Elastic(stiffness), 0.5 * math.pi)
    settings, angles = PymunkSettings.tuned(CAM, 2000), np.linspace(0.0, 2.0 * math.pi, 7200, endpoint=False)
    mechanism = machine.kinematics.mechanism
    body = mechanism.cam_contacts[0].b
    height = machine.kinematics.poses(angles)[:, 3 * mechanism.body_index[body] + 1]
    _, preload = mechanism.constant_force_on(body)
    falls = 9.81 + (stiffness * height - preload) / mechanism.body(body).mass
    assert np.ptp(falls) == pytest.approx(stiffness * lift / mechanism.body(body).mass, rel=1e-6)
    settings = replace(settings, timestep=step_of(machine, 2000))
    position, velocity = cam_law(machine, settings, falls)
    found = expected_error(machine, settings)
    assert (found.position, found.velocity_rms) == pytest.approx((position, velocity), rel=1e-9)


def test_lag_of_the_acceleration_is_the_rate_of_the_velocitys() -> None:
    """Lags of a point that turns with its body, whose centre and angle are polynomials, number by number."""
    x, y = np.polynomial.Polynomial([0.1, 0.3, -0.2, 0.5, 0.7]), np.polynomial.Polynomial([0.0, -0.4, 0.6, 0.1, -0.3])
    angle = np.polynomial.Polynomial([0.2, 0.8, 0.5, -0.3, 0.4])

    def lags(at: float) -> tuple[Any, Any, Any]:
        turns = [np.array([[angle.deriv(k)(at) if k else angle(at)]]) for k in range(5)]
        centre = [np.array([[one.deriv(k)(at) if k else one(at) for one in (x, y)]]) for k in range(5)]
        side = 0.3 * np.array([[np.cos(turns[0][0, 0]), np.sin(turns[0][0, 0])]])
        return _point_lags(centre, [centre[0] + side, *(np.full((1, 2), 24.0 * k) for k in range(1, 5))], turns)

    before, after = lags(0.5 - 1e-5)[1], lags(0.5 + 1e-5)[1]
    # A central difference of positions lags by a 24th of their fourth derivative, 96 here.
    assert lags(0.5)[2] == pytest.approx((after - before) / 2e-5 - 96.0 / 24.0, rel=1e-8)
    # By hand: centre 2, 3 and 4, angle 2, 3, 5 and 7 with their derivatives, a metre from the centre.
    values = [np.array([[float(k), 0.0]]) for k in (0, 0, 2, 3, 4)]
    turns = [np.array([[float(k)]]) for k in (0, 2, 3, 5, 7)]
    position, velocity, acceleration = _point_lags(
        values, [np.array([[1.0, 0.0]])] * 4 + [np.array([[48.0, 24.0]])], turns
    )
    assert position == pytest.approx(np.array([[1.0, 1.5]]))
    assert velocity == pytest.approx(np.array([[11.0 / 8.0 - 9.0 / 4.0, 55.0 / 24.0]]))
    assert acceleration == pytest.approx(np.array([[-11.0 / 4.0 - 57.0 / 8.0 - 2.0, 77.0 / 24.0 - 9.0 / 2.0 - 1.0]]))
