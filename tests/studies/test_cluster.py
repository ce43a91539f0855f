"""A real Dask scheduler with two real workers gives the local table, also when one of them is killed."""

from __future__ import annotations

import json
import logging
import os
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import cell_tasks as tasks
import pytest

from conrod import InvalidInput
from conrod.studies.execution import cluster as dask_cluster
from conrod.studies.execution.cluster import DaskCluster
from conrod.studies.execution.dispatch import run_cases
from conrod.studies.execution.local import LocalProcesses
from conrod.studies.execution.worker_process import HOME
from conrod.studies.frame.ledger import Ledger
from conrod.studies.frame.run import RunCase, measure

distributed = pytest.importorskip("distributed", reason="the extra conrod[cluster] is not installed")


class Cluster:
    """A scheduler and workers of one thread on the loopback interface, at a free port."""

    def __init__(self, folder: Path, workers: int, *options: str) -> None:
        self.folder = folder
        told = folder / "scheduler.json"
        self.scheduler = self._started("scheduler", "--port", "0", "--scheduler-file", str(told))
        self.address = _address(told, self.scheduler)
        self.workers = [self._started("worker", self.address, "--nthreads", "1", *options) for _ in range(workers)]
        with distributed.Client(self.address, set_as_default=False) as client:
            client.wait_for_workers(workers)

    def _started(self, *arguments: str) -> subprocess.Popen[bytes]:
        environment = {
            **os.environ,
            "PYTHONPATH": os.pathsep.join((str(Path(__file__).parents[1] / "support"), HOME)),
            "DASK_TEMPORARY_DIRECTORY": str(self.folder),
        }
        command = [sys.executable, "-m", "dask", *arguments, "--host", "127.0.0.1", "--no-dashboard"]
        with (self.folder / "log.txt").open("ab") as log:
            return subprocess.Popen(command, env=environment, stdout=log, stderr=log, cwd=self.folder)

    def stop(self) -> None:
        for process in (*self.workers, self.scheduler):
            process.terminate()
        for process in (*self.workers, self.scheduler):
            try:
                process.wait(20.0)
            except subprocess.TimeoutExpired:
                process.kill()
                process.wait()


def _address(told: Path, scheduler: subprocess.Popen[bytes]) -> str:
    while scheduler.poll() is None:
        try:
            return str(json.loads(told.read_text())["address"])
        except (FileNotFoundError, json.JSONDecodeError):
            time.sleep(0.02)
    raise AssertionError(f"the scheduler ended with status {scheduler.returncode}")


@pytest.fixture(scope="module")
def cluster(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Cluster]:
    running = Cluster(tmp_path_factory.mktemp("cluster"), 2)
    yield running
    running.stop()


@pytest.fixture
def own_cluster(tmp_path: Path) -> Iterator[Cluster]:
    running = Cluster(tmp_path, 2, "--no-nanny")
    yield running
    running.stop()


class After:
    """Does something once, after so many results."""

    def __init__(self, count: int, then: threading.Event) -> None:
        self.count = count
        self.then = then

    def started(self, total: int, already_finished: int) -> None: ...

    def advanced(self, cell: RunCase, how: str) -> None:
        self.count -= 1
        if self.count == 0:
            self.then.set()


def kill_after(event: threading.Event, *processes: subprocess.Popen[bytes]) -> threading.Thread:
    def kill() -> None:
        event.wait()
        for process in processes:
            process.kill()

    thread = threading.Thread(target=kill, daemon=True)
    thread.start()
    return thread


# -- the same table --------------------------------------------------------------------------------------------------


def test_one_of_two_workers_is_killed_and_the_table_is_the_local_one(own_cluster: Cluster, tmp_path: Path) -> None:
    cells = tasks.cells(40)
    killed = threading.Event()
    with (
        Ledger.open(tmp_path / "cluster") as ledger,
        DaskCluster(own_cluster.address, cell_timeout=60.0) as executor,
    ):
        kill_after(killed, own_cluster.workers[0])
        table = run_cases(cells, ledger, executor, watcher=After(10, killed))
        rows = list(ledger.rows())
    # Negative control: it did die, and the other one lives.
    assert own_cluster.workers[0].wait() == -9
    assert own_cluster.workers[1].poll() is None
    with Ledger.open(tmp_path / "local") as ledger, LocalProcesses(2) as local:
        assert run_cases(cells, ledger, local) == table
        assert list(ledger.rows()) == rows
    assert table[cells[0].key] == measure(cells[0])


@pytest.mark.slow
def test_outcomes_on_the_cluster_are_those_of_this_machine(cluster: Cluster, tmp_path: Path) -> None:
    cells = tasks.cells(20)
    limits = {"cell_timeout": tasks.TIMEOUT, "cell_memory": tasks.MEMORY}
    with Ledger.open(tmp_path / "cluster") as ledger, DaskCluster(cluster.address, **limits) as executor:  # type: ignore[arg-type]
        there = run_cases(tasks.assigned(cells, tasks.misbehave), ledger, executor)
        stopped = ledger.stopped(there)
    with Ledger.open(tmp_path / "local") as ledger, LocalProcesses(2, **limits) as local:  # type: ignore[arg-type]
        assert run_cases(tasks.assigned(cells, tasks.misbehave), ledger, local) == there
        assert ledger.stopped(there) == stopped
    assert {m.outcome for m in there.values()} == {"completed", "crashed", "timed-out", "out-of-memory"}


@pytest.mark.slow
def test_a_cell_that_kills_worker_after_worker_has_crashed_and_no_other_is_blamed(
    cluster: Cluster, ledger: Ledger
) -> None:
    cells = tasks.cells(12)
    with DaskCluster(cluster.address) as executor:
        table = run_cases(tasks.assigned(cells, tasks.kill_dask_worker), ledger, executor)
    crashed = [tasks.number(cell) for cell in cells if table[cell.key].outcome == "crashed"]
    assert crashed == [tasks.CRASHES]
    assert "workers of the cluster died" in table[cells[tasks.CRASHES].key].reason
    assert sum(m.outcome == "completed" for m in table.values()) == 11


# -- a cluster that fails --------------------------------------------------------------------------------------------


def refusal(address: str) -> str:
    with pytest.raises(InvalidInput) as told:
        DaskCluster(address, patience=1.0)
    assert "\n" not in str(told.value)
    return str(told.value)


# -- addresses -------------------------------------------------------------------------------------------------------


def test_a_cluster_that_is_not_there_is_one_line() -> None:
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        address = f"tcp://127.0.0.1:{free.getsockname()[1]}"
        assert f"no cluster answers at {address}" in refusal(address)
    # Nor does Dask say anything of it.
    assert not any(
        logging.getLogger(name).isEnabledFor(logging.ERROR) for name in ("distributed", "distributed.client")
    )


@pytest.mark.slow
def test_a_worker_with_another_engine_version_runs_nothing(
    cluster: Cluster, ledger: Ledger, monkeypatch: pytest.MonkeyPatch
) -> None:
    def older(arguments: tuple[object, ...]) -> list[dict[str, object]]:
        return [{**told, "engine_version": "6.0"} for told in here(arguments)]

    here = dask_cluster.identities
    monkeypatch.setattr(dask_cluster, "identities", older)
    with (
        DaskCluster(cluster.address) as executor,
        pytest.raises(InvalidInput, match=r"engine_version '7.* there and '6\.0' here; install the same versions"),
    ):
        run_cases(tasks.cells(3), ledger, executor)
    assert ledger.finished(c.key for c in tasks.cells(3)) == set()
