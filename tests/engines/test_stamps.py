"""Every sample is stamped with the instant that it belongs to: exact states go in, or exact motion comes out."""

from __future__ import annotations

from dataclasses import replace
from importlib.metadata import version
from typing import Any

import mujoco
import numpy as np
import pytest
from catalogue import CAM, PRESS, SAW, VARIATIONS

from conrod import MuJoCoSettings, Outcome, PymunkSettings
from conrod.comparison.compare import compare
from conrod.comparison.outcome import RunVerdict, judge_outcome
from conrod.comparison.trajectory import Piece, concatenate_pieces
from conrod.engines import engine_named
from conrod.engines.mujoco.dynamics import combine_verdicts, detect_engine_stop, drive_torque, simulate
from conrod.engines.mujoco.model import build
from conrod.engines.numerics import frames_from_centres
from conrod.engines.pymunk.dynamics import body_tracks, point_tracks, sample_instants
from conrod.engines.run import run_in_one_piece
from conrod.exact.kinematics import GenericReference
from conrod.exact.motion import Array
from conrod.mechanism.loads import Load, TimePulse, Turn
from conrod.scenes import scene_named

QUANTITIES = ("position", "velocity", "acceleration")

# -- MuJoCo: samples are counted, and all of a sample is of one instant ------------------------------------------------

START, SAMPLES = 0.7, 41
REVERSED = VARIATIONS["saw-reversed"]
RUNS: dict[str, tuple[Any, MuJoCoSettings]] = {
    "press": (PRESS, MuJoCoSettings.hardened(PRESS, 200)),  # slow: its accelerations are of gravity's size
    "saw": (REVERSED, MuJoCoSettings.tuned(REVERSED, 200)),
    "cam": (CAM, replace(MuJoCoSettings.tuned(CAM, 2000), cam_vertices=400)),
}


def run(name: str, steps: int) -> list[Piece]:
    scene, settings = RUNS[name]
    turns = (SAMPLES - 1) / settings.steps_per_revolution
    return list(engine_named("mujoco").run(scene, settings, turns, START, steps))


@pytest.mark.parametrize("name", RUNS)
def test_mujoco_samples_hold_one_instant_each(name: str) -> None:
    (scene, settings), whole = RUNS[name], concatenate_pieces(run(name, 7))
    trajectory, mechanism = whole.trajectory, scene.kinematics.mechanism
    assert trajectory.bodies is not None
    states = trajectory.bodies.position
    at, driver, crank = states.instants, mechanism.driver, 3 * mechanism.body_index[mechanism.crank] + 2
    np.testing.assert_array_equal(at.times, START / scene.speed + settings.timestep * np.arange(SAMPLES))
    np.testing.assert_allclose(whole.clock, at.times - at.times[0], atol=1e-12)
    np.testing.assert_allclose(at.angle, scene.speed * at.times, atol=1e-4)
    for reached, columns, rest in (
        (at.angle, states.poses, driver.start),
        (at.rate, states.rates, 0.0),
        (at.acceleration, states.accelerations, 0.0),
    ):
        np.testing.assert_allclose(driver.sense * (columns[:, crank] - rest), reached, rtol=1e-9, atol=1e-9)
    # Points are read by sensors, links from the coordinates: what is not of one instant does not fit.
    computed = scene.kinematics.point_derivatives([states.poses, states.rates, states.accelerations])
    assert set(trajectory.points) == set(computed) == set(scene.lengths)
    for point, derivatives in computed.items():
        for order, (quantity, values) in enumerate(zip(QUANTITIES, derivatives, strict=True)):
            track = getattr(trajectory.points[point], quantity)
            assert track.instants is at
            size = scene.lengths[point] * abs(scene.speed) ** order
            np.testing.assert_allclose(track.values, values, rtol=0.0, atol=1e-6 * size)
    if name == "press":
        assert max(map(compare(trajectory, scene).worst, QUANTITIES)) < 1e-4


def test_a_mujoco_run_states_its_settings_and_drive_torque() -> None:
    scene, settings = RUNS["press"]
    pieces = run("press", 16)
    assert [(piece.first_step, len(piece.clock)) for piece in pieces] == [(0, 17), (17, 16), (33, 8)]
    for piece in pieces:
        one = piece.trajectory
        assert (one.engine, one.engine_version, one.settings) == ("mujoco", mujoco.__version__, settings)
        assert (one.speed, one.revolutions, one.outcome, one.reason) == (scene.speed, 0.2, Outcome.COMPLETED, "")
        assert one.bodies is not None
        assert piece.drive_torque == pytest.approx(-settings.armature * one.bodies.position.instants.acceleration)
        assert piece.warnings == {}
    free = replace(settings, armature=0.0)
    begun = next(engine_named("mujoco").run(scene, free, 0.02))
    assert (begun.drive_torque, len(begun.clock)) == (None, 5)
    assert begun.trajectory.bodies is not None
    instants = begun.trajectory.bodies.position.instants
    assert instants.times[0] == instants.angle[0] == 0.0
    assert drive_torque(replace(settings, armature=0.5), instants) == pytest.approx(-0.5 * instants.acceleration)


@pytest.mark.parametrize("judged", [Outcome.COMPLETED, Outcome.OPENED, Outcome.EXPLODED])
@pytest.mark.parametrize("ended", [None, Outcome.DIVERGED, Outcome.RESET])
def test_a_reset_outranks_all_verdicts_and_a_stop_completed(judged: Any, ended: Any) -> None:
    expected = ended if ended is Outcome.RESET or (ended and judged is Outcome.COMPLETED) else judged
    assert combine_verdicts(RunVerdict(judged), ended and RunVerdict(ended)).outcome is expected


def test_a_reset_in_the_first_steps_is_detected() -> None:
    stiff = replace(MuJoCoSettings.stock(SAW, 100), solref=(-1e25, -1e12), hardening=1e-6, autoreset=True)
    (whole,) = engine_named("mujoco").run(SAW, stiff, 0.1)
    assert np.all(np.diff(whole.clock) >= 0.0)
    assert whole.trajectory.outcome is Outcome.RESET


@pytest.mark.parametrize(
    ("warnings", "outcome", "step"), [({"BADQACC": 1}, Outcome.RESET, 6), ({}, Outcome.DIVERGED, 7)]
)
def test_a_clock_that_stands_after_a_warning_is_a_reset(warnings: Any, outcome: Outcome, step: int) -> None:
    settings = replace(MuJoCoSettings.stock(SAW, 100), autoreset=True)
    clock = settings.timestep * np.array([5.0, 6.0, 6.0])
    found = detect_engine_stop(clock, 5, 4.0 * settings.timestep, warnings, settings)
    assert found.outcome is outcome
    assert found.reason.endswith(f"at step {step}")


def test_a_failure_in_one_piece_is_reported_in_all_later_ones() -> None:
    light = replace(MuJoCoSettings.tuned(SAW, 500), armature=0.1)  # stalls near a dead centre, and goes on
    outcomes, alone = [], []
    for piece in engine_named("mujoco").run(SAW, light, 1.0, 0.0, 50):
        assert piece.trajectory.bodies is not None
        outcomes.append(piece.trajectory.outcome)
        alone.append(judge_outcome(SAW.kinematics, piece.trajectory.bodies, SAW.speed).outcome)
    first = outcomes.index(Outcome.STALLED)
    assert set(outcomes[:first]) == {Outcome.COMPLETED} == {alone[-1]}
    assert set(outcomes[first:]) == {Outcome.STALLED}


def test_states_and_sensors_equal_a_plain_loop_of_steps() -> None:
    scene, settings = RUNS["press"]
    made = build(scene, settings)
    times, states, sensors = simulate(made, scene, settings, 5, START)
    np.testing.assert_array_equal(times, START / scene.speed + settings.timestep * np.arange(6))
    assert len(states) == len(sensors) == 6
    data = mujoco.MjData(made.model)
    data.qpos[:], data.qvel[:] = made.start_state(scene, START)
    for state, read in zip(states, sensors, strict=True):
        expected = np.concatenate([[data.time], data.qpos, data.qvel])
        np.testing.assert_array_equal(state[: len(expected)], expected)
        mujoco.mj_step(made.model, data)  # sensors after a step are of the state before
        np.testing.assert_array_equal(read, data.sensordata)


# -- pymunk: velocities lie between positions, accelerations between velocities ----------------------------------------

LEG = scene_named("jansen-leg")  # of points and centres of gravity anywhere on its links
STEP, GAIN = 1e-5, 0.5  # of a turn; the crank gains so much of its speed, squared, a radian
ROUNDING = 1e-8


def exact_states(scene: Any, times: Array) -> tuple[Array, Array, Array]:
    """Crank angles, poses and rates (T, 3 n) of the links' frames, with a crank that gains speed steadily."""
    gain = GAIN * scene.speed**2
    angles, rates = scene.speed * times + 0.5 * gain * times**2, scene.speed + gain * times
    poses, slopes = scene.kinematics.derivatives(angles, 1)
    return angles, poses, slopes * rates[:, None]


def centre_states(scene: Any, poses: Array, rates: Array) -> tuple[Array, Array]:
    """The same of the centres of gravity."""
    centres, speeds = poses.copy(), rates.copy()
    for i, body in enumerate(scene.kinematics.mechanism.bodies):
        arm = complex(*body.centre_of_gravity) * np.exp(1j * poses[:, 3 * i + 2])
        swung = 1j * arm * rates[:, 3 * i + 2]
        for k, part in enumerate(("real", "imag")):
            centres[:, 3 * i + k] += getattr(arm, part)
            speeds[:, 3 * i + k] += getattr(swung, part)
    return centres, speeds


@pytest.mark.parametrize("scene", [SAW, PRESS, CAM, LEG], ids=["saw", "press", "cam", "leg"])
def test_pymunk_samples_are_stamped_at_their_instants(scene: Any) -> None:
    mechanism, h = scene.kinematics.mechanism, STEP * scene.period
    times = 0.1 * scene.period + h * np.arange(12)
    # A contact's velocities fit the instant itself; those of joints the middle of the step that follows.
    ahead = 0.0 if mechanism.cam_contacts else 0.5 * h
    poses, rates = exact_states(scene, times)[1], exact_states(scene, times + ahead)[2]
    # The turn half a step on is had from the rate there.
    centres, speeds = (
        centre_states(scene, poses, rates)[0],
        centre_states(scene, exact_states(scene, times + ahead)[1], rates)[1],
    )
    at = sample_instants(mechanism, h, times, centres, speeds)
    expected = {
        "position": times,
        "velocity": times[1:] + ahead,
        "acceleration": 0.5 * (times[3:] + times[2:-1]) + ahead,
    }
    tracks, links = point_tracks(mechanism, at, centres, speeds), body_tracks(mechanism, at, centres, speeds)
    assert set(tracks) == set(scene.lengths)
    for order, (quantity, instants) in enumerate(expected.items()):
        stamps = getattr(at, quantity)
        np.testing.assert_allclose(stamps.times, instants, rtol=1e-12)
        angles, _, _ = exact_states(scene, instants)
        rate = scene.speed + GAIN * scene.speed**2 * instants
        np.testing.assert_allclose(stamps.angle, angles, rtol=0.0, atol=ROUNDING)
        if quantity != "position":
            np.testing.assert_allclose(stamps.rate, rate, rtol=ROUNDING)
        # Two rates of a difference: rounding over the step.
        gain = GAIN * scene.speed**2 if quantity == "acceleration" else 0.0
        np.testing.assert_allclose(stamps.acceleration, gain, rtol=1e-5, atol=0.0)
        states, slopes = getattr(links, quantity), scene.kinematics.derivatives(angles, 2)
        assert states.instants is stamps
        moved = slopes[1] * rate[:, None], slopes[2] * rate[:, None] ** 2 + slopes[1] * GAIN * scene.speed**2
        found_of = states.poses, states.rates, states.accelerations
        for k, (values, right) in list(enumerate(zip(found_of, (slopes[0], *moved), strict=True)))[: order + 1]:
            off = (1e-4 if k == 2 else ROUNDING) * np.abs(right).max()
            np.testing.assert_allclose(values, right, rtol=0.0, atol=off)
        for point, track in tracks.items():
            exact = getattr(scene.motion(angles, rate, GAIN * scene.speed**2).point(point), quantity)
            found = getattr(track, quantity)
            assert found.instants is stamps
            size = scene.lengths[point] * abs(scene.speed) ** order
            np.testing.assert_allclose(found.values, exact, rtol=0.0, atol=size * (1e-4 if order == 2 else ROUNDING))


def test_a_pymunk_run_states_its_settings_and_starts_at_zero() -> None:
    settings = PymunkSettings.tuned(SAW, 100)
    (whole,) = engine_named("pymunk").run(SAW, settings, 0.1)
    made = whole.trajectory
    assert (made.engine, made.engine_version, made.settings) == ("pymunk", version("pymunk"), settings)
    instants = made.bodies.position.instants
    assert (len(instants.times), instants.times[0]) == (11, 0.0)
    assert instants.angle[0] == pytest.approx(0.0, abs=1e-12)


def test_body_frames_follow_from_centres_of_gravity() -> None:
    for scene in (SAW, PRESS, CAM, LEG):
        _, poses, rates = exact_states(scene, scene.period * np.linspace(0.0, 1.0, 7))
        back = frames_from_centres(scene.kinematics.mechanism, *centre_states(scene, poses, rates))
        for found, expected in zip(back, (poses, rates), strict=True):
            np.testing.assert_allclose(found, expected, rtol=0.0, atol=1e-12 * np.abs(expected).max())


# -- loads that are programs in time act at their times, wherever a run begins -----------------------------------------


@pytest.mark.parametrize(("engine", "preset"), [("mujoco", "stock"), ("pymunk", "tuned")])
def test_a_pulse_acts_at_its_time_whatever_the_start_angle(engine: str, preset: str) -> None:
    scene, made, start = scene_named("saw-500rpm"), engine_named(engine), 2.0
    begin = start / scene.speed

    def moved(*pulses: TimePulse) -> Array:
        """Poses and rates in a quarter of a turn, under pulses on the rod."""
        loads = tuple(Load(f"pulse-{k}", Turn("ground", "rod"), pulse) for k, pulse in enumerate(pulses))
        machine = GenericReference(replace(scene.mechanism(), loads=loads), scene.speed)
        bodies = run_in_one_piece(made, machine, made.presets[preset](scene, 200), 0.25, start).bodies
        assert bodies is not None
        return np.hstack([bodies.position.poses, bodies.position.rates])

    # Over before the run begins; had the clock begun with the run it would act in all of it.
    assert np.array_equal(moved(TimePulse(3e3, 0.0, 0.9 * begin)), moved())
    assert not np.array_equal(moved(TimePulse(3e3, begin, 2.0 * begin)), moved())
