"""Cells on a Dask cluster; nothing is shared with it, and only the caller writes the ledger."""

from __future__ import annotations

import pickle
import threading
import time
from collections.abc import Callable
from concurrent.futures import CancelledError, Executor, Future
from dataclasses import dataclass
from types import TracebackType
from typing import Any, ParamSpec, TypeVar

from conrod.errors import InvalidInput
from conrod.studies.execution import cluster_connection as cluster_worker
from conrod.studies.execution.child import KilledFromOutside
from conrod.studies.execution.cluster_connection import connected, one_line
from conrod.studies.execution.worker_process import Limits, WorkerDied, killed_again

Arguments = ParamSpec("Arguments")
Result = TypeVar("Result")

PATIENCE = 10.0  # [s] for an answer
GRACE = 60.0  # [s] without any worker
LOOK = 0.5  # [s] between two looks at the workers
# Cells handed over for each thread of the cluster, and at least: no worker waits for the way there and back.
PER_THREAD, LEAST_IN_FLIGHT = 4, 32


@dataclass
class _Call:
    """A call under way: what to send for it, where it is on the cluster, and whether it runs there alone."""

    payload: tuple[Any, ...]
    remote: Any = None
    alone: bool = False


class DaskCluster(Executor):
    """An executor on the workers of a Dask scheduler.

    Each call runs in a process of its own beside its Dask worker, with the same limits and outcomes as on this machine.
    Calls of a worker that dies run again elsewhere. One that kills worker after worker, or whose process is killed from
    outside, and again with nothing beside it, ends as WorkerDied.
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
        self.limits = Limits(cell_timeout, cell_memory)
        self.in_flight = LEAST_IN_FLIGHT
        self._address, self._grace = address, grace
        self._patience = patience
        self._client = connected(address, patience)
        self._lock = threading.RLock()
        self._calls: dict[Future[Any], _Call] = {}
        self._suspects: list[tuple[Future[Any], _Call]] = []
        self._held: list[tuple[Future[Any], _Call]] = []  # while a suspect is to be alone
        self._closed = threading.Event()
        self._watch = threading.Thread(target=self._watch_workers, name="conrod-cluster", daemon=True)
        self._watch.start()

    def submit(
        self, fn: Callable[Arguments, Result], /, *args: Arguments.args, **kwargs: Arguments.kwargs
    ) -> Future[Result]:
        """The future of a call.

        It raises InvalidInput where the cluster fails: without workers for long, gone, or without the same conrod.
        """
        future: Future[Result] = Future()
        payload = (pickle.dumps((fn, args, kwargs)), self.limits, cluster_worker.identities(args))
        with self._lock:
            if any(call.alone for call in self._calls.values()):
                self._held.append((future, _Call(payload)))
            else:
                self._send(future, _Call(payload))
        future.add_done_callback(self._forget_cancelled)
        return future

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """Let calls finish or cancel them; then leave the cluster as it is."""
        with self._lock:
            pending = [*self._calls, *(future for future, _ in (*self._suspects, *self._held))]
        # Those that wait first: they are not to be sent when what they wait for is cancelled.
        for future in reversed(pending):
            if cancel_futures:
                future.cancel()
            elif wait:
                future.exception()
        self._closed.set()
        if wait:
            self._watch.join()
        self._client.close(timeout=self._patience)

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None
    ) -> bool | None:
        self.shutdown(wait=True, cancel_futures=error is not None)
        return None

    # -- a call's way ------------------------------------------------------------------------------------------------

    def _send(self, future: Future[Any], call: _Call) -> None:
        with self._lock:
            self._calls[future] = call
            # Not pure: the same call may run again with `fresh`.
            call.remote = self._client.submit(cluster_worker.answer, *call.payload, pure=False)
        call.remote.add_done_callback(lambda remote: self._arrived(future, remote))

    def _arrived(self, future: Future[Any], remote: Any) -> None:
        """In Dask's thread: a call ended, one way or another."""
        from distributed import KilledWorker

        try:
            returned, content = remote.result()
        except KilledWorker as error:
            again = f"{error.allowed_failures + 1} workers of the cluster died, one after another, of it"
            self._suspect(future, WorkerDied(again))
        except CancelledError:
            # Its reason is known where it was cancelled; otherwise the scheduler is gone.
            self._settle(future, False, InvalidInput(f"lost the connection to the cluster at {self._address}"))
        except Exception as error:
            why = f"the cluster at {self._address} cannot run conrod: {one_line(error)}; install the same conrod there"
            self._settle(future, False, InvalidInput(why))
        else:
            if isinstance(content, KilledFromOutside) and not returned:
                self._suspect(future, killed_again(content))
            else:
                self._settle(future, returned, content)

    def _settle(self, future: Future[Any], returned: bool, content: Any) -> None:
        with self._lock:
            mine = self._calls.pop(future, None) is not None and future.set_running_or_notify_cancel()
        if mine and returned:
            future.set_result(content)
        elif mine:
            future.set_exception(content)
        self._send_waiting()

    def _forget_cancelled(self, future: Future[Any]) -> None:
        if not future.cancelled():
            return
        with self._lock:
            call = self._calls.pop(future, None)
        if call is not None:
            self._drop(call)
        self._send_waiting()

    # -- calls that may have killed their workers --------------------------------------------------------------------

    def _suspect(self, future: Future[Any], verdict: Exception) -> None:
        """Try a call again with nothing beside it: Dask blames all calls that a dead worker had.

        Args:
            verdict: what the call ends with if it was alone already.
        """
        with self._lock:
            call = self._calls.get(future)
            if call is not None and not call.alone:
                del self._calls[future]
                self._suspects.append((future, call))
        if call is not None and call.alone:
            self._settle(future, False, verdict)
        self._send_waiting()

    def _send_waiting(self) -> None:
        """Send what waits for the cluster to have nothing to do."""
        with self._lock:
            self._suspects = [(f, call) for f, call in self._suspects if not f.cancelled()]
            if self._calls or self._client.status != "running":
                return
            held, self._held = self._held, []
            for future, call in held:
                if not future.cancelled():
                    self._send(future, call)
            if self._suspects and not self._calls:
                future, call = self._suspects.pop(0)
                call.alone = True
                self._send(future, call)

    # -- the cluster itself ------------------------------------------------------------------------------------------

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
                self._send_waiting()
                self.in_flight = max(LEAST_IN_FLIGHT, PER_THREAD * threads)
            elif time.monotonic() - seen > self._grace:
                self._give_up(
                    InvalidInput(
                        f"the cluster at {self._address} has had no worker, or given no answer, for {self._grace:g} s"
                    )
                )

    def _give_up(self, error: InvalidInput) -> None:
        with self._lock:
            calls = {**self._calls, **dict(self._suspects), **dict(self._held)}
            self._calls, self._suspects, self._held = {}, [], []
        for future, call in calls.items():
            if future.set_running_or_notify_cancel():
                future.set_exception(error)
            self._drop(call)

    def _drop(self, call: _Call) -> None:
        # A client that has no scheduler any more would wait for it.
        if call.remote is not None and self._client.status == "running":
            call.remote.cancel()
