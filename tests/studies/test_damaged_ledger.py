"""A damaged row of the ledger counts as not run: it is reported, made again, and nothing ends in a traceback."""

from __future__ import annotations

import dataclasses
import math
import random
import shutil
import sqlite3
from collections.abc import Callable
from concurrent.futures import Future
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner

from conrod import InvalidInput, PymunkSettings, Saw
from conrod.cli import cli
from conrod.studies.execution.dispatch import run_cases
from conrod.studies.execution.worker_process import Limits
from conrod.studies.frame.case import Case, Measurement
from conrod.studies.frame.ledger import Ledger
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

    def __init__(self) -> None:
        self.ran: list[str] = []
        self.lost = 0

    def submit(self, function: Callable[..., Any], task: Callable[..., Any], case: Case) -> Future[Measurement]:
        self.ran.append(case.key)
        future: Future[Measurement] = Future()
        future.set_result(RESULTS[case.key])
        return future

    def started(self, *counts: object) -> None: ...

    def advanced(self, case: Case, how: str) -> None: ...

    def unreadable(self, count: int) -> None:
        self.lost += count


def resumed(path: Path) -> Replayed:
    """A resume over all cells, whose results must be what they were; the rows of the ledger too."""
    seen = Replayed()
    with Ledger.open(path) as ledger:
        before = list(ledger.rows())
        assert len(before) + ledger.damaged <= len(CELLS) + 1
        assert run_cases(CELLS, ledger, seen, watcher=seen) == RESULTS  # type: ignore[arg-type]
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


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return kept_whole(tmp_path_factory.mktemp("whole") / "ledger.sqlite")


def test_sixty_overwritten_values_are_made_again(whole: Path, tmp_path: Path) -> None:
    chance, again = random.Random(20), 0
    for k in range(60):
        path = tmp_path / f"{k}.sqlite"
        shutil.copy(whole, path)
        key, column = overwrite_value(path, chance)
        seen = resumed(path)
        assert seen.ran in ([], [key])
        assert seen.ran or column == "outcome", "the damage was not seen"
        again += len(seen.ran)
        assert resumed(path).ran == []
    assert again > 40


def test_sixty_overwritten_places_of_the_file_end_in_no_traceback(whole: Path, tmp_path: Path) -> None:
    chance, refused = random.Random(21), list[str]()
    for k in range(60):
        path = tmp_path / f"{k}.sqlite"
        shutil.copy(whole, path)
        overwrite_place(path, chance)
        try:
            resumed(path)
        except InvalidInput as error:
            refused.append(str(error))
    assert all("the ledger" in message and "\n" not in message for message in refused)
    assert len(refused) < 20  # what holds the rows together is a small part of the file


def test_numbers_that_json_has_not_come_back(tmp_path: Path) -> None:
    odd = Measurement("completed", phase={"max": math.nan, "final": math.inf}, beside={"none": None, "tiny": 5e-324})
    with Ledger.open(tmp_path / "ledger.sqlite") as ledger:
        ledger.keep(CELLS[0], odd)
        kept = ledger.measurements(KEYS).get(KEYS[0])
    assert kept is not None
    assert repr(kept) == repr(odd)


def test_results_leave_out_what_is_damaged_and_say_so(whole: Path, tmp_path: Path) -> None:
    path = tmp_path / "ledger.sqlite"
    shutil.copy(whole, path)
    with closing(sqlite3.connect(path)) as raw, raw:
        # Still JSON, of another run: what would be shown is not what was run.
        raw.execute("UPDATE cells SET identity = replace(identity, '7.', '8.') WHERE key = ?", (KEYS[0],))
        raw.execute("UPDATE runs SET measurement = x'00' WHERE key = ?", (KEYS[1],))
    done = CliRunner().invoke(cli, ["results", "--ledger", str(path)])
    assert done.exit_code == 0
    assert "2 runs in" in done.stderr
    assert len(done.stdout.splitlines()) == 1 + len(CELLS) - 2
    assert done.stderr.count("\n") == 1
    assert resumed(path).lost == 2
