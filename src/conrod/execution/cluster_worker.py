"""What runs on a worker of a cluster: a call in a process of its own there, as on this machine."""

from __future__ import annotations

import pickle
import platform
import threading
from collections.abc import Mapping, Sequence
from importlib.metadata import version
from typing import Any

from conrod.errors import InvalidInput
from conrod.execution.limits import Limits
from conrod.execution.worker_process import WorkerDied, WorkerProcesses
from conrod.studies.cell import Cell

_lock = threading.Lock()
_processes: dict[Limits, WorkerProcesses] = {}


def answer(call: bytes, limits: Limits, expected: Sequence[Mapping[str, Any]]) -> tuple[bool, Any]:
    """Whether a call returned, and what it returned or raised.

    The call goes through a process of its own, so that what a cell does to its process costs neither this worker nor
    the cells beside it, and takes its time limit from its own start.

    Args:
        call: pickled function, arguments and named arguments. As bytes, because the scheduler would otherwise open it.
        expected: identities of the cells among the arguments, as the caller finds them.
    """
    try:
        function, arguments, named = pickle.loads(call)
        _check(expected, identities(arguments))
        return True, _workers(limits).call(function, arguments, named)
    except (InvalidInput, WorkerDied, TimeoutError, MemoryError) as error:
        return False, error
    except Exception as error:
        # Dask would open it while it unpickles the message; a caller without the module could not read even that.
        return False, RuntimeError(f"{type(error).__name__} on {platform.node()}: {error}")


def identities(arguments: Sequence[Any]) -> list[dict[str, Any]]:
    """What the results of the cells among some arguments are determined by, here."""
    versions = {"conrod": version("conrod")}
    return [{**versions, **cell.identity()} for cell in arguments if isinstance(cell, Cell)]


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
