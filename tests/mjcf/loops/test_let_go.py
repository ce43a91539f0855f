"""A machine on a floating base that is let go keeps its momentum, spin and energy, as far as its closures do."""

from __future__ import annotations

from dataclasses import replace

import mujoco
import numpy as np
import pytest
from four_bars import FRAME, four_bar

from conrod.mjcf.loops.results import OWN, FreeRun, Question
from conrod.mjcf.loops.runs import with_settings
from conrod.mjcf.loops.study import _Bench
from conrod.mjcf.loops.undriven import free_run
from conrod.runs.trajectory import Outcome

STEP, SECONDS = 1e-3, 0.1


def floating(joint: str = "", more: str = "") -> mujoco.MjModel:
    text = four_bar(joint=joint, option='gravity="1 2 -9.81"', more=more).replace(
        f'<body name="frame" {FRAME}>',
        f'<body name="frame" {FRAME}><freejoint name="base"/><geom size="0.1" mass="2"/>',
    )
    return mujoco.MjModel.from_xml_string(text)


def let_go(label: str, model: mujoco.MjModel, gravity: tuple[float, ...] | None = None) -> FreeRun:
    bench = _Bench.of(model, Question({"crank": "60rpm"}, seconds=SECONDS))
    assert bench.machine.held == ("base",)
    tree = bench.machine.tree if gravity is None else replace(bench.machine.tree, gravity=np.array(gravity))
    motion = bench.machine.motion(np.zeros(1))
    return free_run(label, tree, with_settings(model, label, STEP, 1.0, True), motion, SECONDS)


def test_tuned_keeps_momentum_spin_and_energy_and_its_loop_closed() -> None:
    run = let_go("tuned", floating())
    assert run.outcome is Outcome.COMPLETED
    assert run.energy is not None
    assert max(run.momentum, run.spin, run.energy) < 1e-7
    assert run.gap < 1e-7
    # Negative controls: another weight than it has; and closures as they come.
    assert let_go("tuned", floating(), (1.0, 2.0, -9.8)).momentum > 1e-4
    assert let_go(OWN, floating()).gap > 1e2 * run.gap


def test_hardened_keeps_its_loop_closed_but_not_its_spin() -> None:
    # The harder its pin, whose force across the plane is redundant, the more it drifts.
    tuned, hardened = (let_go(label, floating()) for label in ("tuned", "hardened"))
    assert hardened.gap < 1e-2 * tuned.gap
    assert hardened.momentum < 1e-7
    assert hardened.spin > 1e3 * tuned.spin


def test_where_a_damper_takes_energy_none_is_said_to_drift() -> None:
    damped = let_go("tuned", floating(joint='damping="0.5"'))
    assert damped.energy is None
    assert max(damped.momentum, damped.spin) < 1e-6


def test_controls_do_not_act() -> None:
    thrown = let_go("tuned", floating(more='<actuator><position joint="rocker" kp="900"/></actuator>'))
    free = let_go("tuned", floating())
    assert (thrown.momentum, thrown.spin, thrown.energy) == pytest.approx((free.momentum, free.spin, free.energy))


def test_a_state_that_is_no_number_is_an_outcome() -> None:
    stiff = let_go(OWN, floating(joint='stiffness="1e14"'))
    assert stiff.outcome is Outcome.DIVERGED
    assert stiff.reason.startswith("not finite")
