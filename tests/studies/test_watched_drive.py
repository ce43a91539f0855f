"""What is watched of a drive: its torque, and over a long run its phase and the clock that sums its steps."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from catalogue import CAM, PRESS, SAW, VARIATIONS
from watched import cell, coarse_cam, extremes, watched

from conrod import MuJoCoSettings, PymunkSettings
from conrod.engines import engine_named
from conrod.engines.massless_rod import DISTANCE_JOINT
from conrod.exact.dynamics.inverse import reactions
from conrod.runs.trajectory import Piece
from conrod.scenes import SCENES
from conrod.studies.limits.recorders import ExactTorque, History, marked
from conrod.studies.limits.stream_run import stream_run

TURN = 2.0 * math.pi
STEPS = 100


# -- drive torque ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("scene", [SAW, PRESS, VARIATIONS["saw-reversed"]], ids=["saw", "press", "saw reversed"])
def test_the_exact_torque_is_the_drivers_reaction(scene: Any) -> None:
    exact = ExactTorque(scene.kinematics, scene.speed, gravity=True, rod="body")
    angle = np.linspace(0.0, TURN, 720)
    told = reactions(scene.kinematics, angle, scene.speed).drive_torque
    np.testing.assert_allclose(exact.at(angle), told, atol=1e-12 * exact.peak)
    assert exact.peak == pytest.approx(np.abs(told).max(), rel=1e-3)
    light = ExactTorque(scene.kinematics, scene.speed, gravity=False, rod="body")
    assert np.abs(light.at(angle) - told).max() > 1e-3 * exact.peak


@pytest.mark.parametrize("gravity", [True, False])
@pytest.mark.parametrize(
    "scene", [SCENES["saw-500rpm"], PRESS, VARIATIONS["saw-reversed"]], ids=["saw", "press", "saw reversed"]
)
def test_a_hardened_drive_gives_the_exact_torque(scene: Any, gravity: bool) -> None:
    hardened = replace(MuJoCoSettings.hardened(scene, 400), gravity=gravity)
    error = extremes(watched(scene, hardened)).torque
    assert error is not None
    assert error < 1e-6
    soft = extremes(watched(scene, replace(hardened, hardening=None))).torque
    assert soft is not None
    assert soft > 20.0 * error


def test_the_mass_of_a_rod_that_is_left_out_is_not_in_the_exact_torque() -> None:
    saw: Any = SCENES["saw-500rpm"]
    angle = np.linspace(0.0, TURN, 100)
    without = ExactTorque(saw.kinematics, saw.speed, gravity=True, rod=DISTANCE_JOINT)
    light = saw.with_parameters(rod_mass=1e-6, rod_inertia=1e-8)
    told = ExactTorque(light.kinematics, saw.speed, gravity=True, rod="body").at(angle)
    np.testing.assert_allclose(without.at(angle), told, atol=1e-5 * without.peak)
    whole = ExactTorque(saw.kinematics, saw.speed, gravity=True, rod="body").at(angle)
    assert np.abs(whole - told).max() > 0.01 * without.peak


def test_what_no_engine_tells_is_none() -> None:
    assert extremes(watched(SAW, PymunkSettings.tuned(SAW, STEPS))).torque is None
    assert extremes(watched(CAM, coarse_cam(MuJoCoSettings.tuned(CAM, 5 * STEPS)))).torque is None
    undriven = replace(MuJoCoSettings.stock(SAW, 60), armature=0.0)
    assert [piece.drive_torque for piece in engine_named("mujoco").run(SAW, undriven, 0.1, 0.7, 4)] == [None] * 2


def test_a_torque_that_is_off_by_a_part_in_a_billion_is_seen(monkeypatch: pytest.MonkeyPatch) -> None:
    scene: Any = PRESS
    exact = ExactTorque(scene.kinematics, scene.speed, gravity=True, rod="body")
    pieces = engine_named("pymunk").run

    def told(*args: Any) -> Iterator[Piece]:
        for piece in pieces(*args):
            bodies = piece.trajectory.bodies
            assert bodies is not None
            torque = exact.at(bodies.acceleration.instants.angle)
            torque[-1] += off * exact.peak
            yield replace(piece, drive_torque=torque)

    monkeypatch.setattr(engine_named("pymunk"), "run", told)
    for off in (0.0, 1e-9, -1e-9):
        error = extremes(stream_run(cell(PRESS, PymunkSettings.tuned(PRESS, STEPS)))).torque
        assert error == pytest.approx(abs(off), abs=1e-15)


# -- history ---------------------------------------------------------------------------------------------------------


def test_the_marks_are_1_2_5_and_the_last_revolution() -> None:
    assert marked(2.0) == ()
    assert marked(2.5) == (1, 2)
    assert marked(5.0) == (1, 2, 5)
    assert marked(37.9) == (1, 2, 5, 10, 20, 37)
    assert marked(1e6)[-4:] == (100_000, 200_000, 500_000, 1_000_000)


@pytest.mark.parametrize("length", [1, 3, 10, 17, 1000])
def test_samples_belong_to_their_mark_wherever_a_run_is_cut(length: int) -> None:
    steps, revolutions = 10, 12.5
    index = np.arange(126.0)
    history = History(revolutions, steps)
    for begin in range(0, len(index), length):
        part = index[begin : begin + length]
        history.add(begin, part, 1000.0 - part, -part, 2.0 * part)
    assert [mark.revolution for mark in history.marks] == [1, 2, 5, 10, 12]
    assert [mark.position for mark in history.marks] == [10.0, 20.0, 50.0, 100.0, 120.0]
    assert [mark.closure for mark in history.marks] == [1000.0, 989.0, 979.0, 949.0, 899.0]
    assert [mark.phase for mark in history.marks] == [-10.0, -20.0, -50.0, -100.0, -120.0]
    assert [mark.clock for mark in history.marks] == [20.0, 40.0, 100.0, 200.0, 240.0]


@pytest.mark.parametrize("settings", [MuJoCoSettings.tuned(SAW, 50), PymunkSettings.tuned(SAW, 50)])
def test_a_long_run_keeps_its_loops_closed_and_its_clock_drifts(settings: Any) -> None:
    history = extremes(watched(SAW, settings, 100.0)).history
    assert [mark.revolution for mark in history] == [1, 2, 5, 10, 20, 50, 100]
    later = [mark.closure for mark in history[1:]]
    assert max(later) < 1.001 * min(later)
    assert abs(history[-1].clock) == pytest.approx(clock_drift(settings, 100), rel=1e-6)
    assert abs(history[-1].phase) < 1e-8
    if settings.engine == "pymunk":
        assert abs(history[-1].phase) < 0.1 * abs(history[-1].clock), "its crank is written by counted steps"


def clock_drift(settings: Any, revolutions: int) -> float:
    """Of a loop that sums its steps [rad]."""
    time = 0.0
    for _ in range(50 * revolutions):
        time += settings.timestep
    return abs(SAW.speed * (time - 50 * revolutions * settings.timestep))
