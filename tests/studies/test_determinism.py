"""Engines do the same thing twice, to the last bit; and it would be seen if they did not."""

from __future__ import annotations

import math
import os
from dataclasses import replace

import pytest
from catalogue import SAW
from cell_tasks import answer_study

from conrod.scenes import SCENES
from conrod.studies.limits.case import LimitCase, Setup
from conrod.studies.limits.determinism import (
    REPEATED_RUNS,
    Determinism,
    RunFunction,
    determinism_search,
    run_repeatedly,
)
from conrod.studies.limits.records import LimitResult
from conrod.studies.limits.stream_run import stream_run


def found(case: Setup, task: RunFunction = stream_run) -> Determinism:
    return answer_study(determinism_search(case), lambda cell: run_repeatedly(cell, task))


@pytest.mark.parametrize(("engine", "preset"), [("mujoco", "hardened"), ("pymunk", "tuned")])
def test_a_run_made_again_is_the_same_to_the_last_bit(engine: str, preset: str) -> None:
    one = found(Setup("saw-40rpm", SAW, engine, preset, 100))
    assert one.outcome == "completed"
    assert {len(text) for text in one.fingerprints.values()} == {64}
    assert one.identical == dict.fromkeys(REPEATED_RUNS[1:], True)


def test_repeated_runs_are_of_the_scene_by_its_name() -> None:
    setup = Setup("saw-40rpm", SAW, "mujoco", "hardened", 100)
    (case,) = next(determinism_search(setup))
    assert (case.name, case.scene) == ("saw-40rpm", SAW)
    assert case.settings == setup.settings()


def test_preset_has_no_fingerprints_when_unfit_for_the_machine() -> None:
    one = found(Setup("cam-follower", SCENES["cam-follower"], "mujoco", "hardened", 100))
    assert one.outcome == "unsupported"
    assert one.fingerprints == one.identical == {}


# -- negative controls: one bit of the start angle, in some of the runs ----------------------------------------------

CALLS: list[str] = []
PROCESS = "CONROD_TEST_PROCESS"


def off_by_a_bit(cell: LimitCase) -> LimitResult:
    return stream_run(replace(cell, start_angle=math.nextafter(cell.start_angle, 1.0)))


def other_the_second_time(cell: LimitCase) -> LimitResult:
    CALLS.append(cell.name)
    return off_by_a_bit(cell) if len(CALLS) == 2 else stream_run(cell)


def other_after_another_machine(cell: LimitCase) -> LimitResult:
    CALLS.append(cell.name)
    return off_by_a_bit(cell) if "another" in CALLS else stream_run(cell)


def other_in_another_process(cell: LimitCase) -> LimitResult:
    return stream_run(cell) if os.environ[PROCESS] == str(os.getpid()) else off_by_a_bit(cell)


@pytest.mark.parametrize(
    ("task", "differs"),
    [
        (other_the_second_time, "again"),
        (other_after_another_machine, "after another machine"),
        (other_in_another_process, "in another process"),
    ],
)
def test_one_bit_of_difference_is_seen_where_it_is(
    task: RunFunction, differs: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    CALLS.clear()
    monkeypatch.setenv(PROCESS, str(os.getpid()))
    one = found(Setup("saw-40rpm", SAW, "pymunk", "tuned", 20), task)
    assert one.identical == {run: run != differs for run in REPEATED_RUNS[1:]}
