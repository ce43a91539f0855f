"""What a ledger keeps is there again, whole, whoever was killed or wrote beside; what is no ledger is refused."""

from __future__ import annotations

import json
import math
import os
import random
import re
import shutil
import signal
import sqlite3
import zlib
from collections.abc import Callable
from contextlib import closing
from functools import partial
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import platformdirs
import pytest
from cell_tasks import InProcessExecutor, cells, substitute_task
from command_line import conrod

from conrod import InvalidInput, system
from conrod.execution import case, ledger_file, runner
from conrod.execution.case import CaseResult
from conrod.execution.ledger import Ledger, default_ledger_path
from conrod.execution.local import FailedCall, call_isolated
from conrod.execution.run import RunCase, RunResult
from conrod.execution.runner import Watcher, run_cases
from conrod.execution.timing import Timing

FIRST, SECOND, *OTHERS = cells(50)
CELLS = [SECOND, FIRST, *OTHERS]  # a plain run first
KEYS = [c.key for c in CELLS]
BY_KEY = {c.key: c for c in CELLS}
MEASURED = CELLS[0].perform()
SLOW = pytest.mark.slow
STOPPED = RunResult("timed-out", "no result after 3 s")


def test_ledger_is_the_named_file_or_one_in_the_cache_folder(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CONROD_LEDGER", "runs/mine.sqlite")
    assert default_ledger_path() == Path("runs/mine.sqlite")
    monkeypatch.delenv("CONROD_LEDGER")
    assert default_ledger_path() == platformdirs.user_cache_path("conrod") / "ledger.sqlite"


def test_result_is_kept_bit_for_bit_with_nan_and_infinity(ledger: Ledger, path: Path) -> None:
    odd = RunResult("completed", errors={}, phase={"max": math.nan, "final": math.inf}, drive={"speed": 5e-324})
    for cell, kept in zip(CELLS[::2], (MEASURED, odd), strict=False):
        ledger.keep(cell, kept)
    ledger.close()
    with Ledger.open(path) as again:
        assert repr(again.results(BY_KEY)) == repr({KEYS[0]: MEASURED, KEYS[2]: odd})


def test_run_stopped_at_a_limit_replaces_no_finished_one(ledger: Ledger) -> None:
    ledger.keep(CELLS[0], STOPPED, limit=3.0)
    assert ledger.stops_at_limits(KEYS) == {KEYS[0]: ("timed-out", 3.0)}
    ledger.keep(CELLS[0], MEASURED)
    assert ledger.stops_at_limits(KEYS) == {}
    ledger.keep(CELLS[0], STOPPED, limit=3.0)
    assert ledger.results(BY_KEY).get(KEYS[0]) == MEASURED
    ledger.keep(CELLS[0], STOPPED, limit=3.0, replace=True)
    assert ledger.results(BY_KEY).get(KEYS[0]) == STOPPED


def keep_and_die(path: Path) -> None:
    ledger = Ledger.open(path)
    for cell in CELLS[:30]:
        ledger.keep(cell, RunResult("completed"))
    ledger._connection.execute("BEGIN IMMEDIATE")
    ledger._connection.execute("DELETE FROM runs")
    os.kill(os.getpid(), signal.SIGKILL)


def test_ledger_keeps_rows_when_killed_during_the_next_write(path: Path) -> None:
    # That two write one ledger at once is in test_execution.py.
    assert isinstance(call_isolated(keep_and_die, path), FailedCall)
    with Ledger.open(path) as ledger:
        assert ledger.finished_keys(KEYS) == set(KEYS[:30])


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
        newer.execute(f"PRAGMA user_version = {ledger_file.CACHE_VERSION + 1}")


@pytest.mark.parametrize(
    ("made", "words"),
    [
        (lambda path: path.write_text("a diary\n"), "file is not a database"),
        (another_programs, "another program"),
        (a_damaged_one, "malformed"),
        (a_newer_one, "newer conrod"),
        (Path.mkdir, "no regular file"),
        (os.mkfifo, "no regular file"),
    ],
)
def test_foreign_ledger_is_refused_and_stays_unchanged(path: Path, made: Callable[[Path], None], words: str) -> None:
    made(path)
    before = path.read_bytes() if path.is_file() else None
    with pytest.raises(InvalidInput, match=f"^.*{path}.*{words}.*$"):
        Ledger.open(path, patience=5.0)
    assert (path.read_bytes() if path.is_file() else None) == before


def test_an_older_ledger_is_emptied_once_and_its_runs_made_again(whole: Path, tmp_path: Path) -> None:
    path = tmp_path / "ledger.sqlite"
    shutil.copy(whole, path)
    with closing(sqlite3.connect(path)) as older:
        older.execute("ALTER TABLE runs RENAME COLUMN result TO measurement")
        older.execute("PRAGMA user_version = 1")
    before = path.read_bytes()
    done = conrod("results", "--ledger", str(path))
    assert (done.returncode, done.stderr.count("\n")) == (2, 1)
    assert "from an older conrod" in done.stderr
    assert path.read_bytes() == before  # a reader removes nothing
    emptied: list[int] = []
    watcher = Watcher()
    watcher.on_emptied = emptied.append  # type: ignore[method-assign]
    for ran in (len(FEW), 0):
        with Ledger.open(path) as ledger, InProcessExecutor() as seen:
            assert ledger.timings(KEYS, TIMING.machine) == {}
            assert run_cases(substitute_task(FEW, recalled), ledger, seen, watcher=watcher) == RESULTS
            assert len(seen.cases) == ran
    assert emptied == [len(FEW)]


def test_a_ledger_locked_for_too_long_is_said_to_be(ledger: Ledger, path: Path) -> None:
    ledger.keep(CELLS[0], MEASURED)
    with Ledger.open(path, patience=0.2) as other:
        ledger._connection.execute("BEGIN IMMEDIATE")
        assert other.finished_keys(KEYS) == {KEYS[0]}  # readers do not wait
        with pytest.raises(InvalidInput, match="is locked"):
            other.keep(CELLS[1], MEASURED)
        ledger._connection.execute("ROLLBACK")
        other.keep(CELLS[1], MEASURED)
        assert ledger.finished_keys(KEYS) == set(KEYS[:2])


def test_a_full_ledger_is_said_to_be_and_keeps_what_it_has(ledger: Ledger) -> None:
    pages = ledger._connection.execute("PRAGMA page_count").fetchone()[0]
    ledger._connection.execute(f"PRAGMA max_page_count = {pages + 20}")
    kept: list[str] = []
    with pytest.raises(InvalidInput, match=r"^.*disk is full.*$"):  # noqa: PT012
        for c in CELLS:
            ledger.keep(c, MEASURED)
            kept.append(c.key)
    assert kept
    assert ledger.finished_keys(KEYS) == set(kept)


def test_internal_error_is_not_reported_as_one_of_the_file(ledger: Ledger) -> None:
    # Negative control: a faulty statement stays what it is.
    with pytest.raises(sqlite3.OperationalError, match="no such table"):
        list(ledger._select("SELECT key FROM no_table WHERE key IN", KEYS))


class InterruptedConnection(sqlite3.Connection):
    """A connection to a ledger, with Ctrl-C right after the first statement that begins as `due` does."""

    due = ""

    def execute(self, statement: str, *values: Any) -> sqlite3.Cursor:
        done = super().execute(statement, *values)
        if self.due and statement.startswith(self.due):
            self.due = ""
            raise KeyboardInterrupt
        return done


@pytest.mark.parametrize("moment", ["BEGIN", "INSERT OR IGNORE INTO cells", "INSERT INTO runs"])
def test_interrupt_amid_writing_keeps_what_has_finished(
    moment: str, path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    connected = partial(sqlite3.connect, factory=InterruptedConnection)
    monkeypatch.setattr(ledger_file, "sqlite3", SimpleNamespace(**{**vars(sqlite3), "connect": connected}))
    with Ledger.open(path) as ledger:
        ledger._connection.due = moment  # type: ignore[attr-defined]
        with pytest.raises(KeyboardInterrupt), InProcessExecutor() as executor:
            run_cases(substitute_task(FEW, recalled), ledger, executor)
    with Ledger.open(path) as ledger, InProcessExecutor() as executor:
        finished = ledger.finished_keys(RESULTS)
        assert finished
        assert run_cases(substitute_task(FEW, recalled), ledger, executor) == RESULTS
        assert len(executor.cases) == len(FEW) - len(finished)


@pytest.mark.parametrize("part", ["VIEW timings AS SELECT * FROM cells", "VIEW v AS SELECT 1"])
def test_an_older_ledger_with_foreign_parts_is_refused_as_it_is(part: str, whole: Path, tmp_path: Path) -> None:
    path = tmp_path / "ledger.sqlite"
    shutil.copy(whole, path)
    with closing(sqlite3.connect(path)) as older:
        if "VIEW timings" in part:
            older.execute("DROP TABLE timings")
        older.execute(f"CREATE {part}")
        older.execute("PRAGMA user_version = 1")
    before = path.read_bytes()
    with pytest.raises(InvalidInput) as refused:
        Ledger.open(path)
    view = part.split()[1]
    assert str(refused.value) == (
        f"the ledger {path} is damaged: it has a view {view}, which conrod does not make; remove it or name another"
    )
    assert path.read_bytes() == before


# -- damaged -----------------------------------------------------------------------------------------------------------

FEW = CELLS[:6]
RESULTS = {cell.key: cell.perform() for cell in FEW}
TIMING = Timing(2e-3, 1e-6, 2000.0, 1000, 5, "one machine")


def recalled(case: RunCase) -> RunResult:
    return RESULTS[case.key]


def resumed(path: Path) -> list[str]:
    """Keys of what a resume over all cells runs, whose results must be what they were; the rows of the ledger too."""
    with Ledger.open(path) as ledger, InProcessExecutor() as seen:
        before = list(ledger.rows())
        assert len(before) + ledger.damaged <= len(FEW) + 1
        assert run_cases(substitute_task(FEW, recalled), ledger, seen) == RESULTS
        ledger.timings(KEYS, TIMING.machine)
    return [case.key for case in seen.cases]


def test_very_many_results_are_read_when_they_are_asked_for(
    whole: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path, damaged, reads = tmp_path / "ledger.sqlite", FEW[-1].key, list[int]()
    shutil.copy(whole, path)
    with closing(sqlite3.connect(path)) as other, other:
        other.execute("UPDATE runs SET result = x'00' WHERE key = ?", (damaged,))
    for module in (runner, case):
        monkeypatch.setattr(module, "RESULTS_AT_ONCE", 2)
    read = Ledger.results
    monkeypatch.setattr(Ledger, "results", lambda ledger, some: reads.append(len(some)) or read(ledger, some))
    with Ledger.open(path) as ledger, InProcessExecutor() as seen:
        found = run_cases(substitute_task(FEW, recalled), ledger, seen)
        assert (reads, len(found)) == ([], len(FEW))
        assert [found[cell.key] for cell in FEW[:2]] == [RESULTS[cell.key] for cell in FEW[:2]]
        assert reads == [2]
        # Negative control: the row that cannot be read is found when it is asked for, and made again.
        assert seen.cases == []
        assert found == RESULTS
        assert [case.key for case in seen.cases] == [damaged]
    assert resumed(path) == []


def overwrite_value(path: Path, chance: random.Random) -> tuple[str, str]:
    """Overwrite some bytes of a value; gives the key of its row, and its column."""
    key = chance.choice(KEYS[:6])
    column = chance.choice(["result", "identity", "key", "outcome"])
    table = "cells" if column == "identity" else "runs"
    with closing(sqlite3.connect(path)) as raw, raw:
        raw.execute("PRAGMA synchronous = OFF")
        raw.text_factory = bytes
        ((old,),) = raw.execute(f"SELECT {column} FROM {table} WHERE key = ?", (key,))
        first = chance.randrange(len(old))
        new = old[:first] + chance.randbytes(chance.randint(1, 40)) + old[first + 4 :]
        kind = "BLOB" if column == "result" else "TEXT"
        raw.execute(f"UPDATE {table} SET {column} = CAST(? AS {kind}) WHERE key = ?", (new, key))
    return key, column


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A ledger of all cells."""
    path = tmp_path_factory.mktemp("whole") / "ledger.sqlite"
    with Ledger.open(path) as ledger:
        for cell in FEW:
            ledger.keep(cell, RESULTS[cell.key])
            ledger.keep_timing(cell, TIMING)
    return path


def test_sixty_overwritten_values_are_made_again(whole: Path, tmp_path: Path) -> None:
    chance, again = random.Random(20), 0
    for k in range(60):
        path = tmp_path / f"{k}.sqlite"
        shutil.copy(whole, path)
        key, column = overwrite_value(path, chance)
        ran = resumed(path)
        assert ran in ([], [key])
        assert ran or column == "outcome", "the damage was not seen"
        again += len(ran)
        assert resumed(path) == []
    assert again > 40


def test_ledger_gives_no_traceback_with_sixty_corrupt_places(whole: Path, tmp_path: Path) -> None:
    chance, refused = random.Random(21), list[str]()
    for k in range(60):
        path, content = tmp_path / f"{k}.sqlite", bytearray(whole.read_bytes())
        first = chance.randrange(100, len(content) - 40)
        content[first : first + 20] = chance.randbytes(20)
        path.write_bytes(content)
        try:
            resumed(path)
        except InvalidInput as error:
            refused.append(str(error))
    assert all("the ledger" in message and "\n" not in message for message in refused)
    assert len(refused) < 20  # what holds the rows together is a small part of the file


@pytest.mark.parametrize(
    "values", [{"outcome": "completed", "reason": "", "errors": 5}, {"outcome": "gone", "reason": ""}, {"outcome": 1}]
)
def test_a_row_of_another_form_is_made_again(values: dict[str, Any], whole: Path, tmp_path: Path) -> None:
    path = tmp_path / "ledger.sqlite"
    shutil.copy(whole, path)
    with closing(sqlite3.connect(path)) as raw, raw:
        packed = zlib.compress(json.dumps(values).encode())
        raw.execute("UPDATE runs SET result = ? WHERE key = ?", (packed, KEYS[0]))
    assert resumed(path) == [KEYS[0]]
    assert resumed(path) == []


def test_table_counts_a_row_of_other_values_as_damaged(whole: Path, tmp_path: Path) -> None:
    path = tmp_path / "ledger.sqlite"
    shutil.copy(whole, path)
    with closing(sqlite3.connect(path)) as raw, raw:
        packed = zlib.compress(b'{"outcome": "completed", "sizes": {"position": 5}, "phase": 7}')
        raw.execute("UPDATE runs SET result = ? WHERE key = ?", (packed, KEYS[0]))
    with Ledger.open(path) as ledger:
        assert len(list(ledger.rows())) == len(FEW) - 1
        assert ledger.damaged == 1


def test_a_failed_call_is_kept_by_outcome_and_reason_alone(ledger: Ledger) -> None:
    ledger.keep(CELLS[0], CaseResult("crashed", "signal 11"))
    (blob,) = ledger._connection.execute("SELECT result FROM runs").fetchone()
    assert json.loads(zlib.decompress(blob)) == {"outcome": "crashed", "reason": "signal 11", "sizes": {}}
    assert ledger.results(BY_KEY) == {KEYS[0]: RunResult("crashed", "signal 11")}


def test_results_leave_out_what_is_damaged_and_say_so(whole: Path, tmp_path: Path) -> None:
    path = tmp_path / "ledger.sqlite"
    shutil.copy(whole, path)
    with closing(sqlite3.connect(path)) as raw, raw:
        # Still JSON, of another run: what would be shown is not what was run.
        raw.execute("UPDATE cells SET identity = replace(identity, '7.', '8.') WHERE key = ?", (KEYS[1],))
        raw.execute("UPDATE runs SET result = x'00' WHERE key = ?", (KEYS[0],))
    done = conrod("results", "--ledger", str(path))
    assert done.returncode == 0
    assert "2 runs in" in done.stderr
    assert len(done.stdout.splitlines()) == 1 + len(FEW) - 2
    assert done.stderr.count("\n") == 1
    assert set(resumed(path)) == set(KEYS[:2])


@pytest.mark.parametrize(
    ("statement", "said"),
    [
        ("DROP TABLE timings", "its table timings is missing"),
        ("DROP TABLE runs", "its table runs is missing"),
        ("ALTER TABLE cells DROP COLUMN name", "its table cells has no column name"),
        ("ALTER TABLE runs RENAME COLUMN outcome TO other", "its table runs has no column outcome"),
        ("CREATE TRIGGER t AFTER INSERT ON runs BEGIN DELETE FROM runs; END", "it has a trigger t"),
        ("ALTER TABLE runs RENAME TO r; CREATE VIEW runs AS SELECT * FROM r", "its table runs is missing"),
    ],
)
def test_a_ledger_with_other_tables_is_refused_in_one_line(
    statement: str, said: str, whole: Path, tmp_path: Path
) -> None:
    path = tmp_path / "ledger.sqlite"
    shutil.copy(whole, path)
    with closing(sqlite3.connect(path)) as raw:
        raw.executescript(statement)
    with pytest.raises(InvalidInput, match=f"ledger.sqlite is damaged: {said}"):
        Ledger.open(path)
    done = conrod("results", "--ledger", str(path))
    assert (done.returncode, done.stderr.count("\n")) == (2, 1)


def test_a_row_that_unpacks_without_end_counts_as_damaged(
    whole: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "ledger.sqlite"
    shutil.copy(whole, path)
    monkeypatch.setattr("conrod.execution.ledger.MAX_RESULT_BYTES", 1 << 20)
    with closing(sqlite3.connect(path)) as raw, raw:
        bomb = zlib.compress(b'{"outcome": "' + b"0" * (1 << 21))
        raw.execute("UPDATE runs SET result = ? WHERE key = ?", (bomb, KEYS[0]))
    assert resumed(path) == [KEYS[0]]


@pytest.mark.parametrize("written", ["closed", "in the log"])
def test_results_are_read_where_nothing_can_be_written(
    written: str, whole: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "ledger.sqlite"
    with Ledger.open(path) as writer:
        for cell in FEW:
            writer.keep(cell, RESULTS[cell.key])
            writer.keep_timing(cell, TIMING)
        # As long as somebody has it open its rows stand in the log beside it.
        files = list(tmp_path.glob("ledger.sqlite*")) if written == "in the log" else [whole]
        folder = tmp_path / "locked"
        folder.mkdir()
        for file in files:
            shutil.copy(file, folder)
    assert (folder / "ledger.sqlite-wal").exists() is (written == "in the log")
    before = {file: (file.read_bytes(), file.stat().st_mtime_ns) for file in folder.iterdir()}
    monkeypatch.setattr(ledger_file.os, "access", lambda file, mode: False)
    done = conrod("results", "--ledger", str(folder / "ledger.sqlite"))
    assert (done.returncode, len(done.stdout.splitlines())) == (0, 1 + len(FEW)), done.stderr
    assert {file: (file.read_bytes(), file.stat().st_mtime_ns) for file in folder.iterdir()} == before


# -- a verb goes on where it stopped -------------------------------------------------------------------------------


def judged(folder: Path, verb: str, asked: str, *more: str) -> tuple[str, dict[str, Any], int]:
    """What a verb says of the runs it makes, the document that it writes, and its exit status."""
    file = folder / "results.json"
    given = (*asked.split(), "--preset", "tuned", "--jobs", "1", "--json", str(file), *more)
    done = conrod(verb, *given, ledger=folder / "ledger.sqlite")
    assert done.returncode in (0, 1), done.stderr
    return done.stderr.splitlines()[0], json.loads(file.read_text()), done.returncode


@pytest.mark.parametrize(
    ("verb", "asked", "other", "tight"),
    [
        ("validate", "saw-40rpm --steps-per-rev 200 --revolutions 1", "--steps-per-rev 100", "position=1e-200"),
        # By one frame.
        pytest.param(
            "forces",
            "saw-40rpm --quantity torque --steps-per-rev 200",
            "--steps-per-rev 100",
            "torque=1e-200",
            marks=SLOW,
        ),
        pytest.param("free", "pendulum --seconds 0.5", "--seconds 0.25", "energy=1e-200", marks=SLOW),
    ],
)
def test_what_the_ledger_has_is_not_run_again_unless_asked_for(
    verb: str, asked: str, other: str, tight: str, tmp_path: Path
) -> None:
    said, first, status = judged(tmp_path, verb, asked)
    count = int(said.split()[1])
    anew, kept = f"runs: {count} to do, 0 in the ledger", f"runs: 0 to do, {count} in the ledger"
    assert said == anew
    assert judged(tmp_path, verb, asked) == (kept, first, status)
    assert judged(tmp_path, verb, asked, "--fresh") == (anew, first, status)
    # Another tolerance is judged without a run, and its verdict is not what is kept.
    assert judged(tmp_path, verb, asked, "--tolerance", tight)[::2] == (kept, 1)
    assert judged(tmp_path, verb, asked) == (kept, first, status)
    # Negative control: what is not the same run is run.
    said, found, _ = judged(tmp_path, verb, re.sub(rf"{other.split(maxsplit=1)[0]} \S+", other, asked))
    assert not said.startswith("runs: 0 to do")
    assert found != first


def test_a_place_is_the_one_whose_links_were_looked_at(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "folder").mkdir()
    (tmp_path / "link").symlink_to("folder")
    (tmp_path / "again").symlink_to(tmp_path / "link")

    def resolve(path: Path) -> Path:
        raise AssertionError(f"{path} is resolved again, and its links may be others by then")

    monkeypatch.setattr(system, "real_path", resolve)
    assert system.own_path(tmp_path / "again" / "l.sqlite") == tmp_path / "folder" / "l.sqlite"
