"""Cells run by any executor give one table, and what a cell does to its process costs that cell alone."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from itertools import islice
from pathlib import Path

import cell_tasks as tasks
import pytest
from cell_tasks import Here
from outside_kills import children

from conrod import InvalidInput
from conrod.studies.execution.dispatch import run_cases
from conrod.studies.execution.local import LocalProcesses, RepeatingExecutor
from conrod.studies.execution.worker_process import Limits
from conrod.studies.frame.case import Measurement
from conrod.studies.frame.ledger import Ledger
from conrod.studies.frame.run import RunCase, measure

CELLS = tasks.cells(30)


@pytest.fixture(scope="module")
def local() -> Iterator[LocalProcesses]:
    with LocalProcesses(2, cell_timeout=60.0) as executor:
        yield executor


def ended(outcome: type[Exception]) -> Callable[[RunCase], Measurement]:
    def task(cell: RunCase) -> Measurement:
        raise outcome("no result after 3 s")

    return task


# -- one table, whoever runs it --------------------------------------------------------------------------------------


@pytest.mark.parametrize("executor", [Here, lambda: LocalProcesses(2, cell_timeout=60.0)])
def test_every_executor_gives_the_same_table(executor: Callable[[], RepeatingExecutor], ledger: Ledger) -> None:
    expected = {cell.key: measure(cell) for cell in CELLS[:6]}
    with executor() as made:
        table = run_cases(CELLS[:6], ledger, made)
    assert table == expected
    assert list(table) == list(expected)
    assert any(m.outcome == "completed" for m in table.values())


def test_a_cell_runs_once_however_often_it_is_asked_for(ledger: Ledger) -> None:
    here = Here()
    table = run_cases(tasks.assigned([*CELLS[:3], *CELLS[:4]], tasks.echo), ledger, here)
    assert sorted(here.ran) == [0, 1, 2, 3]
    assert [int(m.reason) for m in table.values()] == [0, 1, 2, 3]
    again = Here()
    more = run_cases(tasks.assigned(CELLS[:5], tasks.echo), ledger, again)
    assert more == table | ledger.measurements([CELLS[4].key])
    assert again.ran == [4]


@pytest.mark.parametrize(("error", "outcome"), [(TimeoutError, "timed-out"), (MemoryError, "out-of-memory")])
def test_a_cell_that_ended_at_a_limit_runs_again_where_more_is_allowed(
    ledger: Ledger, error: type[Exception], outcome: str
) -> None:
    def again(timeout: float | None, memory: int | None) -> list[int]:
        here = Here(Limits(timeout, memory))
        table = run_cases(tasks.assigned(CELLS[:1], ended(error)), ledger, here)
        assert [m.outcome for m in table.values()] == [outcome]
        return here.ran

    assert again(3.0, 1000) == [0]
    assert again(3.0, 1000) == []
    assert again(2.0, 900) == []
    assert again(4.0, 2000) == [0]
    done = Here(Limits(5.0, 3000))
    assert [m.outcome for m in run_cases(tasks.assigned(CELLS[:1], tasks.echo), ledger, done).values()] == ["completed"]
    assert again_is_none(ledger)


def again_is_none(ledger: Ledger) -> bool:
    here = Here()
    run_cases(tasks.assigned(CELLS[:1], tasks.echo), ledger, here)
    return not here.ran


# -- what a cell does to its process ---------------------------------------------------------------------------------


def test_crashes_a_hang_and_a_memory_hog_cost_their_own_cells_alone(ledger: Ledger) -> None:
    cells = tasks.cells(40)
    with LocalProcesses(2, cell_timeout=tasks.TIMEOUT, cell_memory=tasks.MEMORY) as executor:
        table = run_cases(tasks.assigned(cells, tasks.misbehave), ledger, executor)
    assert len(table) == 40
    wrong = {
        tasks.CRASHES: ("crashed", "ended by signal SIGABRT"),
        tasks.HANGS: ("timed-out", "no result after 5 s"),
        tasks.HOARDS: ("out-of-memory", "the limit was 3000000000 bytes more than it began with"),
        tasks.LEAVES: ("crashed", "ended with status 3"),
    }
    for cell in cells:
        k = tasks.number(cell)
        expected = wrong.get(k, wrong[tasks.CRASHES] if k % 10 == tasks.CRASHES else ("completed", str(k)))
        assert (table[cell.key].outcome, table[cell.key].reason) == expected
    assert ledger.stopped(table) == {
        cells[tasks.HANGS].key: ("timed-out", 5.0),
        cells[tasks.HOARDS].key: ("out-of-memory", 3e9),
    }


def test_workers_are_used_again_until_one_dies(ledger: Ledger, local: LocalProcesses) -> None:
    table = run_cases(tasks.assigned(CELLS, tasks.count_processes), ledger, local)
    workers = {int(m.reason) for m in table.values()}
    assert len(workers) <= 2
    assert os.getpid() not in workers
    for worker in workers:
        os.kill(worker, signal.SIGKILL)
    # Killed while idle: nobody's result is lost, and nobody is blamed; nor where one call after another meets them.
    (found,) = run_cases(tasks.assigned(CELLS[:1], tasks.count_processes), ledger, local, fresh=True).values()
    assert found.outcome == "completed"
    assert int(found.reason) not in workers


def test_bad_usage_of_a_cell_goes_to_the_caller_and_what_is_finished_is_kept(
    ledger: Ledger, local: LocalProcesses
) -> None:
    with pytest.raises(InvalidInput, match="cannot be run"):
        run_cases(tasks.assigned(CELLS, tasks.refuse), ledger, local)
    kept = ledger.measurements(cell.key for cell in CELLS)
    assert all(m.outcome == "completed" for m in kept.values())
    assert CELLS[tasks.CRASHES].key not in kept


@pytest.mark.parametrize("python", ["/bin/false", "/no/such/python"])
def test_a_process_that_cannot_start_is_no_outcome_of_a_cell(
    ledger: Ledger, monkeypatch: pytest.MonkeyPatch, python: str
) -> None:
    monkeypatch.setattr(sys, "executable", python)
    with LocalProcesses(1) as executor, pytest.raises(InvalidInput, match="cannot start"):
        run_cases(CELLS[:3], ledger, executor)
    assert ledger.finished(c.key for c in CELLS) == set()


# -- interrupted and killed ------------------------------------------------------------------------------------------


class Interrupter:
    """Presses Ctrl-C after so many results."""

    def __init__(self, after: int) -> None:
        self.left = after
        self.told: tuple[int, int] | None = None
        self.kept: list[int] = []

    def started(self, total: int, already_finished: int) -> None:
        self.told = (total, already_finished)

    def advanced(self, cell: RunCase, how: str) -> None:
        self.kept.append(tasks.number(cell))
        self.left -= 1
        if self.left == 0:
            raise KeyboardInterrupt


def test_an_interrupt_keeps_what_is_finished_and_the_next_call_does_the_rest(ledger: Ledger) -> None:
    watcher = Interrupter(5)
    with pytest.raises(KeyboardInterrupt), LocalProcesses(2) as executor:
        run_cases(tasks.assigned(CELLS, tasks.echo), ledger, executor, watcher=watcher)
    assert watcher.told == (30, 0)
    kept = ledger.measurements(cell.key for cell in CELLS)
    assert {tasks.number(c) for c in CELLS if c.key in kept} == set(watcher.kept)
    assert 5 <= len(kept) < 30
    rest = Here()
    table = run_cases(tasks.assigned(CELLS, tasks.echo), ledger, rest)
    assert len(rest.ran) == 30 - len(kept)
    assert [int(m.reason) for m in table.values()] == list(range(30))


SWEEP = """
import sys
from pathlib import Path
sys.path.insert(0, {tests!r})
import cell_tasks
from conrod.studies.execution.dispatch import run_cases
from conrod.studies.execution.local import LocalProcesses
from conrod.studies.frame.ledger import Ledger

class Told:
    def started(self, total, already_finished):
        print("workers", flush=True)
    def advanced(self, case, measurement):
        print("kept", flush=True)

with Ledger.open(Path(sys.argv[1])) as ledger, LocalProcesses(2) as executor:
    run_cases({cells}, ledger, executor, watcher=Told())
"""


def sweep(path: Path, count: int, task: str | None = None) -> subprocess.Popen[str]:
    cells = f"cell_tasks.cells({count})"
    cells = cells if task is None else f"cell_tasks.assigned({cells}, cell_tasks.{task})"
    script = SWEEP.format(tests=str(Path(__file__).parents[1] / "support"), cells=cells)
    return subprocess.Popen([sys.executable, "-c", script, str(path)], stdout=subprocess.PIPE, text=True)


def test_killed_at_any_moment_and_continued_the_table_is_that_of_an_undisturbed_run(tmp_path: Path) -> None:
    count, cells = 40, tasks.cells(40)
    with Ledger.open(tmp_path / "undisturbed") as ledger:
        undisturbed = run_cases(cells, ledger, Here())
        rows = list(ledger.rows())
    kept_before = 0
    for after in (3, 12):
        with sweep(tmp_path / "killed", count) as running:
            assert running.stdout is not None
            told = (line for line in running.stdout if line.startswith("kept"))
            assert len(list(islice(told, after))) == after
            running.kill()
        with Ledger.open(tmp_path / "killed") as ledger:
            kept = len(ledger.finished(cell.key for cell in cells))
        # Negative control: it was killed in the middle, not before and not after.
        assert kept_before < kept < count
        kept_before = kept
    with Ledger.open(tmp_path / "killed") as ledger, LocalProcesses(2) as executor:
        assert run_cases(cells, ledger, executor) == undisturbed
        assert list(ledger.rows()) == rows


@pytest.mark.skipif(not Path("/proc/self/task").exists(), reason="needs /proc to see the processes")
def test_workers_end_with_a_caller_that_is_killed_even_in_the_middle_of_a_hang(tmp_path: Path) -> None:
    with sweep(tmp_path / "ledger", 8, "misbehave") as running:
        assert running.stdout is not None
        while running.stdout.readline().startswith("workers"):
            pass
        workers = list(children(running.pid))
        assert workers
        running.kill()
    give_up = time.monotonic() + 60.0
    while any(Path(f"/proc/{worker}").exists() for worker in workers) and time.monotonic() < give_up:
        time.sleep(0.05)
    assert not any(Path(f"/proc/{worker}").exists() for worker in workers)
