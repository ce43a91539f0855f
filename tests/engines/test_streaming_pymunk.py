"""pymunk in pieces: bit for bit the run in one, a clock as a user keeps it, and what the iteration left."""

from __future__ import annotations

import tracemalloc
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from catalogue import CAM, PRESS, SAW, VARIATIONS

from conrod import Outcome, PymunkSettings, Trajectory
from conrod.engines import engine_named
from conrod.engines.massless_rod import DISTANCE_JOINT
from conrod.engines.pymunk import dynamics, stepping
from conrod.engines.running import whole_run
from conrod.exact.motion import Array
from conrod.runs.trajectory import BodyStates, Instants, Piece

PYMUNK: Any = engine_named("pymunk")
STEPS, REVOLUTIONS = 60, 2.5
START = 0.7

RUNS: dict[str, tuple[Any, Any]] = {
    "saw, stock": (SAW, PymunkSettings.stock(SAW, STEPS)),
    "press, tuned": (PRESS, PymunkSettings.tuned(PRESS, STEPS)),
    "press, rod left out": (PRESS, replace(PymunkSettings.tuned(PRESS, STEPS), rod=DISTANCE_JOINT)),
    "saw reversed, rod left out": (
        VARIATIONS["saw-reversed"],
        replace(PymunkSettings.tuned(VARIATIONS["saw-reversed"], STEPS), rod=DISTANCE_JOINT),
    ),
    "saw, rounded": (SAW, replace(PymunkSettings.tuned(SAW, STEPS), rounded_state=True)),
    "cam": (CAM, PymunkSettings.tuned(CAM, STEPS)),
}


@cache
def whole(name: str) -> Trajectory:
    scene, settings = RUNS[name]
    run: Trajectory = whole_run(PYMUNK, scene, settings, REVOLUTIONS, START)
    return run


@cache
def in_pieces(name: str, steps: int) -> tuple[Piece, ...]:
    scene, settings = RUNS[name]
    return tuple(PYMUNK.run(scene, settings, REVOLUTIONS, START, steps))


def recorded(trajectory: Trajectory) -> Iterator[tuple[str, Array]]:
    """Every number of a trajectory, by name."""
    bodies = trajectory.bodies
    assert bodies is not None
    for kind in ("position", "velocity", "acceleration"):
        states: BodyStates = getattr(bodies, kind)
        yield from instants_of(f"bodies {kind}", states.instants)
        yield f"{kind} poses", states.poses
        yield f"{kind} rates", states.rates
        yield f"{kind} accelerations", states.accelerations
        for name, tracks in trajectory.points.items():
            track = getattr(tracks, kind)
            yield from instants_of(f"{name} {kind}", track.instants)
            yield f"{name} {kind}", track.values


def instants_of(name: str, instants: Instants) -> Iterator[tuple[str, Array]]:
    for kind in ("times", "angle", "rate", "acceleration"):
        yield f"{name} {kind}", getattr(instants, kind)


@pytest.mark.parametrize("steps", [1, 7, 64])
@pytest.mark.parametrize("name", RUNS)
def test_pieces_put_together_are_the_run_bit_for_bit(name: str, steps: int) -> None:
    parts = [dict(recorded(piece.trajectory)) for piece in in_pieces(name, steps)]
    for key, values in recorded(whole(name)):
        together = np.concatenate([part[key] for part in parts])
        assert together.shape == values.shape, key
        assert together.tobytes() == values.tobytes(), key


def test_a_last_bit_in_one_sample_is_seen() -> None:
    values = np.concatenate([dict(recorded(p.trajectory))["position poses"] for p in in_pieces("saw, stock", 7)])
    values[40, 2] = np.nextafter(values[40, 2], 10.0)
    assert values.tobytes() != dict(recorded(whole("saw, stock")))["position poses"].tobytes()


def test_a_piece_has_so_many_new_samples_and_the_first_one_the_start() -> None:
    pieces = in_pieces("saw, stock", 64)
    assert [piece.first_step for piece in pieces] == [0, 65, 129]
    lengths = [len(dict(recorded(piece.trajectory))["position poses"]) for piece in pieces]
    assert lengths == [65, 64, 22]
    assert sum(lengths) == STEPS * REVOLUTIONS + 1


@pytest.mark.parametrize("name", ["press, rod left out", "saw, rounded", "saw, stock"])
def test_the_public_way_of_stepping_gives_the_same_bits(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    scene, settings = RUNS[name]
    monkeypatch.setattr(stepping, "memory_is_known", lambda: False)
    public = dict(recorded(whole_run(PYMUNK, scene, settings, REVOLUTIONS, START)))
    for key, values in recorded(whole(name)):
        assert public[key].tobytes() == values.tobytes(), key


@pytest.mark.parametrize("steps", [1, 7, 10_000])
def test_the_clock_is_the_sum_that_a_loop_over_the_steps_keeps(steps: int) -> None:
    scene, settings = RUNS["saw, stock"]
    time, loop = START / scene.speed, [START / scene.speed]
    for _ in range(round(STEPS * REVOLUTIONS)):
        time += settings.timestep
        loop.append(time)
    clock = np.concatenate([piece.clock for piece in in_pieces("saw, stock", steps)])
    assert clock.tolist() == loop
    counted = dict(recorded(whole("saw, stock")))["bodies position times"]
    assert np.any(clock != counted), "steps whose sum is exact would prove nothing"
    np.testing.assert_allclose(clock, counted, rtol=1e-12)


def peak_memory(work: Callable[[], object]) -> int:
    """Largest number of bytes allocated at once while working."""
    work()  # what is computed once and kept is there
    tracemalloc.start()
    try:
        work()
        return tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()


def test_memory_is_bounded_by_the_piece_and_not_by_the_run() -> None:
    scene, settings = RUNS["saw, stock"]

    def streamed(revolutions: float) -> int:
        return peak_memory(lambda: sum(len(p.clock) for p in PYMUNK.run(scene, settings, revolutions, 0.0, 300)))

    grown = peak_memory(lambda: whole_run(PYMUNK, scene, settings, 80.0)) - peak_memory(
        lambda: whole_run(PYMUNK, scene, settings, 20.0)
    )
    assert grown > 1_000_000, "a run of one piece grows, or nothing is measured"
    assert streamed(80.0) - streamed(20.0) < 0.05 * grown


# -- what the iteration left -----------------------------------------------------------------------------------------


def largest_left(scene: Any, **changes: Any) -> float:
    settings = replace(PymunkSettings.tuned(scene, 200), **changes)
    found = [piece.solver for piece in PYMUNK.run(scene, settings, 1.0, 0.0, 10)]
    assert len(found) == 20
    assert all(state.iterations == settings.iterations for state in found)
    return max(state.residual for state in found) / (abs(scene.speed) * max(scene.lengths.values()))


@pytest.mark.parametrize("form", [{}, {"rod": DISTANCE_JOINT}])
@pytest.mark.parametrize("bias", [0.0, PymunkSettings.stock(SAW, 200).error_bias])
@pytest.mark.parametrize("scene", [SAW, PRESS], ids=["saw", "press"])
def test_a_converged_iteration_leaves_rounding_and_a_short_one_does_not(
    scene: Any, bias: float, form: dict[str, str]
) -> None:
    assert largest_left(scene, error_bias=bias, iterations=1000, **form) < 1e-12
    assert largest_left(scene, error_bias=bias, iterations=2, **form) > 1e-8


def test_a_bias_other_than_the_engine_has_would_be_seen(monkeypatch: pytest.MonkeyPatch) -> None:
    told = dynamics.gap_rate_left
    monkeypatch.setattr(
        dynamics, "gap_rate_left", lambda form, settings, *at: told(form, replace(settings, error_bias=0.5), *at)
    )
    assert largest_left(SAW, iterations=1000) > 1e-6


@pytest.mark.parametrize("name", ["saw, stock", "press, rod left out", "cam"])
def test_a_state_that_is_not_finite_is_an_outcome_and_no_warning(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    scene, settings = RUNS[name]
    advance = stepping.advance

    def broken(*args: Any) -> tuple[Array, Array]:
        centres, rates = advance(*args)
        centres[-2:], rates[-1:] = np.inf, np.nan
        return centres, rates

    monkeypatch.setattr(dynamics, "advance", broken)
    piece = next(PYMUNK.run(scene, settings, REVOLUTIONS, START, 20))
    assert piece.trajectory.outcome is Outcome.DIVERGED
    assert piece.trajectory.reason == f"not finite from {START / scene.speed + 19 * settings.timestep:.6g} s on"


# -- rounded state ---------------------------------------------------------------------------------------------------


def test_a_rounded_state_has_single_precision_and_costs_accuracy() -> None:
    rounded = dict(recorded(whole("saw, rounded")))
    crank = rounded["position poses"][1:, 2]
    assert np.array_equal(crank, crank.astype(np.float32))
    assert whole_run(PYMUNK, SAW, RUNS["saw, rounded"][1], REVOLUTIONS, START).outcome is Outcome.COMPLETED
    exact = dict(
        recorded(whole_run(PYMUNK, SAW, replace(RUNS["saw, rounded"][1], rounded_state=False), REVOLUTIONS, START))
    )
    off = np.abs(rounded["C position"] - exact["C position"]).max() / SAW.lengths["C"]
    assert 1e-8 < off < 1e-4
    assert not np.array_equal(crank, exact["position poses"][1:, 2])
