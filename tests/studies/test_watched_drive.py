"""What is watched of a drive: its torque."""

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
from conrod.exact.dynamics.inverse import reactions
from conrod.runs.trajectory import Piece
from conrod.scenes import SCENES
from conrod.studies.limits.recorders import ExactTorque
from conrod.studies.limits.stream_run import stream_run

TURN = 2.0 * math.pi
STEPS = 100


# -- drive torque ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("scene", [SAW, PRESS, VARIATIONS["saw-reversed"]], ids=["saw", "press", "saw reversed"])
def test_the_exact_torque_is_the_drivers_reaction(scene: Any) -> None:
    exact = ExactTorque(scene.kinematics, scene.speed, gravity=True)
    angle = np.linspace(0.0, TURN, 720)
    told = reactions(scene.kinematics, angle, scene.speed).drive_torque
    np.testing.assert_allclose(exact.at(angle), told, atol=1e-12 * exact.peak)
    assert exact.peak == pytest.approx(np.abs(told).max(), rel=1e-3)
    light = ExactTorque(scene.kinematics, scene.speed, gravity=False)
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


def test_what_no_engine_tells_is_none() -> None:
    assert extremes(watched(SAW, PymunkSettings.tuned(SAW, STEPS))).torque is None
    assert extremes(watched(CAM, coarse_cam(MuJoCoSettings.tuned(CAM, 5 * STEPS)))).torque is None
    undriven = replace(MuJoCoSettings.stock(SAW, 60), armature=0.0)
    assert [piece.drive_torque for piece in engine_named("mujoco").run(SAW, undriven, 0.1, 0.7, 4)] == [None] * 2


def test_a_torque_that_is_off_by_a_part_in_a_billion_is_seen(monkeypatch: pytest.MonkeyPatch) -> None:
    scene: Any = PRESS
    exact = ExactTorque(scene.kinematics, scene.speed, gravity=True)
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
