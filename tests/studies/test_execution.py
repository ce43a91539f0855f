"""Cells run by any executor give one table, and what a cell does to its process costs that cell alone."""

from __future__ import annotations

import math
import os
import signal
import subprocess
import sys
import time
from collections import Counter
from contextlib import ExitStack, suppress
from itertools import islice
from pathlib import Path
from typing import Any

import cell_tasks as tasks
import pytest
from cell_tasks import AGAIN, ActingWatcher, InProcessExecutor
from dying_task import die_and_return

from conrod import InvalidInput
from conrod.comparison.trajectory import Outcome
from conrod.execution.ledger import Ledger
from conrod.execution.local import FailedCall, LocalProcesses, call_isolated, call_on_file
from conrod.execution.run import RunCase, RunResult
from conrod.execution.runner import POLL_INTERVAL, run_cases
from conrod.execution.worker_process import CallLimits, WorkerProcess

CELLS = tasks.cells(30)


def test_a_cell_runs_once_however_often_it_is_asked_for(ledger: Ledger) -> None:
    here = InProcessExecutor()
    table = run_cases(tasks.substitute_task([*CELLS[:3], *CELLS[:4]], tasks.echo), ledger, here)
    assert sorted(here.ran) == [0, 1, 2, 3]
    assert [int(m.reason) for m in table.values()] == [0, 1, 2, 3]
    again = InProcessExecutor()
    more = run_cases(tasks.substitute_task(CELLS[:5], tasks.echo), ledger, again)
    assert more == table | ledger.results({CELLS[4].key: CELLS[4]})
    assert again.ran == [4]


@pytest.mark.parametrize(("error", "outcome"), [(TimeoutError, "timed-out"), (MemoryError, "out-of-memory")])
def test_cell_stopped_at_a_limit_runs_again_when_limit_grows(
    ledger: Ledger, error: type[Exception], outcome: str
) -> None:
    def stopped(cell: RunCase) -> RunResult:
        raise error("no result after 3 s")

    def again(timeout: float | None, memory: int | None) -> list[int]:
        here = InProcessExecutor(CallLimits(timeout, memory))
        table = run_cases(tasks.substitute_task(CELLS[:1], stopped), ledger, here)
        assert [m.outcome for m in table.values()] == [outcome]
        return here.ran

    assert again(3.0, 1000) == [0]
    assert again(3.0, 1000) == []
    assert again(2.0, 900) == []
    assert again(4.0, 2000) == [0]
    done = InProcessExecutor(CallLimits(5.0, 3000))
    assert [m.outcome for m in run_cases(tasks.substitute_task(CELLS[:1], tasks.echo), ledger, done).values()] == [
        "completed"
    ]
    run_cases(tasks.substitute_task(CELLS[:1], tasks.echo), ledger, done)
    assert done.ran == [0]


# -- what a cell does to its process ---------------------------------------------------------------------------------


def test_each_fault_costs_its_own_cell_alone(ledger: Ledger) -> None:
    with LocalProcesses(2, timeout=tasks.TIMEOUT, memory=tasks.MEMORY) as executor:
        tasks.check_that_faults_cost_their_own_cells(20, ledger, executor)


def test_workers_are_used_again_until_one_dies(ledger: Ledger, monkeypatch: pytest.MonkeyPatch) -> None:
    with LocalProcesses(2) as executor:
        table = run_cases(tasks.substitute_task(CELLS, tasks.count_processes), ledger, executor)
        workers = {int(m.reason) for m in table.values()}
        assert len(workers) <= 2
        assert os.getpid() not in workers
        for worker in workers:
            os.kill(worker, signal.SIGKILL)
        # Killed while idle: nobody's result is lost, nobody is blamed; nor where one call meets all of them, each of
        # which seemed to be alive when it was taken.
        seemed, ready = [False, True] * len(workers), WorkerProcess.ready.fget
        monkeypatch.setattr(WorkerProcess, "ready", property(lambda one: seemed.pop() if seemed else ready(one)))
        (found,) = run_cases(
            tasks.substitute_task(CELLS[:1], tasks.count_processes), ledger, executor, fresh=True
        ).values()
        assert found.outcome == "completed"
        assert int(found.reason) not in workers


def test_invalid_cell_raises_and_finished_cells_are_kept(ledger: Ledger) -> None:
    with LocalProcesses(2) as executor, pytest.raises(InvalidInput, match="cannot be run"):
        run_cases(tasks.substitute_task(CELLS, tasks.refuse), ledger, executor)
    kept = ledger.results({cell.key: cell for cell in CELLS})
    assert all(m.outcome == "completed" for m in kept.values())
    assert CELLS[tasks.CRASHES].key not in kept


@pytest.mark.parametrize("python", ["/bin/false", "/no/such/python"])
def test_a_process_that_cannot_start_is_no_outcome_of_a_cell(
    ledger: Ledger, monkeypatch: pytest.MonkeyPatch, python: str
) -> None:
    monkeypatch.setattr(sys, "executable", python)
    with LocalProcesses(1) as executor, pytest.raises(InvalidInput, match="cannot start"):
        run_cases(CELLS[:3], ledger, executor)
    assert ledger.finished_keys(c.key for c in CELLS) == set()


# -- interrupted and killed ------------------------------------------------------------------------------------------


def interrupt() -> None:
    raise KeyboardInterrupt


def test_interrupt_keeps_finished_cells_for_the_next_call(ledger: Ledger) -> None:
    watcher = ActingWatcher(5, interrupt)
    with pytest.raises(KeyboardInterrupt), LocalProcesses(2) as executor:
        run_cases(tasks.substitute_task(CELLS, tasks.echo), ledger, executor, watcher=watcher)
    kept = ledger.results({cell.key: cell for cell in CELLS})
    assert {tasks.number(c) for c in CELLS if c.key in kept} == set(watcher.seen)
    assert 5 <= len(kept) < 30
    rest = InProcessExecutor()
    table = run_cases(tasks.substitute_task(CELLS, tasks.echo), ledger, rest)
    assert len(rest.ran) == 30 - len(kept)
    assert [int(m.reason) for m in table.values()] == list(range(30))


def test_table_equals_undisturbed_one_after_a_kill_at_any_moment(tmp_path: Path) -> None:
    count, cells = 40, tasks.cells(40)
    with Ledger.open(tmp_path / "undisturbed") as ledger:
        undisturbed = run_cases(cells, ledger, InProcessExecutor())
        rows = list(ledger.rows())
    kept_before = 0
    for after in (3, 12):
        with tasks.cells_in_process(tmp_path / "killed", count) as running:
            assert len(list(islice(running.stdout, after))) == after
        with Ledger.open(tmp_path / "killed") as ledger:
            kept = len(ledger.finished_keys(cell.key for cell in cells))
        # Negative control: it was killed in the middle, not before and not after.
        assert kept_before < kept < count
        kept_before = kept
    with Ledger.open(tmp_path / "killed") as ledger, LocalProcesses(2) as executor:
        assert run_cases(cells, ledger, executor) == undisturbed
        assert list(ledger.rows()) == rows


def children(process: int) -> list[int]:
    found: list[int] = []
    for thread in Path(f"/proc/{process}/task").iterdir():
        with suppress(FileNotFoundError):  # the thread has ended meanwhile
            found += map(int, (thread / "children").read_text().split())
    return found


@pytest.mark.skipif(not Path("/proc/self/task").exists(), reason="needs /proc to see the processes")
def test_workers_end_with_a_killed_caller_even_when_they_hang(tmp_path: Path) -> None:
    with tasks.cells_in_process(tmp_path / "ledger", 8, "misbehave") as running:
        assert running.stdout.readline()
        workers = children(running.pid)
        assert workers
    give_up = time.monotonic() + 60.0
    while any(Path(f"/proc/{worker}").exists() for worker in workers) and time.monotonic() < give_up:
        time.sleep(0.05)
    assert not any(Path(f"/proc/{worker}").exists() for worker in workers)


# -- killed from outside -----------------------------------------------------------------------------------------------


def test_cell_is_repeated_alone_when_its_worker_is_killed(ledger: Ledger, tmp_path: Path) -> None:
    folder = tmp_path / "attempts"
    folder.mkdir()
    cells = tasks.name_by_folder(folder, tasks.cells(12))
    with LocalProcesses(3, timeout=60.0) as executor:
        table = run_cases(tasks.substitute_task(cells, tasks.die_at_first_attempt), ledger, executor)
    assert {(m.outcome, m.reason) for m in table.values()} == {("completed", str(k)) for k in range(12)}
    attempts = [(int(file.name.split("-")[0]), *map(float, file.read_text().split())) for file in folder.iterdir()]
    spans = {number: span for number, *span in attempts if span[1] < math.inf}
    assert (len(attempts), len(spans)) == (12 + len(tasks.KILLS), 12)
    for killed in tasks.KILLS:
        begin, end = spans[killed]
        assert all(last <= begin or first >= end for number, (first, last) in spans.items() if number != killed)


def test_what_is_isolated_is_repeated_once(tmp_path: Path) -> None:
    assert call_isolated(die_and_return, tmp_path, 1) == "done"
    assert call_on_file(die_and_return, tmp_path, 1) == "done"
    assert len(list(tmp_path.iterdir())) == 3
    assert call_isolated(die_and_return, tmp_path, 1000) == FailedCall(Outcome.CRASHED, AGAIN)
    assert len(list(tmp_path.iterdir())) == 5


# -- processes on one ledger -------------------------------------------------------------------------------------------

COUNT, CLAIMED = 24, 4  # of them, by a process of one job whose runs take long


def sharing(folder: Path, own: str, others: str, **environment: str) -> Any:
    """A process that runs all cells on the ledger of a folder, from when another one does, too."""
    notes = {"CONROD_STARTS": str(folder / own), "CONROD_OTHER_STARTS": str(folder / others)}
    return tasks.cells_in_process(folder / "ledger", COUNT, "note_start", 1, **notes, **environment)


def starts(folder: Path) -> Counter[int]:
    notes = [folder / own for own in ("a", "b") if (folder / own).exists()]
    return Counter(int(k) for note in notes for k in note.read_text(encoding="ascii").split())


@pytest.mark.parametrize("selfish", [False, pytest.param(True, marks=pytest.mark.slow)])
def test_two_processes_run_each_cell_once_and_both_have_all(selfish: bool, tmp_path: Path) -> None:
    how = {"CONROD_SELFISH": "yes"} if selfish else {}
    with ExitStack() as both:
        pair = [both.enter_context(sharing(tmp_path, *names, **how)) for names in (("a", "b"), ("b", "a"))]
        said = [running.communicate(timeout=120)[0].splitlines() for running in pair]
    assert said[0][-1] == said[1][-1] == str([str(k) for k in range(COUNT)])
    assert starts(tmp_path).keys() == set(range(COUNT))
    assert (starts(tmp_path).total() > COUNT) is selfish
    done = [Counter(lines[:-1]) for lines in said]
    assert [found.total() for found in done] == [COUNT, COUNT]
    # Both took part.
    assert min(found["completed"] for found in done) > 0
    assert selfish or done[0]["completed"] + done[1]["completed"] == COUNT


def test_what_a_killed_process_had_claimed_the_other_runs(tmp_path: Path) -> None:
    with sharing(tmp_path, "a", "a", CONROD_HANGS="yes") as hanging:
        while not starts(tmp_path):
            assert hanging.poll() is None
        with sharing(tmp_path, "b", "a") as other:
            assert list(islice(other.stdout, COUNT - CLAIMED)) == ["completed\n"] * (COUNT - CLAIMED)
            # The rest is claimed: it waits, and runs none of it.
            with pytest.raises(subprocess.TimeoutExpired):
                other.wait(5 * POLL_INTERVAL)
            assert starts(tmp_path).total() == COUNT - CLAIMED + 1
            hanging.kill()
            said = other.communicate(timeout=120)[0].splitlines()
    assert said == [*["completed"] * CLAIMED, str([str(k) for k in range(COUNT)])]
    assert starts(tmp_path).total() == COUNT + 1
