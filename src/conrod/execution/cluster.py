"""Calls on a Dask cluster, which shares no files with the caller.

Only the caller writes the ledger. A Dask worker makes each call in a separate process, as on this machine. Retries on
other workers, checks of versions and certificates are left to Dask.
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
from conrod.execution.case import Case
from conrod.execution.local import LocalProcesses, RetryingExecutor
from conrod.execution.worker_process import CallLimits, KilledFromOutside, WorkerDied

Result = TypeVar("Result")

ANSWER_TIMEOUT = 10.0  # [s], for an answer of the scheduler
# Calls submitted per thread of the cluster, and limits of their number: no worker waits for the network.
CALLS_PER_THREAD, MIN_IN_FLIGHT, MAX_IN_FLIGHT = 4, 256, 8192


class DaskCluster(RetryingExecutor):
    """An executor on the workers of a Dask scheduler, with the limits of a local executor.

    A call that kills worker after worker, or whose process is killed from outside twice, the second time alone, ends
    as WorkerDied. A call raises InvalidInput if the cluster is gone or has another conrod. Workers may come and go;
    while there are none, calls wait.
    """

    def __init__(
        self,
        address: str,
        *,
        timeout: float | None = None,
        memory: int | None = None,
        patience: float = ANSWER_TIMEOUT,
    ) -> None:
        """Connect to the scheduler.

        Args:
            address: of the scheduler, such as tcp://192.168.0.7:8786; for tls:// with Dask's configuration.
            timeout, memory: limits of a call, as in `LocalProcesses`.
            patience: how long to wait for the scheduler's answer [s].

        Raises:
            InvalidInput: the address is malformed, Dask is not installed, or no scheduler answers.
        """
        limits, client = CallLimits(timeout, memory), _connect(address, patience)
        wanted = CALLS_PER_THREAD * sum(client.nthreads().values())
        in_flight = min(max(MIN_IN_FLIGHT, wanted), MAX_IN_FLIGHT)
        super().__init__(limits, in_flight, in_flight)
        self._address, self._patience, self._client = address, patience, client
        self._waiting = set[Any]()  # Dask's futures
        self._closed = False

    def call(self, function: Callable[..., Result], *arguments: Any, **named: Any) -> Result:
        from distributed import KilledWorker

        call = pickle.dumps((function, arguments, named))
        # Not pure, or Dask would answer a repeated call (`fresh`) from its memory.
        remote = self._client.submit(call_in_local_process, call, self.limits, case_identities(arguments), pure=False)
        self._waiting.add(remote)
        try:
            if self._closed:
                raise CancelledError
            returned, content = remote.result()
        except KilledWorker as error:
            # Dask blames every call that a dead worker held, so this call may be innocent.
            died = f"{error.allowed_failures + 1} workers of the cluster died, one after another, of it"
            raise KilledFromOutside(died, True) from None
        except CancelledError:
            raise InvalidInput(f"lost the connection to the cluster at {self._address}") from None
        except Exception as error:  # Dask unpickles on its workers, and errors there may have any type
            line = _message_line(error)
            why = f"the cluster at {self._address} cannot run conrod: {line}; install the same conrod there"
            raise InvalidInput(why) from None
        finally:
            self._waiting.discard(remote)
        if not returned:
            raise content
        result: Result = content
        return result

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """Let calls finish, or cancel them; then disconnect, and leave the cluster running."""
        super().shutdown(wait, cancel_futures=cancel_futures)
        self._client.close(timeout=self._patience)

    def stop(self) -> None:
        self._closed = True
        # A client that has lost its scheduler would wait for it.
        if self._waiting and self._client.status == "running":
            self._client.cancel(list(self._waiting))


def _connect(address: str, patience: float) -> Any:
    """Return a Dask client of the scheduler at an address, after at most `patience` [s].

    Raises:
        InvalidInput: the address is malformed, Dask is not installed, or no scheduler answers.
    """
    if not re.fullmatch(r"(tcp|tls)://[^/\s]+:\d{1,5}", address):
        raise InvalidInput(f"cluster {address!r}: give the scheduler's address, such as tcp://192.168.0.7:8786")
    try:
        import distributed
    except ImportError:
        raise InvalidInput("a cluster needs Dask: pip install 'conrod[cluster]'") from None
    # The error says in one line what Dask would log of a lost connection; each logger has its own level.
    for name in ("distributed", "distributed.client", "tornado.application"):
        logging.getLogger(name).setLevel(logging.CRITICAL)
    try:
        return distributed.Client(address, timeout=patience, set_as_default=False)  # type: ignore[no-untyped-call]
    except (OSError, ValueError, ImportError, TypeError) as error:  # the last where tls:// has no certificates
        raise InvalidInput(f"no cluster answers at {address}: {_message_line(error.__cause__ or error)}") from None


def _message_line(error: BaseException) -> str:
    """Message of an error on one line; the name of its class if it has no message."""
    return " ".join(str(error).split()) or type(error).__name__


# -- on the cluster's workers ------------------------------------------------------------------------------------------

_lock = threading.Lock()
_processes: dict[CallLimits, LocalProcesses] = {}


def call_in_local_process(call: bytes, limits: CallLimits, expected: Sequence[Mapping[str, Any]]) -> tuple[bool, Any]:
    """Make a pickled call in a process of this machine; return (True, result) or (False, error).

    Args:
        call: pickled function, arguments and named arguments. As bytes, because the scheduler would otherwise open it.
        expected: identities of the cases among the arguments on the caller's machine, which must be the same here.
    """
    try:
        function, arguments, named = pickle.loads(call)
        for there, here in zip(expected, case_identities(arguments), strict=True):
            for name in there:
                if here.get(name) != there[name]:
                    raise InvalidInput(
                        f"the cluster's worker on {platform.node()} would run another cell: {there['engine']} run with "
                        f"{name} {here.get(name)!r} there and {there[name]!r} here; install the same versions on both"
                    )
        with _lock:
            new = LocalProcesses(timeout=limits.timeout, memory=limits.memory)
            processes = _processes.setdefault(limits, new)
        return True, processes.call(function, *arguments, **named)
    except (InvalidInput, WorkerDied, KilledFromOutside, TimeoutError, MemoryError) as error:
        return False, error
    except Exception as error:  # raised by the call, of any kind
        # As text: a caller without the module that defines the error's class could not unpickle it.
        return False, RuntimeError(f"{type(error).__name__} on {platform.node()}: {error}")


def case_identities(arguments: Sequence[Any]) -> list[dict[str, Any]]:
    """Return the identity of each case among some arguments, on this machine.

    It has all that determines the case's result, versions of conrod and the engine included.
    """
    return [{"conrod": version("conrod"), **case.identity()} for case in arguments if isinstance(case, Case)]
