"""A call in a process of its own: what kills the process, hangs it or fills the memory is an outcome like any other."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

from conrod.errors import InvalidInput
from conrod.runs.trajectory import Outcome
from conrod.studies.execution.local import LocalProcesses
from conrod.studies.execution.worker_process import WorkerDied

Result = TypeVar("Result")

# What work on a file of a user's may take.
FILE_TIMEOUT = 600.0  # [s]
FILE_MEMORY = 4 << 30  # [bytes]


@dataclass(frozen=True)
class Ended:
    """End of a call, in a process of its own, without a result."""

    outcome: Outcome
    reason: str

    @classmethod
    def of(cls, error: TimeoutError | MemoryError | WorkerDied) -> Ended:
        """The end that an error of an executor tells."""
        outcomes = {TimeoutError: Outcome.TIMED_OUT, MemoryError: Outcome.OUT_OF_MEMORY}
        return cls(outcomes.get(type(error), Outcome.CRASHED), str(error) or "there was no more")


def isolated(
    task: Callable[..., Result], *arguments: Any, timeout: float | None = None, memory: int | None = None
) -> Result | Ended:
    """Call a function in a fresh process; return its result, or how that process ended.

    The process ends with the one that called, however that ends. Where it is killed from outside, the call is repeated
    once before that is believed.

    Args:
        task: what to do there; a function that can be pickled, as its arguments.
        timeout: longest time that the call may take there [s]; None for no limit.
        memory: address space that the process may take beyond what it has when the call begins [bytes], None for no
            limit.

    Raises:
        Exception: what the task raised there, other than MemoryError.
    """
    with LocalProcesses(1, cell_timeout=timeout, cell_memory=memory) as process:
        try:
            return process.submit(task, *arguments).result()
        except (TimeoutError, MemoryError, WorkerDied) as error:
            return Ended.of(error)


def confined(task: Callable[..., Result], path: Path, *arguments: Any, timeout: float = FILE_TIMEOUT) -> Result:
    """Result of a task on a user's file, in a fresh process: a file that takes it down is an error like any.

    Args:
        task: called with the path and the arguments; a function that can be pickled, as is what it returns.
        timeout: longest time that it may take [s].

    Raises:
        InvalidInput: what the task raised, or that it crashed, took too long or too much memory.
    """
    answer = isolated(task, path, *arguments, timeout=timeout, memory=FILE_MEMORY)
    if isinstance(answer, Ended):
        raise InvalidInput(f"{path}: it cannot be used: {answer.outcome.meaning} ({answer.reason})")
    return answer
