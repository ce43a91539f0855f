"""A run that kills its process, hangs or eats all memory is an outcome."""

from __future__ import annotations

import dataclasses
import os
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import pymunk
import pytest

from conrod import InvalidInput, Outcome, PymunkSettings, Saw, Trajectory, compare, run
from conrod.engines.engine import Machine
from conrod.mechanism.mechanism import Body
from conrod.runs.trajectory import Settings
from conrod.studies.execution.isolation import Ended, isolated, run_isolated

SAW = Saw()
SETTINGS = PymunkSettings.tuned(SAW, 100)


def engine_abort(machine: Machine, settings: Settings, revolutions: float) -> Trajectory:
    """What pymunk does on a negative mass: a C assertion that takes the interpreter down."""
    pymunk.Space().add(pymunk.Body(-1.0, 1.0))
    return run(machine, settings, revolutions)


def hang(machine: Machine, settings: Settings, revolutions: float) -> Trajectory:
    time.sleep(1000.0)
    return run(machine, settings, revolutions)


def exhaust(machine: Machine, settings: Settings, revolutions: float) -> Trajectory:
    """Piece by piece, let go when the last one fails; not touched, to leave others their memory."""
    hoard = []
    while True:
        hoard.append(np.empty(50_000_000, dtype=np.uint8))


def exhaust_and_keep(machine: Machine, settings: Settings, revolutions: float) -> Trajectory:
    """To the last kilobyte, held by what outlives the call."""
    hold_all(HELD)
    return run(machine, settings, revolutions)


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


def mistake(machine: Machine, settings: Settings, revolutions: float) -> Trajectory:
    raise ZeroDivisionError("a mistake in the task")


def leave(machine: Machine, settings: Settings, revolutions: float) -> Trajectory:
    os._exit(3)


def test_an_isolated_run_is_the_run_itself() -> None:
    alone, here = run_isolated(SAW, SETTINGS, 1.0, timeout=60.0), run(SAW, SETTINGS, 1.0)
    assert alone.outcome is Outcome.COMPLETED
    assert (alone.points["C"].position.values == here.points["C"].position.values).all()


@pytest.mark.parametrize(
    ("task", "limits", "outcome", "reason"),
    [
        (engine_abort, {"timeout": 60.0}, Outcome.CRASHED, "SIGABRT"),
        (leave, {"timeout": 60.0}, Outcome.CRASHED, "status 3"),
        (hang, {"timeout": 3.0}, Outcome.TIMED_OUT, "3 s"),
        (exhaust, {"timeout": 60.0, "memory": 4_000_000_000}, Outcome.OUT_OF_MEMORY, "4000000000"),
        (exhaust_and_keep, {"timeout": 60.0, "memory": 4_000_000_000}, Outcome.OUT_OF_MEMORY, "4000000000"),
    ],
)
def test_a_fault_ends_as_its_outcome_and_has_no_errors(task, limits, outcome, reason) -> None:  # type: ignore[no-untyped-def]
    trajectory = run_isolated(SAW, SETTINGS, 1.0, task=task, **limits)
    assert trajectory.outcome is outcome
    assert reason in trajectory.reason
    with pytest.raises(ValueError, match=outcome.slug):
        compare(trajectory, SAW)


def test_memory_is_limited_from_what_the_process_begins_with_too() -> None:
    assert isolated(take, 10_000_000, headroom=100_000_000) == 10_000_000
    ended = isolated(take, 200_000_000, headroom=100_000_000)
    assert ended == Ended(Outcome.OUT_OF_MEMORY, "the limit was 100000000 bytes more than it began with")


def take(size: int) -> int:
    return len(bytearray(size))


def test_a_mistake_in_a_task_is_raised() -> None:
    with pytest.raises(ZeroDivisionError, match="a mistake"):
        run_isolated(SAW, SETTINGS, 1.0, timeout=60.0, task=mistake)


def leave_as_python_does() -> None:
    raise SystemExit(3)


def test_an_end_of_python_in_a_task_is_no_abort() -> None:
    assert isolated(leave_as_python_does) == Ended(Outcome.CRASHED, "ended with status 3")


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


OWNER = """
import os, sys, time
sys.path.insert(0, {tests!r})
from conrod.studies.execution.isolation import isolated
from test_isolation import tell_and_hang
if __name__ == "__main__":
    isolated(tell_and_hang)
"""


def tell_and_hang() -> None:
    print(os.getpid(), file=sys.stderr, flush=True)
    time.sleep(1000.0)


@pytest.mark.skipif(not Path("/proc/self").exists(), reason="needs /proc to see the processes")
def test_a_hang_ends_with_the_one_who_waits_for_it(tmp_path: Path) -> None:
    script = tmp_path / "owner.py"
    script.write_text(OWNER.format(tests=str(Path(__file__).parent)))
    with subprocess.Popen([sys.executable, str(script)], stderr=subprocess.PIPE, text=True) as owner:
        assert owner.stderr is not None
        alone = int(owner.stderr.readline())
        assert Path(f"/proc/{alone}").exists()
        owner.kill()
    give_up = time.monotonic() + 60.0
    while Path(f"/proc/{alone}").exists() and time.monotonic() < give_up:
        time.sleep(0.05)
    assert not Path(f"/proc/{alone}").exists()


def test_bad_usage_is_no_outcome_in_isolation_either() -> None:
    with pytest.raises(InvalidInput, match="timestep"):
        run_isolated(SAW.with_parameters(speed=1.0), SETTINGS, 1.0, timeout=60.0)


@pytest.mark.parametrize("change", [{"iterations": 0}, {"error_bias": -0.1}, {"collision_bias": float("nan")}])
def test_settings_that_abort_pymunk_are_refused(change: dict[str, float]) -> None:
    with pytest.raises(InvalidInput, match=next(iter(change))):
        dataclasses.replace(SETTINGS, **change)


@pytest.mark.parametrize("mass", [0.0, -1.0, float("inf"), float("nan")])
def test_masses_that_are_no_masses_are_refused(mass: float) -> None:
    with pytest.raises(InvalidInput, match="mass of rod"):
        Body("rod", mass, 1.0)


def test_settings_for_another_speed_are_refused() -> None:
    with pytest.raises(InvalidInput, match="timestep"):
        run(SAW.with_parameters(speed=1.0), SETTINGS)
