"""The torque that MuJoCo's drive gives, against the one that the exact motion takes."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from catalogue import PRESS, SAW, SCENES, VARIATIONS

from conrod import MuJoCoSettings
from conrod.engines import engine_named
from conrod.exact.dynamics.inverse import reactions

MUJOCO: Any = engine_named("mujoco")
START = 0.7


@pytest.mark.parametrize(
    ("scene", "bound"),
    [(PRESS, 5e-9), (SCENES["saw-500rpm"], 1e-8), (VARIATIONS["saw-reversed"], 1e-8)],
    ids=["press", "saw at 500 rpm", "saw reversed"],
)
def test_the_drive_torque_of_the_hardened_preset_is_the_exact_one(scene: Any, bound: float) -> None:
    pieces = list(MUJOCO.run(scene, MuJoCoSettings.hardened(scene, 1000), 1, START, 400))
    torque = np.concatenate([piece.drive_torque for piece in pieces])
    angle = np.concatenate([piece.trajectory.bodies.position.instants.angle for piece in pieces])
    exact = reactions(scene.kinematics, angle, scene.speed).drive_torque * scene.kinematics.mechanism.driver.sense
    error = np.abs(torque - exact) / np.abs(exact).max()
    # The solver's first guess in the first step is none: that one sample is worse by orders.
    assert error[1:].max() < bound
    assert error[0] < 1e-3
    assert np.abs(torque + exact).max() > np.abs(exact).max()


def test_without_a_drive_there_is_no_drive_torque() -> None:
    settings = replace(MuJoCoSettings.stock(SAW, 60), armature=0.0)
    assert [piece.drive_torque for piece in MUJOCO.run(SAW, settings, 0.1, START, 4)] == [None] * 2
