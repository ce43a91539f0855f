"""A process killed from outside says nothing of the engine: its cell is repeated, alone, before that is believed."""

from __future__ import annotations

import os
import signal
import time
from pathlib import Path

import cell_tasks as tasks
import pytest
from failure_examples import BoundedCase
from outside_kills import grandchild, killing, waiting_cell, was_alone

from conrod import PymunkSettings, Saw
from conrod.runs.trajectory import Outcome
from conrod.studies.execution.dispatch import run_cases
from conrod.studies.execution.local import Ended, LocalProcesses, confined, isolated
from conrod.studies.frame.ledger import Ledger

pytestmark = pytest.mark.skipif(not Path("/proc/self/task").exists(), reason="needs /proc to see the processes")

SAW = Saw()
AGAIN = "ended by signal SIGKILL, and again with nothing beside it"


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    made = tmp_path / "attempts"
    made.mkdir()
    return made


@pytest.mark.parametrize("how", [signal.SIGKILL, pytest.param(signal.SIGTERM, marks=pytest.mark.slow)])
def test_a_cell_whose_worker_is_killed_is_repeated_alone(ledger: Ledger, folder: Path, how: signal.Signals) -> None:
    cells = tasks.kept_in(folder, tasks.cells(12))
    with killing(waiting_cell(folder), how) as killed, LocalProcesses(3, cell_timeout=60.0) as executor:
        table = run_cases(tasks.assigned(cells, tasks.wait_for_a_kill), ledger, executor)
    assert killed
    assert {(m.outcome, m.reason) for m in table.values()} == {("completed", str(k)) for k in range(12)}
    assert ledger.measurements(table) == table
    assert was_alone(folder, *killed)


def test_a_cell_that_ends_so_twice_has_crashed_and_no_other_has(ledger: Ledger) -> None:
    cells = tasks.cells(8)
    with LocalProcesses(2) as executor:
        table = run_cases(tasks.assigned(cells, tasks.kill_itself), ledger, executor)
    crashed = {tasks.number(cell): table[cell.key].reason for cell in cells if table[cell.key].outcome == "crashed"}
    assert crashed == {tasks.CRASHES: AGAIN}
    assert sum(m.outcome == "completed" for m in table.values()) == 7


def test_a_cell_that_runs_in_a_process_of_its_workers_is_repeated_too(ledger: Ledger) -> None:
    cell = BoundedCase("saw-500rpm", SAW, PymunkSettings.tuned(SAW, 100), revolutions=2.0)
    with killing(grandchild) as killed, LocalProcesses(1) as executor:
        table = run_cases([cell], ledger, executor)
    assert killed
    assert [m.outcome for m in table.values()] == ["completed"]


def wait_once(mark: Path, times: int) -> str:
    """Dies as often of a SIGKILL, then returns."""
    before = len(list(mark.iterdir()))
    (mark / str(before)).touch()
    if before < times:
        os.kill(os.getpid(), signal.SIGKILL)
    return "done"


def test_what_is_isolated_is_repeated_once(folder: Path) -> None:
    assert isolated(wait_once, folder, 1) == "done"
    assert confined(wait_once, folder, 1) == "done"
    assert len(list(folder.iterdir())) == 3
    assert isolated(wait_once, folder, 1000) == Ended(Outcome.CRASHED, AGAIN)
    assert len(list(folder.iterdir())) == 5


def test_what_a_limit_ends_is_not_killed_from_outside() -> None:
    # Negative control: conrod's own SIGKILL is an outcome at once.
    begin = time.monotonic()
    ended = isolated(time.sleep, 1000.0, timeout=1.0)
    assert isinstance(ended, Ended)
    assert ended.outcome is Outcome.TIMED_OUT
    assert time.monotonic() - begin >= 1.0
