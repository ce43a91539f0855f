"""A real Dask scheduler with two real workers gives the local table, also when one of them is killed."""

from __future__ import annotations

import logging
import os
import signal
import socket
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import cell_tasks as tasks
import pytest
from cell_tasks import ActingWatcher

from conrod import InvalidInput
from conrod.execution import cluster as dask_cluster
from conrod.execution.cluster import DaskCluster
from conrod.execution.ledger import Ledger
from conrod.execution.local import LocalProcesses
from conrod.execution.runner import run_cases

distributed = pytest.importorskip("distributed", reason="the extra conrod[cluster] is not installed")


@pytest.fixture
def cluster(tmp_path: Path) -> Iterator[Any]:
    """A scheduler and two workers of one thread, each a process of its own, on the loopback interface."""
    options = {"host": "127.0.0.1", "dashboard_address": None, "local_directory": str(tmp_path / "dask")}
    with distributed.LocalCluster(n_workers=2, threads_per_worker=1, **options) as running:
        yield running


def test_table_equals_the_local_one_when_one_worker_is_killed(cluster: Any, tmp_path: Path) -> None:
    cells = tasks.cells(40)
    killed, lives = (worker.pid for worker in cluster.workers.values())
    killer = ActingWatcher(10, lambda: os.kill(killed, signal.SIGKILL))
    with (
        Ledger.open(tmp_path / "cluster") as ledger,
        DaskCluster(cluster.scheduler_address, timeout=60.0) as executor,
    ):
        table = run_cases(cells, ledger, executor, watcher=killer)
        rows = list(ledger.rows())
    # Negative control: it did die, and the other one lives.
    assert [Path(f"/proc/{process}").exists() for process in (killed, lives)] == [False, True]
    with Ledger.open(tmp_path / "local") as ledger, LocalProcesses(2) as local:
        assert run_cases(cells, ledger, local) == table
        assert list(ledger.rows()) == rows
    assert table[cells[0].key] == cells[0].perform()


@pytest.mark.slow
def test_outcomes_on_the_cluster_are_those_of_this_machine(cluster: Any, ledger: Ledger) -> None:
    limits: Any = {"timeout": tasks.TIMEOUT, "memory": tasks.MEMORY}
    with DaskCluster(cluster.scheduler_address, **limits) as executor:
        tasks.check_that_faults_cost_their_own_cells(20, ledger, executor)


@pytest.mark.slow
def test_cell_that_kills_workers_crashes_alone(cluster: Any, ledger: Ledger) -> None:
    cells = tasks.cells(12)
    with DaskCluster(cluster.scheduler_address) as executor:
        table = run_cases(tasks.substitute_task(cells, tasks.kill_dask_worker), ledger, executor)
    crashed = [tasks.number(cell) for cell in cells if table[cell.key].outcome == "crashed"]
    assert crashed == [tasks.CRASHES]
    assert "workers of the cluster died" in table[cells[tasks.CRASHES].key].reason
    assert sum(m.outcome == "completed" for m in table.values()) == 11


def test_a_cluster_that_is_not_there_is_one_line() -> None:
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        address = f"tcp://127.0.0.1:{free.getsockname()[1]}"
        with pytest.raises(InvalidInput, match=f"^no cluster answers at {address}.*$"):
            DaskCluster(address, patience=1.0)
    # Nor does Dask say anything of it.
    assert not any(
        logging.getLogger(name).isEnabledFor(logging.ERROR) for name in ("distributed", "distributed.client")
    )


@pytest.mark.slow
def test_a_worker_with_another_engine_version_runs_nothing(
    cluster: Any, ledger: Ledger, monkeypatch: pytest.MonkeyPatch
) -> None:
    def older(arguments: tuple[object, ...]) -> list[dict[str, object]]:
        return [{**told, "engine_version": "6.0"} for told in here(arguments)]

    here = dask_cluster.case_identities
    monkeypatch.setattr(dask_cluster, "case_identities", older)
    with (
        DaskCluster(cluster.scheduler_address) as executor,
        pytest.raises(InvalidInput, match=r"engine_version '7.* there and '6\.0' here; install the same versions"),
    ):
        run_cases(tasks.cells(3), ledger, executor)
    assert ledger.finished_keys(c.key for c in tasks.cells(3)) == set()
