"""Four kinds of fault among many real runs: each costs its own cell and no other."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Callable
from typing import Any

import cell_tasks
import planted_faults as planted
import pytest
from planted_faults import ENDS, JOBS, MEMORY, TIMEOUT, run_with_faults

from conrod import MuJoCoSettings
from conrod.runs.plain import plain
from conrod.studies.execution.dispatch import run_cases
from conrod.studies.execution.local import LocalProcesses
from conrod.studies.execution.worker import perform
from conrod.studies.execution.worker_process import Limits, WorkerProcess
from conrod.studies.frame.ledger import Ledger
from conrod.studies.frame.measurement import Measurement
from conrod.studies.frame.run import measure
from conrod.studies.limits.case import Declaration, LimitCase


@pytest.fixture
def started(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """Process ids of all workers that are started."""
    start, ids = WorkerProcess.__init__, []

    def counted(worker: WorkerProcess, limits: Limits) -> None:
        start(worker, limits)
        ids.append(worker._process.pid)

    monkeypatch.setattr(WorkerProcess, "__init__", counted)
    return ids


def as_kept(measurement: Measurement) -> Measurement:
    """As a file gives it back: tuples are lists."""
    return Measurement(**json.loads(json.dumps(plain(measurement))))


# A faster sibling, with planted faults instead of real ones, is in test_execution.py.
@pytest.mark.slow
@pytest.mark.parametrize(("count", "each"), [(80, 1), (1000, 4)])
def test_each_fault_costs_its_own_cell_and_no_other(ledger: Ledger, started: list[int], count: int, each: int) -> None:
    undisturbed = planted.runs(count)
    cells, faults = planted.with_faults(undisturbed, each)
    table = run_with_faults(ledger, cells)
    # None lost: what came back is in the file, one result for each cell.
    keys = [cell.key for cell in cells]
    assert len(set(keys)) == count
    assert table == ledger.measurements(keys)
    assert list(table) == keys
    # None wrong: the faulty ones by the name of what ended them, the others as in a process that nothing happened to.
    assert {key: (table[key].outcome, table[key].reason) for key in faults} == {
        key: ENDS[kind] for key, kind in faults.items()
    }
    assert Counter(faults.values()) == dict.fromkeys(ENDS, each)
    # The limits that ended cells are kept with them: with more they would run again, and the others would not.
    limits = {"hang": ("timed-out", TIMEOUT), "hoard": ("out-of-memory", MEMORY)}
    assert ledger.stopped(table) == {key: limits[kind] for key, kind in faults.items() if kind in limits}
    sound = [cell for cell in undisturbed if cell.key not in faults and cell.key in table]
    assert len(sound) == count - len(faults)
    assert {cell.key: table[cell.key] for cell in sound} == {cell.key: as_kept(planted.usual(cell)) for cell in sound}
    assert {table[cell.key].outcome for cell in sound} == {"completed"}
    # Workers are used again until one dies. (The last to die, with nothing left to do, need no successor.)
    assert len(faults) <= len(started) <= JOBS + len(faults)
    assert len(set(started)) == len(started)


@pytest.mark.slow
def test_runs_without_a_fault_need_no_more_processes_than_jobs(ledger: Ledger, started: list[int]) -> None:
    # Negative control for the count: nobody dies, nobody is replaced.
    table = run_with_faults(ledger, planted.runs(20))
    assert {m.outcome for m in table.values()} == {"completed"}
    assert len(started) == JOBS


def test_an_engines_abort_in_a_sweep_is_the_outcome_of_its_cell(ledger: Ledger) -> None:
    sound = cell_tasks.cells(8)
    cells = planted.unlucky(sound, 5)
    with LocalProcesses(JOBS) as executor:
        table = run_cases(cells, ledger, executor)
    assert (table[cells[5].key].outcome, table[cells[5].key].reason) == ENDS[planted.ABORT]
    others = [cell for cell in sound if cell is not sound[5]]
    assert {cell.key: table[cell.key] for cell in others} == {cell.key: measure(cell) for cell in others}


def limit_cells() -> dict[str, LimitCase]:
    saw = planted.SAW
    mechanism = saw.mechanism()
    turned = Declaration(
        tuple(body.name for body in reversed(mechanism.bodies)), tuple(joint.name for joint in mechanism.joints)
    )
    return {
        "pymunk": LimitCase("saw", saw, planted.SETTINGS[0]),
        "mujoco": LimitCase("saw", saw, MuJoCoSettings.tuned(saw, 100)),
        "declared in another order": LimitCase("saw", saw, MuJoCoSettings.tuned(saw, 100), declaration=turned),
        "five steps a revolution": LimitCase("saw", saw, MuJoCoSettings.tuned(saw, 5)),
    }


def test_a_run_at_an_engines_limits_is_the_same_in_a_worker_process(ledger: Ledger) -> None:
    cells: Any = limit_cells()
    with LocalProcesses(1, cell_memory=MEMORY) as executor:
        table = run_cases(list(cells.values()), ledger, executor)
    assert table == {cell.key: as_kept(perform(cell)) for cell in cells.values()}
    assert {name: table[cell.key].outcome for name, cell in cells.items()} == {
        "pymunk": "completed",
        "mujoco": "completed",
        "declared in another order": "completed",
        "five steps a revolution": "opened",
    }


# -- engines that are given no memory say so in their own ways -------------------------------------------------------


@pytest.mark.parametrize("megabytes", [3, 16])
def test_an_engine_that_is_given_no_memory_is_out_of_memory_however_it_says_so(megabytes: int) -> None:
    # With 3 MB MuJoCo's library cannot be loaded (ImportError), with 16 its compiler gives up (ValueError).
    with LocalProcesses(1, cell_memory=MEMORY) as executor, pytest.raises(MemoryError, match="3000000000 bytes"):
        executor.submit(planted.engine_with_little, megabytes).result()


def test_an_engine_that_is_given_enough_is_not() -> None:
    with LocalProcesses(1, cell_memory=MEMORY) as executor:
        assert executor.submit(planted.engine_with_little, 256).result().outcome == "completed"


@pytest.mark.parametrize(
    ("task", "kind"), [(planted.mistake_with_little, ZeroDivisionError), (planted.wrong_value, ValueError)]
)
def test_a_mistake_under_a_memory_limit_is_a_mistake(task: Callable[[int], Measurement], kind: type[Exception]) -> None:
    with LocalProcesses(1, cell_memory=MEMORY) as executor, pytest.raises(kind, match="a mistake"):
        executor.submit(task, 16).result()
