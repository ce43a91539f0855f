"""Calls on a Dask cluster; nothing is shared with it, and only the caller writes the ledger.

A call has a process of its own beside its Dask worker, as on this machine.
"""

from __future__ import annotations

import asyncio
import logging
import pickle
import platform
import re
import threading
import time
import warnings
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import CancelledError, ThreadPoolExecutor
from importlib.metadata import version
from queue import SimpleQueue
from typing import Any, TypeVar

from conrod.errors import InvalidInput
from conrod.studies.execution.local import RepeatingExecutor
from conrod.studies.execution.worker_process import KilledFromOutside, Limits, WorkerDied, WorkerProcesses
from conrod.studies.frame.case import Case

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
        self._client = _connected(address, patience)
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
            remote = self._client.submit(answer, call, self.limits, identities(arguments), pure=False)
            self._waiting[arrived] = remote
        remote.add_done_callback(lambda _: arrived.put(None))
        error = arrived.get()
        with self._lock:
            del self._waiting[arrived]
        if error is not None:
            raise error
        returned, content = self._arrived(remote)
        if not returned:
            raise content
        result: Result = content
        return result

    def _arrived(self, remote: Any) -> tuple[bool, Any]:
        from distributed import KilledWorker

        try:
            found: tuple[bool, Any] = remote.result()
        except KilledWorker as error:
            # Dask blames all calls that a dead worker had.
            died = f"{error.allowed_failures + 1} workers of the cluster died, one after another, of it"
            raise KilledFromOutside(died) from None
        except CancelledError:
            raise InvalidInput(f"lost the connection to the cluster at {self._address}") from None
        except Exception as error:  # Dask unpickles on its workers: what it raises there has no type of its own
            why = f"the cluster at {self._address} cannot run conrod: {_one_line(error)}; install the same conrod there"
            raise InvalidInput(why) from None
        return found

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


# -- on its workers ----------------------------------------------------------------------------------------------------

_lock = threading.Lock()
_processes: dict[Limits, WorkerProcesses] = {}


def answer(call: bytes, limits: Limits, expected: Sequence[Mapping[str, Any]]) -> tuple[bool, Any]:
    """Return True and a call's result, or False and what it raised.

    The call goes through a process of its own, so that what a cell does to its process costs neither this worker nor
    the cells beside it, and takes its time limit from its own start.

    Args:
        call: pickled function, arguments and named arguments. As bytes, because the scheduler would otherwise open it.
        expected: identities of the cells among the arguments, as the caller finds them.
    """
    try:
        function, arguments, named = pickle.loads(call)
        _check(expected, identities(arguments))
        return True, _workers(limits).call(function, *arguments, **named)
    except (InvalidInput, WorkerDied, TimeoutError, MemoryError) as error:
        return False, error
    except Exception as error:  # the call's own, of whatever kind
        # Dask would open it while it unpickles the message; a caller without the module could not read even that.
        return False, RuntimeError(f"{type(error).__name__} on {platform.node()}: {error}")


def identities(arguments: Sequence[Any]) -> list[dict[str, Any]]:
    """Identities, on this machine, that determine the results of the cells among some arguments."""
    versions = {"conrod": version("conrod")}
    return [{**versions, **cell.identity()} for cell in arguments if isinstance(cell, Case)]


def _check(expected: Sequence[Mapping[str, Any]], found: Sequence[Mapping[str, Any]]) -> None:
    for there, here in zip(expected, found, strict=True):
        for name in there:
            if here.get(name) != there[name]:
                raise InvalidInput(
                    f"the cluster's worker on {platform.node()} would run another cell: {there['engine']} run with "
                    f"{name} {here.get(name)!r} there and {there[name]!r} here; install the same versions on both"
                )


def _workers(limits: Limits) -> WorkerProcesses:
    with _lock:
        return _processes.setdefault(limits, WorkerProcesses(limits))


# -- the connection ----------------------------------------------------------------------------------------------------


def _connected(address: str, patience: float) -> Any:
    """A Dask client of the scheduler at an address; for tls:// with the certificates of Dask's configuration.

    Args:
        patience: how long to wait for an answer [s].

    Raises:
        InvalidInput: the address is none, Dask is not installed, nothing answers, versions do not match, or a
            certificate is missing or of somebody else.
    """
    if not re.fullmatch(r"(tcp|tls)://[^/\s]+:\d{1,5}", address):
        raise InvalidInput(f"cluster {address!r}: give the scheduler's address, such as tcp://192.168.0.7:8786")
    try:
        import distributed
    except ImportError:
        raise InvalidInput("a cluster needs Dask: pip install 'conrod[cluster]'") from None
    # What Dask would log of a lost connection is said in one line by the error; each of these has a level of its own.
    for name in ("distributed", "distributed.client", "tornado.application"):
        logging.getLogger(name).setLevel(logging.CRITICAL)
    try:
        security: Any = distributed.Security()  # type: ignore[no-untyped-call]  # Dask has no types
        _greet(address, patience, security.get_connection_args("client"))
        with warnings.catch_warnings():
            # A difference that matters is refused below; Dask warns in a table of all that differs.
            warnings.simplefilter("ignore")
            client: Any = distributed.Client(address, timeout=patience, security=security, set_as_default=False)  # type: ignore[no-untyped-call]
    except (OSError, ValueError, ImportError, TypeError) as error:  # the last where tls:// has no certificates
        of = " with the certificates of Dask's configuration" if address.startswith("tls") else ""
        raise InvalidInput(f"no cluster answers at {address}{of}: {_one_line(error.__cause__ or error)}") from None
    try:
        check_versions(client.get_versions(), address)
    except BaseException:  # Ctrl-C, too: a client that is left open has threads that go on
        client.close()
        raise
    return client


def _greet(address: str, patience: float, connection: Mapping[str, Any]) -> None:
    """Ask who is there. Dask's client itself waits without end for one that accepts a connection and says nothing.

    Raises:
        OSError: nobody, or nobody who answers in time.
        ValueError: somebody else.
    """
    import distributed

    async def ask() -> Any:
        async with distributed.rpc(address, connection_args=connection) as there:  # type: ignore[no-untyped-call]
            return await asyncio.wait_for(there.identity(), patience)

    # In a thread of its own: a notebook's has a loop that runs already.
    with ThreadPoolExecutor(1) as aside:
        try:
            given = aside.submit(asyncio.run, ask()).result()
        except TimeoutError:
            raise TimeoutError(f"nothing for {patience:g} s") from None
    if given.get("type") != "Scheduler":
        raise ValueError(f"a {given.get('type')} is there, not a scheduler")


def check_versions(versions: Mapping[str, Any], address: str) -> None:
    """Refuse other versions of what carries cells to and fro; engines are compared cell by cell.

    Args:
        versions: of client, scheduler and workers, as Dask gives them.

    Raises:
        InvalidInput: names the package, the place and both versions.
    """
    here = _carriers(versions["client"])
    workers = {f"worker {place}": given for place, given in versions["workers"].items()}
    for place, given in {"scheduler": versions["scheduler"], **workers}.items():
        for package, found in _carriers(given).items():
            if found != here[package]:
                other = f"{package} {found} on its {place}, {here[package]} here"
                raise InvalidInput(f"the cluster at {address} has other versions: {other}")


def _carriers(given: Mapping[str, Any]) -> dict[str, str]:
    packages = {name: str(given["packages"][name]) for name in ("python", "dask", "distributed")}
    return packages | {"python": ".".join(packages["python"].split(".")[:2])}  # a patch release is no other


def _one_line(error: BaseException) -> str:
    return " ".join(str(error).split()) or type(error).__name__
