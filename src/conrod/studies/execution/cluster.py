"""Calls on a Dask cluster; nothing is shared with it, and only the caller writes the ledger."""

from __future__ import annotations

import pickle
import threading
import time
from collections.abc import Callable
from concurrent.futures import CancelledError
from queue import SimpleQueue
from typing import Any, TypeVar

from conrod.errors import InvalidInput
from conrod.studies.execution import cluster_connection as cluster_worker
from conrod.studies.execution.cluster_connection import connected, one_line
from conrod.studies.execution.local import RepeatingExecutor
from conrod.studies.execution.worker_process import KilledFromOutside, Limits

Result = TypeVar("Result")

PATIENCE = 10.0  # [s] for an answer
GRACE = 60.0  # [s] without any worker
LOOK = 0.5  # [s] between two looks at the workers
# Calls handed over for each thread of the cluster, and at least: no worker waits for the way there and back.
PER_THREAD, LEAST_IN_FLIGHT, MOST_IN_FLIGHT = 4, 32, 8192


class DaskCluster(RepeatingExecutor):
    """An executor on the workers of a Dask scheduler.

    Each call runs in a process of its own beside its Dask worker, with the same limits and outcomes as on this machine.
    Calls of a worker that dies run again elsewhere. One that kills worker after worker, or whose process is killed from
    outside, and again with nothing beside it, ends as WorkerDied. InvalidInput where the cluster fails: without workers
    for long, gone, or without the same conrod.
    """

    def __init__(
        self,
        address: str,
        *,
        cell_timeout: float | None = None,
        cell_memory: int | None = None,
        patience: float = PATIENCE,
        grace: float = GRACE,
    ) -> None:
        """Connect.

        Args:
            address: of the scheduler, such as tcp://192.168.0.7:8786.
            cell_timeout: longest wall time of a call [s], from when its process begins with it.
            cell_memory: largest address space of that process [bytes].
            patience: how long to wait for the scheduler's answer [s].
            grace: how long to go on without any worker [s].

        Raises:
            InvalidInput: Dask is not installed, no scheduler answers, or versions do not match.
        """
        super().__init__(Limits(cell_timeout, cell_memory), LEAST_IN_FLIGHT, MOST_IN_FLIGHT)
        self._address, self._patience, self._grace = address, patience, grace
        self._client = connected(address, patience)
        self._lock = threading.Lock()
        # What each call waits for, an error or None where Dask has its answer; and Dask's own future of the call.
        self._waiting: dict[SimpleQueue[Exception | None], Any] = {}
        self._lost: Exception | None = None
        self._closed = threading.Event()
        self._watch = threading.Thread(target=self._watch_workers, name="conrod-cluster", daemon=True)
        self._watch.start()

    def _call(self, alone: bool, function: Callable[..., Result], *arguments: Any, **named: Any) -> Result:
        call = pickle.dumps((function, arguments, named))
        arrived = SimpleQueue[Exception | None]()
        with self._lock:
            if self._lost is not None:
                raise self._lost
            # Not pure: the same call may run again with `fresh`.
            remote = self._client.submit(
                cluster_worker.answer, call, self.limits, cluster_worker.identities(arguments), pure=False
            )
            self._waiting[arrived] = remote
        remote.add_done_callback(lambda _: arrived.put(None))
        error = arrived.get()
        with self._lock:
            del self._waiting[arrived]
        if error is not None:
            raise error
        returned, content = self._answer(remote)
        if not returned:
            raise content
        result: Result = content
        return result

    def _answer(self, remote: Any) -> tuple[bool, Any]:
        from distributed import KilledWorker

        try:
            answer: tuple[bool, Any] = remote.result()
        except KilledWorker as error:
            # Dask blames all calls that a dead worker had.
            died = f"{error.allowed_failures + 1} workers of the cluster died, one after another, of it"
            raise KilledFromOutside(died) from None
        except CancelledError:
            raise InvalidInput(f"lost the connection to the cluster at {self._address}") from None
        except Exception as error:  # Dask unpickles on its workers: what it raises there has no type of its own
            why = f"the cluster at {self._address} cannot run conrod: {one_line(error)}; install the same conrod there"
            raise InvalidInput(why) from None
        return answer

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """Let calls finish or cancel them; then leave the cluster as it is."""
        super().shutdown(wait, cancel_futures=cancel_futures)
        self._client.close(timeout=self._patience)

    def _stop(self) -> None:
        self._closed.set()
        self._give_up(CancelledError())
        self._watch.join()

    def _watch_workers(self) -> None:
        """Learn how many threads there are, and give up where there are none for long."""
        seen = time.monotonic()
        while not self._closed.wait(LOOK):
            try:
                threads = sum(self._client.nthreads(callback_timeout=self._patience).values())
            except (OSError, RuntimeError, TimeoutError):
                threads = 0  # while it reconnects; a lost scheduler ends every call by itself
            if threads:
                seen = time.monotonic()
                self.in_flight = min(max(LEAST_IN_FLIGHT, PER_THREAD * threads), MOST_IN_FLIGHT)
            elif time.monotonic() - seen > self._grace:
                failed = f"has had no worker, or given no answer, for {self._grace:g} s"
                self._give_up(InvalidInput(f"the cluster at {self._address} {failed}"))

    def _give_up(self, error: Exception) -> None:
        with self._lock:
            self._lost = error
            calls = dict(self._waiting)
        for arrived in calls:
            arrived.put(error)
        # A client that has no scheduler any more would wait for it.
        if calls and self._client.status == "running":
            self._client.cancel(list(calls.values()))
