"""A run that kills its process, hangs or eats all memory is an outcome."""

from __future__ import annotations

import dataclasses
import os
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pymunk
import pytest

from conrod import InvalidInput, Outcome, PymunkSettings, Saw, Trajectory, run
from conrod.mechanism.mechanism import Body
from conrod.studies.execution.isolation import Ended, isolated

SAW = Saw()
SETTINGS = PymunkSettings.tuned(SAW, 100)
BEYOND = "the limit was {} bytes more than it began with"


def engine_abort() -> None:
    """What pymunk does on a negative mass: a C assertion that takes the interpreter down."""
    pymunk.Space().add(pymunk.Body(-1.0, 1.0))


def exhaust() -> None:
    """Piece by piece, let go when the last one fails; not touched, to leave others their memory."""
    hoard = []
    while True:
        hoard.append(np.empty(50_000_000, dtype=np.uint8))


def exhaust_and_keep() -> None:
    """To the last kilobyte, held by what outlives the call."""
    hold_all(HELD)


HELD: list[Any] = []


def hold_all(held: list[Any]) -> None:
    size = 1 << 30
    while True:
        try:
            held.append(np.empty(size, dtype=np.uint8))
        except MemoryError:
            if size < 1024:
                raise
            size //= 2


def mistake() -> None:
    raise ZeroDivisionError("a mistake in the task")


def leave() -> None:
    os._exit(3)


def leave_as_python_does() -> None:
    raise SystemExit(3)


def hang() -> None:
    time.sleep(1000.0)


def test_an_isolated_run_is_the_run_itself() -> None:
    alone, here = isolated(run, SAW, SETTINGS, 1.0, timeout=60.0), run(SAW, SETTINGS, 1.0)
    assert isinstance(alone, Trajectory)
    assert alone.outcome is Outcome.COMPLETED
    assert (alone.points["C"].position.values == here.points["C"].position.values).all()


@pytest.mark.parametrize(
    ("task", "limits", "outcome", "reason"),
    [
        (engine_abort, {}, Outcome.CRASHED, "ended by signal SIGABRT"),
        (leave, {}, Outcome.CRASHED, "ended with status 3"),
        (leave_as_python_does, {}, Outcome.CRASHED, "ended with status 3"),
        (hang, {"timeout": 1.0}, Outcome.TIMED_OUT, "no result after 1 s"),
        pytest.param(
            *(exhaust, {"headroom": 3_000_000_000}, Outcome.OUT_OF_MEMORY, BEYOND.format(3_000_000_000)),
            marks=pytest.mark.slow,
        ),
        (exhaust_and_keep, {"headroom": 3_000_000_000}, Outcome.OUT_OF_MEMORY, BEYOND.format(3_000_000_000)),
    ],
)
def test_a_fault_ends_as_its_outcome(
    task: Callable[[], None], limits: dict[str, Any], outcome: Outcome, reason: str
) -> None:
    assert isolated(task, **limits) == Ended(outcome, reason)


def test_memory_is_limited_from_what_the_process_begins_with() -> None:
    assert isolated(take, 10_000_000, headroom=100_000_000) == 10_000_000
    assert isolated(take, 200_000_000, headroom=100_000_000) == Ended(Outcome.OUT_OF_MEMORY, BEYOND.format(100_000_000))


def take(size: int) -> int:
    return len(bytearray(size))


def test_a_mistake_in_a_task_is_raised_with_its_traceback() -> None:
    with pytest.raises(ZeroDivisionError, match="a mistake") as raised:
        isolated(mistake)
    assert Path(__file__).name in raised.value.__notes__[0]


class Unportable(Exception):
    """It cannot be made again from what a pickle keeps of it."""

    def __init__(self, one: str, other: str) -> None:
        super().__init__(f"{one} {other}")


def mistake_that_cannot_travel() -> None:
    raise Unportable("a mistake", "in the task")


def result_that_cannot_travel() -> Any:
    return lambda: None


def test_a_mistake_that_cannot_be_sent_is_no_crash() -> None:
    with pytest.raises(RuntimeError, match="Unportable: a mistake in the task"):
        isolated(mistake_that_cannot_travel)
    with pytest.raises(Exception, match="lambda"):
        isolated(result_that_cannot_travel)


def test_bad_usage_is_no_outcome_in_isolation_either() -> None:
    with pytest.raises(InvalidInput, match="timestep"):
        isolated(run, SAW.with_parameters(speed=1.0), SETTINGS, 1.0)


@pytest.mark.parametrize("change", [{"iterations": 0}, {"error_bias": -0.1}, {"collision_bias": float("nan")}])
def test_settings_that_abort_pymunk_are_refused(change: dict[str, float]) -> None:
    with pytest.raises(InvalidInput, match=next(iter(change))):
        dataclasses.replace(SETTINGS, **change)


@pytest.mark.parametrize("mass", [0.0, -1.0, float("inf"), float("nan")])
def test_masses_that_are_no_masses_are_refused(mass: float) -> None:
    with pytest.raises(InvalidInput, match="mass of rod"):
        Body("rod", mass, 1.0)
