"""Faults among real runs, in a module of its own because a worker process imports it."""

from __future__ import annotations

import ctypes
import random
from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from typing import Any

import numpy as np
from cell_tasks import assigned
from failure_examples import unchecked

from conrod import MuJoCoSettings, PymunkSettings
from conrod.scenes import SCENES
from conrod.studies.execution.dispatch import run_cases
from conrod.studies.execution.local import LocalProcesses
from conrod.studies.frame.case import Measurement
from conrod.studies.frame.ledger import Ledger
from conrod.studies.frame.run import RunCase, measure
from conrod.studies.limits.case import LimitCase

SAW = SCENES["saw-500rpm"]
SETTINGS = (PymunkSettings.tuned(SAW, 20), MuJoCoSettings.hardened(SAW, 20), PymunkSettings.tuned(SAW, 30))
HELD: list[Any] = []


def segfault() -> None:
    """Reads where there is nothing."""
    ctypes.string_at(0)


def hang() -> None:
    """In C, where no Python signal gets through, and at no cost to others: it waits for a lock that it has itself."""
    c, lock = ctypes.CDLL(None), ctypes.create_string_buffer(256)
    c.pthread_mutex_init(lock, None)
    while True:
        c.pthread_mutex_lock(lock)


def hoard() -> None:
    """Takes memory to the last kilobyte and keeps it; the large pieces are not touched, to leave others theirs."""
    size = 1 << 30
    while True:
        try:
            HELD.append(np.empty(size, dtype=np.uint8))
        except MemoryError:
            if size < 1024:
                raise
            size //= 2


def hoard_but(spare: int) -> None:
    """Takes all memory but so many bytes, and keeps it."""
    kept_free = np.empty(spare, dtype=np.uint8)
    with suppress(MemoryError):
        hoard()
    del kept_free


def engine_with_little(megabytes: int) -> Measurement:
    """A MuJoCo run in a process that has little memory left; it fails in the engine's own ways."""
    hoard_but(megabytes << 20)
    return measure(RunCase("saw-500rpm", SAW, MuJoCoSettings.hardened(SAW, 2000), 1.0))


def mistake_with_little(megabytes: int) -> Measurement:
    hoard_but(megabytes << 20)
    raise ZeroDivisionError("a mistake in the task")


def wrong_value(megabytes: int) -> Measurement:
    raise ValueError("a mistake in the task")


FAULTS: dict[str, Callable[[], None]] = {"segfault": segfault, "hang": hang, "hoard": hoard}
# Start angles of the cells that have one of these faults, far from those of the others.
ANGLES = {"segfault": 100.0, "hang": 200.0, "hoard": 300.0}
ABORT = "abort"
JOBS = 2
# Far more than any of these runs takes on a busy machine, and the time that a hang takes.
TIMEOUT = 10.0
MEMORY = 3_000_000_000
ENDS = {
    ABORT: ("crashed", "ended by signal SIGABRT"),
    "segfault": ("crashed", "ended by signal SIGSEGV"),
    "hang": ("timed-out", "no result after 10 s"),
    "hoard": ("out-of-memory", "the limit was 3000000000 bytes more than it began with"),
}


def runs(count: int) -> list[RunCase]:
    """Cheap real runs in both engines that differ in the angle that they start from; every tenth is watched."""
    made: list[RunCase] = []
    for k in range(count):
        kind = LimitCase if k % 10 == 0 else RunCase
        made.append(kind("saw-500rpm", SAW, SETTINGS[k % 3], 1.0, start_angle=1e-3 * k))
    return made


def with_faults(cells: list[RunCase], each: int) -> tuple[list[RunCase], dict[str, str]]:
    """The cells, some of them made faulty at random but reproducible places; and key -> fault.

    An abort is the engine's own assertion, brought about by what is in the cell; the others are the task's.
    """
    kinds = [ABORT, *FAULTS] * each
    places = random.Random(4).sample(range(len(cells)), len(kinds))
    made, faults = list(cells), {}
    for place, kind in zip(places, kinds, strict=True):
        made[place] = faulty(cells[place], kind)
        faults[made[place].key] = kind
    return made, faults


def faulty(cell: RunCase, kind: str) -> RunCase:
    if kind == ABORT:
        return replace(cell, settings=unchecked(SETTINGS[0], iterations=0))
    return replace(cell, start_angle=cell.start_angle + ANGLES[kind])


def run_or_fail(cell: RunCase) -> Measurement:
    """A run, unless its start angle says that it is a faulty one."""
    for kind, angle in ANGLES.items():
        if angle <= cell.start_angle < angle + 50.0:
            FAULTS[kind]()
    return cell.perform()


def run_with_faults(ledger: Ledger, cells: list[RunCase]) -> dict[str, Measurement]:
    with LocalProcesses(JOBS, cell_timeout=TIMEOUT, cell_memory=MEMORY) as executor:
        return run_cases(assigned(cells, run_or_fail), ledger, executor)
