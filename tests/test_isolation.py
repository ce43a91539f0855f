"""A run that kills its process, hangs or eats all memory is an outcome."""

from __future__ import annotations

import dataclasses
import os
import time

import pymunk
import pytest

from conrod import InvalidInput, Outcome, PymunkSettings, Saw, Trajectory, compare, run
from conrod.engines.engine import Machine
from conrod.isolation import run_isolated
from conrod.mechanism import Body
from conrod.trajectory import Settings

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
    hoard = []
    while True:
        hoard.append(bytearray(50_000_000))


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
    ],
)
def test_a_fault_ends_as_its_outcome_and_has_no_errors(task, limits, outcome, reason) -> None:  # type: ignore[no-untyped-def]
    trajectory = run_isolated(SAW, SETTINGS, 1.0, task=task, **limits)
    assert trajectory.outcome is outcome
    assert reason in trajectory.reason
    with pytest.raises(ValueError, match=outcome.slug):
        compare(trajectory, SAW)


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
