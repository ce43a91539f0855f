"""Runs in pieces: bit for bit the run in one, with its clock, its warnings, and what the iteration left."""

from __future__ import annotations

import tracemalloc
from collections.abc import Callable, Iterator
from dataclasses import fields, is_dataclass, replace
from functools import cache
from typing import Any

import mujoco
import numpy as np
import pytest
from catalogue import CAM, PRESS, SAW, VARIATIONS

from conrod import MuJoCoSettings, Outcome, PymunkSettings, Trajectory
from conrod.comparison.trajectory import Piece
from conrod.engines import engine_named
from conrod.engines.mujoco import compat
from conrod.engines.mujoco import dynamics as recorder
from conrod.engines.mujoco.dynamics import detect_engine_stop
from conrod.engines.mujoco.model import build
from conrod.engines.pymunk import dynamics, stepping
from conrod.engines.run import run_in_one_piece
from conrod.exact.motion import Array

MUJOCO, PYMUNK = engine_named("mujoco"), engine_named("pymunk")
STEPS, START = 60, 0.7
REVERSED = VARIATIONS["saw-reversed"]

STOCK, TUNED, HARDENED = MuJoCoSettings.stock, MuJoCoSettings.tuned, MuJoCoSettings.hardened
WILD = {"refsafe": False, "solref": (1e-3, 1.0)}
RUNS: dict[str, tuple[Any, Any]] = {
    "saw, stock": (SAW, STOCK(SAW, STEPS)),
    "press, tuned": (PRESS, TUNED(PRESS, STEPS)),
    "saw, hardened": (SAW, HARDENED(SAW, STEPS)),
    "cam, stock": (CAM, replace(STOCK(CAM, 20 * STEPS), cam_vertices=400)),
    "cam, tuned": (CAM, replace(TUNED(CAM, 20 * STEPS), cam_vertices=400)),
    "press, two iterations": (PRESS, replace(TUNED(PRESS, STEPS), solver="CG", iterations=2)),
    "saw, three of PGS": (SAW, replace(STOCK(SAW, STEPS), solver="PGS", iterations=3)),
    "press, rounded": (PRESS, replace(TUNED(PRESS, STEPS), rounded_state=True)),
    "saw, wild and rounded": (SAW, replace(TUNED(SAW, STEPS), rounded_state=True, **WILD)),
    "saw, gone wild": (SAW, replace(TUNED(SAW, STEPS), **WILD)),
    "saw, reset": (SAW, replace(TUNED(SAW, STEPS), autoreset=True, **WILD)),
}
WARNED = [name for name in RUNS if name.endswith(("wild", "reset"))]
IN_PYMUNK: dict[str, tuple[Any, Any]] = {
    "pymunk: saw, stock": (SAW, PymunkSettings.stock(SAW, STEPS)),
    "pymunk: press, tuned": (PRESS, PymunkSettings.tuned(PRESS, STEPS)),
    "pymunk: saw reversed": (REVERSED, PymunkSettings.tuned(REVERSED, STEPS)),
    "pymunk: saw, rounded": (SAW, replace(PymunkSettings.tuned(SAW, STEPS), rounded_state=True)),
    "pymunk: cam": (CAM, PymunkSettings.tuned(CAM, STEPS)),
}
RUNS |= IN_PYMUNK


def run_request(name: str) -> tuple[Any, Any, Any, float]:
    """Engine, scene, settings and revolutions; MuJoCo's cams take many steps, of which a part of a turn has enough."""
    turns = 2.5 if name in IN_PYMUNK else 0.06 if name.startswith("cam") else 1.2
    return (PYMUNK if name in IN_PYMUNK else MUJOCO, *RUNS[name], turns)


@cache
def whole_run(name: str) -> Trajectory:
    return run_in_one_piece(*run_request(name), START)


@cache
def in_pieces(name: str, steps: int) -> tuple[Piece, ...]:
    engine, scene, settings, turns = run_request(name)
    return tuple(engine.run(scene, settings, turns, START, steps))


def recorded_arrays(trajectory: Trajectory) -> dict[str, Array]:
    """Every number of a trajectory, by name."""
    found = {**dict(arrays("bodies", trajectory.bodies)), **dict(arrays("points", dict(trajectory.points)))}
    assert {"bodies.position.poses", "bodies.acceleration.instants.times"} <= found.keys()
    return found


def arrays(name: str, value: Any) -> Iterator[tuple[str, Array]]:
    if isinstance(value, np.ndarray):
        yield name, value
        return
    parts = {one.name: getattr(value, one.name) for one in fields(value)} if is_dataclass(value) else value
    for key, part in parts.items():
        yield from arrays(f"{name}.{key}", part)


def bits(values: Array) -> bytes:
    """To compare by; the sign of what is not a number means nothing, and depends on how many are added at a time."""
    return np.where(np.isnan(values), np.nan, values).tobytes()


def joined_arrays(name: str, steps: int) -> dict[str, Array]:
    """The same of a run in pieces."""
    parts = [recorded_arrays(piece.trajectory) for piece in in_pieces(name, steps)]
    return {key: np.concatenate([part[key] for part in parts]) for key in parts[0]}


def differing_names(one: dict[str, Array], other: dict[str, Array]) -> list[str]:
    return [key for key in other if one[key].shape != other[key].shape or bits(one[key]) != bits(other[key])]


# -- the same run ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("steps", [1, 7, 64])
@pytest.mark.parametrize("name", RUNS)
def test_joined_pieces_are_the_whole_run_bit_for_bit(name: str, steps: int) -> None:
    assert differing_names(joined_arrays(name, steps), recorded_arrays(whole_run(name))) == []


def test_a_changed_last_bit_is_detected() -> None:
    together = joined_arrays("pymunk: saw, stock", 7)
    values = together["bodies.position.poses"]
    values[40, 2] = np.nextafter(values[40, 2], 10.0)
    assert differing_names(together, recorded_arrays(whole_run("pymunk: saw, stock"))) == ["bodies.position.poses"]


def test_pieces_differ_without_the_solvers_warm_start(monkeypatch: pytest.MonkeyPatch) -> None:
    right = compat.rollout.rollout

    def forgetful(*arguments: Any, initial_warmstart: Array, **named: Any) -> Any:
        return right(*arguments, initial_warmstart=0.0 * initial_warmstart, **named)

    expected = recorded_arrays(whole_run("press, two iterations"))
    monkeypatch.setattr(compat.rollout, "rollout", forgetful)
    in_pieces.cache_clear()
    assert "bodies.position.poses" in differing_names(joined_arrays("press, two iterations", 7), expected)
    in_pieces.cache_clear()


@pytest.mark.parametrize("name", ["saw reversed", "saw, stock", "cam"])
def test_pymunks_public_stepping_gives_the_same_bits(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    assert stepping.memory_is_known()
    expected = recorded_arrays(whole_run(f"pymunk: {name}"))
    for offset in (stepping.STATE_OFFSET - 16, stepping.STATE_OFFSET + 8):
        monkeypatch.setattr(stepping, "STATE_OFFSET", offset)
        assert not stepping.memory_is_known()
    assert differing_names(recorded_arrays(run_in_one_piece(*run_request(f"pymunk: {name}"), START)), expected) == []


@pytest.mark.parametrize("name", ["saw, stock", "cam"])
def test_blocks_within_a_pymunk_piece_change_no_bit(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    expected = recorded_arrays(whole_run(f"pymunk: {name}"))
    monkeypatch.setattr(stepping, "BLOCK_STEPS", 7)
    monkeypatch.setattr(dynamics, "CHUNK_SAMPLES", 11)
    assert differing_names(recorded_arrays(run_in_one_piece(*run_request(f"pymunk: {name}"), START)), expected) == []


# -- time ------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("steps", [1, 7, 10_000])
@pytest.mark.parametrize("name", ["press, tuned", "pymunk: saw, stock"])
def test_times_are_step_counts_and_the_clock_is_a_sum(name: str, steps: int) -> None:
    _, scene, settings, turns = run_request(name)
    count, begun = round(STEPS * turns) + 1, START / scene.speed
    summed = [begun if name in IN_PYMUNK else 0.0]  # MuJoCo's clock begins with its run
    for _ in range(count - 1):
        summed.append(summed[-1] + settings.timestep)
    counted = begun + settings.timestep * np.arange(count)
    np.testing.assert_array_equal(joined_arrays(name, steps)["bodies.position.instants.times"], counted)
    assert np.concatenate([piece.clock for piece in in_pieces(name, steps)]).tolist() == summed
    assert np.any(counted - counted[0] != np.array(summed) - summed[0]), "steps whose sum is exact would prove nothing"


# -- memory ----------------------------------------------------------------------------------------------------------


def peak_memory(work: Callable[[], object]) -> int:
    """Largest number of bytes allocated at once while working."""
    work()  # what is computed once and kept is there
    tracemalloc.start()
    try:
        work()
        return tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()


@pytest.mark.parametrize("name", ["press, tuned", "pymunk: saw, stock"])
def test_memory_depends_on_the_piece_and_not_on_the_run(name: str) -> None:
    engine, scene, settings, _ = run_request(name)

    def streamed(revolutions: float, steps: int) -> int:
        return peak_memory(lambda: sum(len(p.clock) for p in engine.run(scene, settings, revolutions, 0.0, steps)))

    grown = streamed(60.0, 60 * STEPS) - streamed(6.0, 6 * STEPS)
    assert grown > 1_000_000, "a run of one piece grows, or nothing is measured"
    assert streamed(60.0, 200) - streamed(6.0, 200) < 0.05 * grown


# -- what MuJoCo did -------------------------------------------------------------------------------------------------


def first_warning(name: str) -> tuple[int, dict[str, int]]:
    """Steps up to the first warning, and the engine's counters then, by MuJoCo's plain step."""
    scene, settings = RUNS[name]
    made = build(scene, settings)
    data, steps = mujoco.MjData(made.model), 0
    data.qpos[:], data.qvel[:] = made.start_state(scene, START)
    with recorder.silence_warnings():
        while not data.warning.number.any():
            mujoco.mj_step(made.model, data)
            steps += 1
    numbers = data.warning.number
    return steps, {name: int(numbers[kind]) for name, kind in recorder.warning_kinds().items() if numbers[kind]}


@pytest.mark.parametrize("steps", [1, 7, 10_000])
@pytest.mark.parametrize("name", WARNED)
def test_warnings_are_counted_from_their_own_piece_on(name: str, steps: int) -> None:
    when, warned = first_warning(name)
    assert warned
    assert 1 < when < 60
    for piece in in_pieces(name, steps):
        # The step that leaves the last sample of a piece gives its sensors, and may warn.
        assert piece.warnings == (warned if piece.first_step + len(piece.clock) >= when else {})


@pytest.mark.parametrize("steps", [1, 2, 3, 7, 32])
def test_a_reset_is_detected_wherever_a_run_is_cut(steps: int) -> None:
    run = whole_run("saw, reset")
    assert run.outcome is Outcome.RESET
    when = int(run.reason.split()[-1])
    for piece in in_pieces("saw, reset", steps):
        told = piece.first_step + len(piece.clock) > when
        assert (piece.trajectory.outcome is Outcome.RESET) == told
        assert (piece.trajectory.reason == run.reason) == told


@pytest.mark.parametrize("steps", [1, 7, 32])
def test_a_run_without_reset_is_not_reported_as_reset(steps: int) -> None:
    pieces = in_pieces("saw, gone wild", steps)
    outcomes = [piece.trajectory.outcome for piece in pieces]
    assert Outcome.RESET not in outcomes
    assert outcomes[-1] not in (Outcome.COMPLETED, Outcome.RESET)


def test_a_clock_off_by_many_steps_is_no_reset_and_no_stop() -> None:
    settings = STOCK(SAW, STEPS)
    clock = settings.timestep * (np.arange(500, 600) + 3.0)
    assert detect_engine_stop(clock, 500, clock[0] - settings.timestep, {}, settings) is None
    stopped, reset = np.minimum(clock, clock[50]), np.where(clock > clock[50], clock - clock[50], clock)
    for changed, outcome in ((stopped, Outcome.DIVERGED), (reset, Outcome.RESET)):
        found = detect_engine_stop(changed, 500, clock[0] - settings.timestep, {}, settings)
        assert found is not None
        assert found.outcome is outcome
        assert "step 551" in found.reason


@pytest.mark.parametrize("name", ["saw, stock", "cam"])
def test_a_state_that_is_not_finite_is_an_outcome(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    engine, scene, settings, turns = run_request(f"pymunk: {name}")
    advance = stepping.advance

    def broken(*args: Any) -> tuple[Array, Array]:
        centres, rates = advance(*args)
        centres[-2:], rates[-1:] = np.inf, np.nan
        return centres, rates

    monkeypatch.setattr(dynamics, "advance", broken)
    piece = next(engine.run(scene, settings, turns, START, 20))
    assert piece.trajectory.outcome is Outcome.DIVERGED
    assert piece.trajectory.reason == f"not finite from {START / scene.speed + 19 * settings.timestep:.6g} s on"
