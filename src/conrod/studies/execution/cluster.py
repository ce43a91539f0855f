"""Calls on a Dask cluster; nothing is shared with it, and only the caller writes the ledger.

A call has a process of its own beside its Dask worker, as on this machine. Retries on other workers, checks of versions
and certificates are Dask's own.
"""

from __future__ import annotations

import logging
import pickle
import platform
import re
import threading
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import CancelledError
from importlib.metadata import version
from typing import Any, TypeVar

from conrod.errors import InvalidInput
from conrod.studies.execution.local import LocalProcesses, RepeatingExecutor
from conrod.studies.execution.worker_process import KilledFromOutside, Limits, WorkerDied
from conrod.studies.frame.case import Case

Result = TypeVar("Result")

PATIENCE = 10.0  # [s] for an answer
# Calls handed over for each thread of the cluster, and at least: no worker waits for the way there and back.
PER_THREAD, LEAST_IN_FLIGHT, MOST_IN_FLIGHT = 4, 256, 8192


class DaskCluster(RepeatingExecutor):
    """An executor on the workers of a Dask scheduler, with the same limits and outcomes as on this machine.

    A call that kills worker after worker, or whose process is killed from outside, and again with nothing beside it,
    ends as WorkerDied. InvalidInput where the cluster is gone, or has another conrod. Workers may come and
    go; where there are none they are waited for.
    """

    def __init__(
        self,
        address: str,
        *,
        cell_timeout: float | None = None,
        cell_memory: int | None = None,
        patience: float = PATIENCE,
    ) -> None:
        """Connect.

        Args:
            address: of the scheduler, such as tcp://192.168.0.7:8786; for tls:// with Dask's configuration.
            cell_timeout, cell_memory: as of `LocalProcesses`.
            patience: how long to wait for the scheduler's answer [s].

        Raises:
            InvalidInput: the address is none, Dask is not installed, or no scheduler answers.
        """
        limits, client = Limits(cell_timeout, cell_memory), _connected(address, patience)
        there = PER_THREAD * sum(client.nthreads().values())
        in_flight = min(max(LEAST_IN_FLIGHT, there), MOST_IN_FLIGHT)
        super().__init__(limits, in_flight, in_flight)
        self._address, self._patience, self._client = address, patience, client
        self._waiting = set[Any]()  # Dask's own futures
        self._closed = False

    def call(self, function: Callable[..., Result], *arguments: Any, **named: Any) -> Result:
        from distributed import KilledWorker

        call = pickle.dumps((function, arguments, named))
        # Not pure: the same call may run again with `fresh`.
        remote = self._client.submit(answer, call, self.limits, identities(arguments), pure=False)
        self._waiting.add(remote)
        try:
            if self._closed:
                raise CancelledError
            returned, content = remote.result()
        except KilledWorker as error:
            # Dask blames all calls that a dead worker had.
            died = f"{error.allowed_failures + 1} workers of the cluster died, one after another, of it"
            raise KilledFromOutside(died, True) from None
        except CancelledError:
            raise InvalidInput(f"lost the connection to the cluster at {self._address}") from None
        except Exception as error:  # Dask unpickles on its workers: what it raises there has no type of its own
            why = f"the cluster at {self._address} cannot run conrod: {_one_line(error)}; install the same conrod there"
            raise InvalidInput(why) from None
        finally:
            self._waiting.discard(remote)
        if not returned:
            raise content
        result: Result = content
        return result

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """Let calls finish or cancel them; then leave the cluster as it is."""
        super().shutdown(wait, cancel_futures=cancel_futures)
        self._client.close(timeout=self._patience)

    def stop(self) -> None:
        self._closed = True
        # A client that has no scheduler any more would wait for it.
        if self._waiting and self._client.status == "running":
            self._client.cancel(list(self._waiting))


def _connected(address: str, patience: float) -> Any:
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
        return distributed.Client(address, timeout=patience, set_as_default=False)  # type: ignore[no-untyped-call]
    except (OSError, ValueError, ImportError, TypeError) as error:  # the last where tls:// has no certificates
        raise InvalidInput(f"no cluster answers at {address}: {_one_line(error.__cause__ or error)}") from None


def _one_line(error: BaseException) -> str:
    return " ".join(str(error).split()) or type(error).__name__


# -- on its workers ----------------------------------------------------------------------------------------------------

_lock = threading.Lock()
_processes: dict[Limits, LocalProcesses] = {}


def answer(call: bytes, limits: Limits, expected: Sequence[Mapping[str, Any]]) -> tuple[bool, Any]:
    """Return True and a call's result, or False and what it raised.

    Args:
        call: pickled function, arguments and named arguments. As bytes, because the scheduler would otherwise open it.
        expected: identities of the cells among the arguments, as the caller finds them.
    """
    try:
        function, arguments, named = pickle.loads(call)
        for there, here in zip(expected, identities(arguments), strict=True):
            for name in there:
                if here.get(name) != there[name]:
                    raise InvalidInput(
                        f"the cluster's worker on {platform.node()} would run another cell: {there['engine']} run with "
                        f"{name} {here.get(name)!r} there and {there[name]!r} here; install the same versions on both"
                    )
        with _lock:
            made = LocalProcesses(cell_timeout=limits.timeout, cell_memory=limits.memory)
            processes = _processes.setdefault(limits, made)
        return True, processes.call(function, *arguments, **named)
    except (InvalidInput, WorkerDied, KilledFromOutside, TimeoutError, MemoryError) as error:
        return False, error
    except Exception as error:  # the call's own, of whatever kind
        # Dask would open it while it unpickles the message; a caller without the module could not read even that.
        return False, RuntimeError(f"{type(error).__name__} on {platform.node()}: {error}")


def identities(arguments: Sequence[Any]) -> list[dict[str, Any]]:
    """Identities, on this machine, that determine the results of the cells among some arguments."""
    return [{"conrod": version("conrod"), **cell.identity()} for cell in arguments if isinstance(cell, Case)]
