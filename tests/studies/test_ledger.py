"""What a ledger keeps is there again, whole, whoever was killed or wrote beside; what is no ledger is refused."""

from __future__ import annotations

import dataclasses
import os
import sqlite3
import subprocess
import sys
from collections.abc import Callable
from contextlib import closing
from pathlib import Path

import pytest

from conrod import InvalidInput, PymunkSettings, Saw
from conrod.studies.frame import ledger_file
from conrod.studies.frame.case import Measurement
from conrod.studies.frame.ledger import Ledger
from conrod.studies.frame.run import RunCase, measure
from conrod.studies.frame.timing import Timing

SAW = Saw()
BASE = PymunkSettings.tuned(SAW, 20)


def cell(k: int = 1) -> RunCase:
    return RunCase("saw-500rpm", SAW, dataclasses.replace(BASE, iterations=k), revolutions=1.0)


CELLS = [cell(k + 1) for k in range(50)]
KEYS = [c.key for c in CELLS]
MEASURED = measure(CELLS[20])
STOPPED = Measurement("timed-out", "no result after 3 s")
TIMING = Timing(2e-3, 1e-6, 2000.0, 1000, 5, "one machine")


# -- what goes in comes out ------------------------------------------------------------------------------------------


def test_a_measurement_comes_back_to_the_last_bit(ledger: Ledger, path: Path) -> None:
    assert MEASURED.outcome == "completed"
    ledger.keep(CELLS[0], MEASURED)
    ledger.close()
    with Ledger.open(path) as again:
        assert again.measurements(KEYS).get(KEYS[0]) == MEASURED
        assert again.measurements(KEYS).get(KEYS[1]) is None


def test_a_run_stopped_at_a_limit_is_known_by_it_and_replaces_no_finished_one(ledger: Ledger) -> None:
    ledger.keep(CELLS[0], STOPPED, limit=3.0)
    assert ledger.stopped(KEYS) == {KEYS[0]: ("timed-out", 3.0)}
    ledger.keep(CELLS[0], MEASURED)
    assert ledger.stopped(KEYS) == {}
    ledger.keep(CELLS[0], STOPPED, limit=3.0)
    assert ledger.measurements(KEYS).get(KEYS[0]) == MEASURED
    ledger.keep(CELLS[0], STOPPED, limit=3.0, replace=True)
    assert ledger.measurements(KEYS).get(KEYS[0]) == STOPPED


# -- several processes, and killed ones ------------------------------------------------------------------------------

WRITER = f"""
import sys
from pathlib import Path
sys.path.insert(0, {str(Path(__file__).parent)!r})
from test_ledger import CELLS, Ledger, Measurement
with Ledger.open(Path(sys.argv[1])) as ledger:
    for k in range(int(sys.argv[2]), int(sys.argv[3])):
        ledger.keep(CELLS[k], Measurement("completed", str(k)))
        print(k, flush=True)
    if len(sys.argv) > 4:
        import os
        ledger._connection.execute("BEGIN IMMEDIATE")
        ledger._connection.execute("DELETE FROM runs")
        os.kill(os.getpid(), 9)
"""


def write(path: Path, first: int, last: int, *more: str) -> subprocess.Popen[str]:
    command = [sys.executable, "-c", WRITER, str(path), str(first), str(last), *more]
    return subprocess.Popen(command, stdout=subprocess.PIPE, text=True)


def test_two_processes_write_one_ledger_at_once_and_both_may_make_it(path: Path) -> None:
    # They overlap: both write the keys from 20 to 29.
    with write(path, 0, 30) as one, write(path, 20, 50) as two:
        assert one.wait() == two.wait() == 0
    with Ledger.open(path) as ledger:
        assert {key: m.reason for key, m in ledger.measurements(KEYS).items()} == {
            key: str(k) for k, key in enumerate(KEYS)
        }


def test_what_was_kept_outlives_a_process_killed_in_the_middle_of_the_next_write(path: Path) -> None:
    with write(path, 0, 30, "and die") as writer:
        assert writer.wait() == -9
    with Ledger.open(path) as ledger:
        assert ledger.finished(KEYS) == set(KEYS[:30])


# -- what is refused -------------------------------------------------------------------------------------------------


def refusal(path: Path, patience: float = 5.0) -> str:
    with pytest.raises(InvalidInput) as told:
        Ledger.open(path, patience)
    message = str(told.value)
    assert "\n" not in message
    assert str(path) in message
    return message


def a_diary(path: Path) -> None:
    path.write_text("a diary\n")


def another_programs(path: Path) -> None:
    with closing(sqlite3.connect(path)) as other:
        other.execute("CREATE TABLE diary (day TEXT)")


def a_damaged_one(path: Path) -> None:
    with Ledger.open(path) as ledger:
        for k in range(20):
            ledger.keep(CELLS[k], MEASURED)
    content = bytearray(path.read_bytes())
    content[100:] = bytes(byte ^ 0x5A for byte in content[100:])
    path.write_bytes(content)


def a_newer_one(path: Path) -> None:
    Ledger.open(path).close()
    with closing(sqlite3.connect(path)) as newer:
        newer.execute(f"PRAGMA user_version = {ledger_file.SCHEMA_VERSION + 1}")


@pytest.mark.parametrize(
    ("made", "words"),
    [
        (a_diary, "file is not a database"),
        (another_programs, "another program"),
        (a_damaged_one, "malformed"),
        (a_newer_one, "newer conrod"),
        (Path.mkdir, "no regular file"),
        (os.mkfifo, "no regular file"),
    ],
)
def test_what_is_no_ledger_of_this_conrod_is_refused_and_stays_as_it_is(
    path: Path, made: Callable[[Path], None], words: str
) -> None:
    made(path)
    before = path.read_bytes() if path.is_file() else None
    assert words in refusal(path)
    assert (path.read_bytes() if path.is_file() else None) == before


def test_a_ledger_locked_for_too_long_is_said_to_be(ledger: Ledger, path: Path) -> None:
    ledger.keep(CELLS[0], MEASURED)
    with Ledger.open(path, patience=0.2) as other:
        ledger._connection.execute("BEGIN IMMEDIATE")
        assert other.finished(KEYS) == {KEYS[0]}  # readers do not wait
        with pytest.raises(InvalidInput, match="is locked"):
            other.keep(CELLS[1], MEASURED)
        ledger._connection.execute("ROLLBACK")
        other.keep(CELLS[1], MEASURED)
        assert ledger.finished(KEYS) == set(KEYS[:2])


def test_a_full_ledger_is_said_to_be_and_keeps_what_it_has(ledger: Ledger) -> None:
    pages = ledger._connection.execute("PRAGMA page_count").fetchone()[0]
    ledger._connection.execute(f"PRAGMA max_page_count = {pages + 20}")
    kept: list[str] = []
    with pytest.raises(InvalidInput, match="disk is full") as told:  # noqa: PT012
        for c in CELLS:
            ledger.keep(c, MEASURED)
            kept.append(c.key)
    assert "\n" not in str(told.value)
    assert kept
    assert ledger.finished(KEYS) == set(kept)


def test_an_error_of_conrod_itself_is_not_dressed_as_one_of_the_file(ledger: Ledger) -> None:
    # Negative control: a faulty statement stays what it is.
    with pytest.raises(sqlite3.OperationalError, match="no such table"):
        list(ledger._select("SELECT key FROM no_table WHERE key IN", KEYS))
