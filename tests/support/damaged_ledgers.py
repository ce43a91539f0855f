"""Ledgers with something overwritten, and a resume over what they keep."""

from __future__ import annotations

import dataclasses
import random
import sqlite3
from collections.abc import Callable
from concurrent.futures import Future
from contextlib import closing
from pathlib import Path
from typing import Any

from conrod import PymunkSettings, Saw
from conrod.studies.execution.dispatch import run_cases
from conrod.studies.execution.worker_process import Limits
from conrod.studies.frame.case import Case
from conrod.studies.frame.ledger import Ledger
from conrod.studies.frame.measurement import Measurement
from conrod.studies.frame.run import RunCase, measure
from conrod.studies.frame.timing import Timing

SAW = Saw()
CELLS = [
    RunCase("saw-500rpm", SAW, dataclasses.replace(PymunkSettings.tuned(SAW, 20), iterations=k + 1), revolutions=1.0)
    for k in range(6)
]
KEYS = [cell.key for cell in CELLS]
RESULTS = {cell.key: measure(cell) for cell in CELLS}
TIMING = Timing(2e-3, 1e-6, 2000.0, 1000, 5, "one machine")


class Replayed:
    """An executor that knows all results, and which runs it was asked for."""

    limits, in_flight = Limits(), 1

    def __init__(self, results: dict[str, Measurement] = RESULTS) -> None:
        self.results = results
        self.ran: list[str] = []
        self.lost = 0

    def submit(self, function: Callable[..., Any], task: Callable[..., Any], case: Case) -> Future[Measurement]:
        self.ran.append(case.key)
        future: Future[Measurement] = Future()
        future.set_result(self.results[case.key])
        return future

    # -- and a watcher -------------------------------------------------------------------------------------------

    def started(self, *counts: object) -> None: ...

    def advanced(self, case: Case, how: str) -> None: ...

    def unreadable(self, count: int) -> None:
        self.lost += count


def resumed(path: Path, cells: list[Any] = CELLS) -> Replayed:
    """A resume over all cells, whose results must be what they were; the rows of the ledger too."""
    seen = Replayed()
    with Ledger.open(path) as ledger:
        before = list(ledger.rows())
        assert len(before) + ledger.damaged <= len(CELLS) + 1
        assert run_cases(cells, ledger, seen, watcher=seen) == {cell.key: RESULTS[cell.key] for cell in cells}  # type: ignore[arg-type]
        ledger.timings(KEYS, TIMING.machine)
    return seen


def kept_whole(path: Path) -> Path:
    """A ledger of all cells."""
    with Ledger.open(path) as ledger:
        for cell in CELLS:
            ledger.keep(cell, RESULTS[cell.key])
            ledger.keep_timing(cell, TIMING)
    return path


def overwrite_value(path: Path, chance: random.Random) -> tuple[str, str]:
    """Overwrite some bytes of a value; gives the key of its row, and its column."""
    key = chance.choice(KEYS)
    table, column = chance.choice(
        [("runs", "measurement"), ("cells", "identity"), ("runs", "key"), ("runs", "outcome")]
    )
    with closing(sqlite3.connect(path)) as raw, raw:
        raw.execute("PRAGMA synchronous = OFF")
        raw.text_factory = bytes
        ((old,),) = raw.execute(f"SELECT {column} FROM {table} WHERE key = ?", (key,))
        first = chance.randrange(len(old))
        new = old[:first] + chance.randbytes(chance.randint(1, 40)) + old[first + 4 :]
        kind = "BLOB" if column == "measurement" else "TEXT"
        raw.execute(f"UPDATE {table} SET {column} = CAST(? AS {kind}) WHERE key = ?", (new, key))
    return key, column


def overwrite_place(path: Path, chance: random.Random) -> None:
    """Overwrite twenty bytes of the file, wherever they are."""
    content = bytearray(path.read_bytes())
    first = chance.randrange(100, len(content) - 40)
    content[first : first + 20] = chance.randbytes(20)
    path.write_bytes(content)
