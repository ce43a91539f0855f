"""MuJoCo's free motion against the exact one."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import mujoco
import numpy as np
import pytest
from free_machines import chain

from conrod.engines.mujoco.engine import ENGINE
from conrod.engines.tracks import FreeRun, Pace
from conrod.exact.dynamics.forward import ForwardDynamics, FreeMotion
from conrod.mechanism.loads import Distance, Elastic, Friction, Load, SpeedLine, Steady, TimePulse, Turn, Viscous
from conrod.mechanism.mechanism import Mechanism

TIMES = np.linspace(0.0, 10.0, 101)
FIRST = 21  # samples of them where two seconds are enough
STEP = 0.005  # [s]; ten seconds then cost less than 0.1 s of CPU time
LENGTH = 1.0  # [m], of a link of the chains
PACE = Pace(0.92, crosses=True)  # of the chains
LOADS = (
    Load("spring", Distance("ground", "bar0", (0.0, -0.5), (0.3, 0.0)), Elastic(20.0, 0.7)),
    Load("damper", Distance("ground", "rocker1", (0.0, 0.6), (0.5, 0.1)), Viscous(0.4)),
    Load("turn-spring", Turn("rocker0", "bar0"), Elastic(3.0, 0.2)),
    Load("motor", Turn("ground", "rocker0"), SpeedLine(-2.0, -9.0)),
    Load("friction", Turn("ground", "rocker1"), Friction(0.5, 0.5)),
    Load("pulse", Turn("ground", "bar0"), TimePulse(3.0, 0.2, 1.7)),
    Load("push", Distance("ground", "rocker1", (-1.0, 0.0), (0.5, 0.0)), Steady(1.5)),
)


@cache
def exact(loads: int, count: int) -> FreeMotion:
    return ForwardDynamics(loaded(count, loads)).motion(TIMES[:FIRST] if loads else TIMES, {"rocker0": -1.0})


def loaded(count: int, loads: int) -> Mechanism:
    return replace(chain(count), loads=LOADS[:loads])


def swing(
    mechanism: Mechanism, motion: FreeMotion, preset: str = "hardened", step: float = STEP, pace: Pace = PACE
) -> FreeRun:
    start = motion.poses[0], motion.rates[0]
    steps = round(float(motion.times[-1]) / step)
    return ENGINE.free_run(mechanism, preset, step, steps, *start, pace, every=round(0.1 / step))


def error(run: FreeRun, motion: FreeMotion) -> float:
    """Largest distance [m] or turn [rad] from the exact motion."""
    assert run.outcome.slug == "completed", run.reason
    np.testing.assert_allclose(run.times, motion.times, atol=1e-12)
    return float(np.abs(run.poses - motion.poses).max())


def test_stock_leaves_the_branch_at_change_points_and_tuned_converges() -> None:
    motion = exact(0, 2)
    assert not np.abs(swing(chain(2), motion, "stock").poses - motion.poses).max() < 0.1
    errors = [error(swing(chain(2), motion, "tuned", step), motion) for step in (0.01, 0.005, 0.0025)]
    assert errors[1] < 0.1
    assert errors[0] > 3.0 * errors[1] > 30.0 * errors[2]


def test_hardened_stays_within_a_millionth_at_change_points_whatever_the_step() -> None:
    motion = exact(0, 2)
    for step in (0.01, 0.005, 0.00125):
        assert error(swing(chain(2), motion, step=step), motion) < 3e-6


def test_damping_of_the_driven_rule_loses_the_branch_at_change_points(monkeypatch: pytest.MonkeyPatch) -> None:
    """The negative control: time constant of eight steps, damped critically, as for a machine with a drive."""
    monkeypatch.setattr("conrod.engines.mujoco.free_run.TUNED_STEPS", 8.0)
    monkeypatch.setattr("conrod.engines.mujoco.free_run.TUNED_DAMPING", 1.0)
    motion = exact(0, 2)
    assert np.abs(swing(chain(2), motion, "tuned").poses - motion.poses).max() > 1.0


def test_a_pendulum_is_of_order_four_at_least() -> None:
    """Without a loop nothing but RK4 itself is left; it was found to be 4.8."""
    pendulum = replace(chain(1), bodies=chain(1).bodies[:1], joints=chain(1).joints[:1])
    pendulum = replace(pendulum, poses={"rocker0": (0.0, 0.0, 0.5 * np.pi)}, name="pendulum")
    motion = ForwardDynamics(pendulum).motion(TIMES[:FIRST], {"rocker0": -1.0})
    errors = [error(swing(pendulum, motion, step=step), motion) for step in (0.02, 0.01, 0.005)]
    orders = np.log2(np.divide(errors[:-1], errors[1:]))
    assert np.all(orders > 3.5), orders


def test_loads_act_at_every_stage() -> None:
    """An error of first order in the step, as a law held over it would have, would be a hundred times the bound."""
    mechanism, motion = loaded(1, len(LOADS)), exact(len(LOADS), 1)
    free = exact(0, 1)
    assert np.abs(motion.poses - free.poses[:FIRST]).max() > 0.1
    assert error(swing(mechanism, motion), motion) < 1e-5
    assert mujoco.get_mjcb_act_bias() is None
