"""The benchmarks compare like with like: the same steps, the same states, and every step recorded. No clock here."""

from __future__ import annotations

import sys
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from benchmarks import ledger_cost, mujoco_recording, pymunk_recording
from benchmarks.process_cost import cost_of_process
from benchmarks.side_by_side import against, interleaved
from conrod.engines.mujoco import dynamics
from conrod.engines.mujoco.model import build
from conrod.engines.pymunk.stepping import advance
from conrod.execution.ledger import Ledger
from conrod.execution.run import RunResult

STEPS = 300


@pytest.mark.parametrize("integrator", mujoco_recording.INTEGRATORS)
def test_mujocos_two_sides_take_the_same_steps_to_the_same_bits(integrator: str) -> None:
    chosen = mujoco_recording.settings(integrator)
    made = build(mujoco_recording.SAW, chosen)
    _, states, sensors = dynamics.simulate(made, mujoco_recording.SAW, chosen, STEPS, 0.0)
    data = mujoco_recording.started(made)
    for k in (0, 1, STEPS // 2, STEPS):
        data = mujoco_recording.started(made)
        mujoco_recording.stepped(made, data, k)
        assert data.time == states[k, 0]
        np.testing.assert_array_equal(np.concatenate([data.qpos, data.qvel]), states[k, 1 : 1 + made.model.nq * 2])
    # One step more, which the timed base takes too: the sensors of the last sample.
    mujoco_recording.stepped(made, data, 1)
    np.testing.assert_array_equal(data.sensordata, sensors[STEPS])


def test_pymunk_recording_and_driven_loop_end_in_the_same_bits() -> None:
    made = pymunk_recording.started()
    pymunk_recording.driven(made, STEPS)
    turns = pymunk_recording.crank_angles(pymunk_recording.SAW, pymunk_recording.times_of(STEPS))
    centres, rates = advance(pymunk_recording.started(), pymunk_recording.SETTINGS.timestep, turns[:-1])
    for i, body in enumerate(made.bodies):
        assert (*body.position, body.angle) == tuple(centres[-1, 3 * i : 3 * i + 3])
        assert (*body.velocity, body.angular_velocity) == tuple(rates[-1, 3 * i : 3 * i + 3])


def test_pymunk_bare_loop_takes_all_steps_up_to_rounding() -> None:
    bare, driven = pymunk_recording.started(), pymunk_recording.started()
    pymunk_recording.stepped(bare, STEPS)
    pymunk_recording.driven(driven, STEPS)
    for first, second in zip(bare.bodies, driven.bodies, strict=True):
        np.testing.assert_allclose(first.position, second.position, atol=1e-12)
    # Negative control: one step fewer is seen.
    fewer = pymunk_recording.started()
    pymunk_recording.stepped(fewer, STEPS - 1)
    step = pymunk_recording.SAW.speed * pymunk_recording.SETTINGS.timestep
    assert bare.crank.angle - fewer.crank.angle == pytest.approx(step)


def test_a_resume_is_timed_only_where_no_run_was_lost(tmp_path: Path) -> None:
    cells, path = ledger_cost.some_cells(20), tmp_path / "ledger.sqlite"
    assert len({cell.key for cell in cells}) == 20
    with Ledger.open(path) as ledger:
        for cell in cells[1:]:
            ledger.keep(cell, RunResult("completed"))
    assert ledger_cost.resume(path, cells[1:], read=True) == 19
    with pytest.raises(AssertionError, match="1 runs were lost"):
        ledger_cost.resume(path, cells)


def test_cost_of_a_command_is_refused_where_it_fails() -> None:
    command = [sys.executable, "-S", "-c", "raise SystemExit(1)"]
    assert cost_of_process(command, statuses=(0, 1)).wall > 0.0
    with pytest.raises(AssertionError, match="ended with status 1"):
        cost_of_process(command)


def test_repeats_are_interleaved_and_the_first_does_not_count() -> None:
    calls: list[str] = []

    def side(name: str) -> float:
        calls.append(name)
        return 2.0 * len(calls)

    seconds = interleaved({name: partial(side, name) for name in ("bare", "recorded")}, 2)
    assert calls == ["bare", "recorded"] * 3
    assert seconds == {"bare": [6.0, 10.0], "recorded": [8.0, 12.0]}
    (row,) = against(seconds, "bare", {"recorded": 1.25}, "engine")
    assert row.repeats == [8.0 / 6.0, 12.0 / 10.0]
    assert row.reached is False  # the median, 1.267, counts and not the best
