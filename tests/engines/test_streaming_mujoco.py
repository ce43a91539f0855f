"""MuJoCo in pieces: bit for bit the run in one, with its clock and its warnings."""

from __future__ import annotations

import tracemalloc
from collections.abc import Iterator
from dataclasses import replace
from functools import cache
from typing import Any

import mujoco
import numpy as np
import pytest
from catalogue import CAM, PRESS, SAW, VARIATIONS

from conrod import MuJoCoSettings, Outcome, Trajectory
from conrod.engines import engine_named
from conrod.engines.massless_rod import DISTANCE_JOINT
from conrod.engines.mujoco import recorder
from conrod.engines.mujoco.model import build
from conrod.engines.mujoco.recorder import ended_by_engine
from conrod.engines.running import whole_run
from conrod.exact.motion import Array
from conrod.runs.trajectory import Piece

MUJOCO: Any = engine_named("mujoco")
STEPS, REVOLUTIONS, START = 60, 1.2, 0.7
REVERSED = VARIATIONS["saw-reversed"]

STOCK, TUNED, HARDENED = MuJoCoSettings.stock, MuJoCoSettings.tuned, MuJoCoSettings.hardened
RUNS: dict[str, tuple[Any, Any]] = {
    "saw, stock": (SAW, STOCK(SAW, STEPS)),
    "press, tuned": (PRESS, TUNED(PRESS, STEPS)),
    "saw, hardened": (SAW, HARDENED(SAW, STEPS)),
    "cam, stock": (CAM, replace(STOCK(CAM, 20 * STEPS), cam_vertices=400)),
    "cam, tuned": (CAM, replace(TUNED(CAM, 20 * STEPS), cam_vertices=400)),
    "press, two iterations": (PRESS, replace(TUNED(PRESS, STEPS), solver="CG", iterations=2)),
    "saw, three of PGS": (SAW, replace(STOCK(SAW, STEPS), solver="PGS", iterations=3)),
    "saw reversed, rod left out": (REVERSED, replace(TUNED(REVERSED, STEPS), rod=DISTANCE_JOINT)),
    "press, rounded": (PRESS, replace(TUNED(PRESS, STEPS), rounded_state=True)),
    "saw, gone wild": (SAW, replace(TUNED(SAW, STEPS), refsafe=False, solref=(1e-3, 1.0))),
    "saw, reset": (SAW, replace(TUNED(SAW, STEPS), refsafe=False, solref=(1e-3, 1.0), autoreset=True)),
    "saw, rounded, gone wild": (
        SAW,
        replace(TUNED(SAW, STEPS), refsafe=False, solref=(1e-3, 1.0), rounded_state=True),
    ),
}
WILD = [name for name in RUNS if name.endswith(("wild", "reset"))]


def turns(name: str) -> float:
    """A cam takes many steps: a part of a turn has enough of them."""
    return 0.06 if name.startswith("cam") else REVOLUTIONS


@cache
def whole(name: str) -> Trajectory:
    scene, settings = RUNS[name]
    run: Trajectory = whole_run(MUJOCO, scene, settings, turns(name), START)
    return run


@cache
def in_pieces(name: str, steps: int) -> tuple[Piece, ...]:
    scene, settings = RUNS[name]
    return tuple(MUJOCO.run(scene, settings, turns(name), START, steps))


def recorded(trajectory: Trajectory) -> Iterator[tuple[str, Array]]:
    """Every number of a trajectory, by name."""
    assert trajectory.bodies is not None
    states = trajectory.bodies.position
    for kind in ("times", "angle", "rate", "acceleration"):
        yield kind, getattr(states.instants, kind)
    for kind in ("poses", "rates", "accelerations"):
        yield f"bodies' {kind}", getattr(states, kind)
    for name, tracks in trajectory.points.items():
        for kind in ("position", "velocity", "acceleration"):
            yield f"{name} {kind}", getattr(tracks, kind).values


def bits(values: Array) -> bytes:
    """To compare by; the sign of what is not a number means nothing, and depends on how many are added at a time."""
    return np.where(np.isnan(values), np.nan, values).tobytes()


def joined(name: str, steps: int) -> dict[str, Array]:
    """The same of a run in pieces."""
    parts = [dict(recorded(piece.trajectory)) for piece in in_pieces(name, steps)]
    return {key: np.concatenate([part[key] for part in parts]) for key in parts[0]}


# -- the same run ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("steps", [1, 32])
@pytest.mark.parametrize("name", RUNS)
def test_pieces_put_together_are_the_run_bit_for_bit(name: str, steps: int) -> None:
    together = joined(name, steps)
    for key, values in recorded(whole(name)):
        assert together[key].shape == values.shape, key
        assert bits(together[key]) == bits(values), key


def test_without_the_solvers_first_guess_they_would_not_be(monkeypatch: pytest.MonkeyPatch) -> None:
    right = recorder.rollout.rollout

    def forgetful(*arguments: Any, initial_warmstart: Array, **named: Any) -> Any:
        return right(*arguments, initial_warmstart=0.0 * initial_warmstart, **named)

    expected = dict(recorded(whole("press, two iterations")))["bodies' poses"]
    monkeypatch.setattr(recorder.rollout, "rollout", forgetful)
    in_pieces.cache_clear()
    assert joined("press, two iterations", 7)["bodies' poses"].tobytes() != expected.tobytes()
    in_pieces.cache_clear()


def test_memory_does_not_grow_with_the_revolutions() -> None:
    scene, settings = RUNS["press, tuned"]

    def peak(revolutions: int, steps: int) -> int:
        tracemalloc.start()
        for _ in MUJOCO.run(scene, settings, revolutions, 0.0, steps):
            pass
        found = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        return found

    peak(1, 200)  # what is made once
    assert peak(60, 200) < 1.2 * peak(6, 200)
    assert peak(60, 60 * STEPS) > 5.0 * peak(6, 6 * STEPS)


# -- time ------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("steps", [7, 10_000])
def test_times_come_from_the_step_index_and_the_clock_is_a_sum_of_steps(steps: int) -> None:
    scene, settings = RUNS["press, tuned"]
    pieces = in_pieces("press, tuned", steps)
    count = round(STEPS * REVOLUTIONS) + 1
    counted = START / scene.speed + settings.timestep * np.arange(count)
    summed = [0.0]
    for _ in range(count - 1):
        summed.append(summed[-1] + settings.timestep)
    np.testing.assert_array_equal(joined("press, tuned", steps)["times"], counted)
    np.testing.assert_array_equal(np.concatenate([piece.clock for piece in pieces]), summed)
    assert np.any(counted != START / scene.speed + np.array(summed))


# -- what the engine did ---------------------------------------------------------------------------------------------


def stepped_until_warned(name: str) -> tuple[int, dict[str, int]]:
    """Steps up to the first warning, and the engine's counters then, by MuJoCo's plain step."""
    scene, settings = RUNS[name]
    made = build(scene, settings)
    data, steps = mujoco.MjData(made.model), 0
    data.qpos[:], data.qvel[:] = made.start_state(scene, START)
    with recorder.warnings_kept_quiet():
        while not data.warning.number.any():
            mujoco.mj_step(made.model, data)
            if settings.rounded_state:
                recorder.round_state(data)
            steps += 1
    numbers = data.warning.number
    return steps, {name: int(numbers[kind]) for name, kind in recorder.WARNINGS.items() if numbers[kind]}


@pytest.mark.parametrize("steps", [1, 7, 10_000])
@pytest.mark.parametrize("name", WILD)
def test_warnings_are_counted_from_the_piece_on_in_which_they_came(name: str, steps: int) -> None:
    when, warned = stepped_until_warned(name)
    assert warned
    assert 1 < when < 60
    for piece in in_pieces(name, steps):
        # The step that leaves the last sample of a piece gives its sensors, and may warn.
        assert piece.warnings == (warned if piece.first_step + len(piece.clock) >= when else {})


@pytest.mark.parametrize("steps", [1, 2, 3, 7, 32])
def test_the_engines_own_reset_is_recognised_wherever_a_run_is_cut(steps: int) -> None:
    run = whole("saw, reset")
    assert run.outcome is Outcome.RESET
    when = int(run.reason.split()[-1])
    for piece in in_pieces("saw, reset", steps):
        told = piece.first_step + len(piece.clock) > when
        assert (piece.trajectory.outcome is Outcome.RESET) == told
        assert (piece.trajectory.reason == run.reason) == told


@pytest.mark.parametrize("steps", [1, 7, 32])
def test_a_run_whose_state_is_not_put_back_is_not_said_to_be(steps: int) -> None:
    pieces = in_pieces("saw, gone wild", steps)
    outcomes = [piece.trajectory.outcome for piece in pieces]
    assert Outcome.RESET not in outcomes
    assert outcomes[-1] not in (Outcome.COMPLETED, Outcome.RESET)


def test_a_clock_that_is_many_steps_off_but_goes_on_is_neither_reset_nor_stopped() -> None:
    settings = STOCK(SAW, STEPS)
    clock = settings.timestep * (np.arange(500, 600) + 3.0)
    assert ended_by_engine(clock, 500, clock[0] - settings.timestep, {}, settings) is None
    stopped, reset = np.minimum(clock, clock[50]), np.where(clock > clock[50], clock - clock[50], clock)
    for changed, outcome in ((stopped, Outcome.DIVERGED), (reset, Outcome.RESET)):
        found = ended_by_engine(changed, 500, clock[0] - settings.timestep, {}, settings)
        assert found is not None
        assert found.outcome is outcome
        assert "step 551" in found.reason
