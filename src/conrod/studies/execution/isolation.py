"""A call in a process of its own: what kills the process, hangs it or fills the memory is an outcome like any other."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

from conrod.errors import InvalidInput
from conrod.runs.trajectory import Outcome
from conrod.studies.execution.worker_process import KilledFromOutside, Limits, WorkerDied, WorkerProcess

Result = TypeVar("Result")

# What work on a file of a user's may take.
FILE_TIMEOUT = 600.0  # [s]
FILE_HEADROOM = 4 << 30  # [bytes]


@dataclass(frozen=True)
class Ended:
    """End of a call, in a process of its own, without a result."""

    outcome: Outcome
    reason: str


def isolated(
    task: Callable[..., Result], *arguments: Any, timeout: float | None = None, headroom: int | None = None
) -> Result | Ended:
    """Call a function in a fresh process; return its result, or how that process ended.

    The process ends with the one that called, however that ends. Where it is killed from outside, the call is repeated
    once before that is believed.

    Args:
        task: what to do there; a function that can be pickled, as its arguments.
        timeout: longest time that the call may take there [s]; None for no limit.
        headroom: address space that the process may take beyond what it has when the call begins [bytes], None for no
            limit.

    Raises:
        Exception: what the task raised there, other than MemoryError.
    """
    with suppress(KilledFromOutside):
        return isolated_once(task, *arguments, timeout=timeout, headroom=headroom)
    try:
        return isolated_once(task, *arguments, timeout=timeout, headroom=headroom)
    except KilledFromOutside as error:
        return Ended(Outcome.CRASHED, f"{error.how}, and again when it was repeated")


def isolated_once(
    task: Callable[..., Result], *arguments: Any, timeout: float | None = None, headroom: int | None = None
) -> Result | Ended:
    """As `isolated`, for a part of a case, which its executor repeats as a whole and with nothing beside it.

    Raises:
        KilledFromOutside: the process was killed, and not by conrod.
    """
    worker = WorkerProcess(Limits(timeout, headroom=headroom))
    try:
        return worker.call(task, *arguments)
    except (TimeoutError, MemoryError, WorkerDied) as error:
        return Ended(outcome_of(error), str(error))
    finally:
        # Also where the wait was interrupted.
        worker.end()


def outcome_of(error: TimeoutError | MemoryError | WorkerDied) -> Outcome:
    """The outcome of a run that ended without a result."""
    if isinstance(error, TimeoutError):
        return Outcome.TIMED_OUT
    return Outcome.OUT_OF_MEMORY if isinstance(error, MemoryError) else Outcome.CRASHED


def confined(task: Callable[..., Result], path: Path, *arguments: Any, timeout: float = FILE_TIMEOUT) -> Result:
    """Result of a task on a user's file, in a fresh process: a file that takes it down is an error like any.

    Args:
        task: called with the path and the arguments; a function that can be pickled, as is what it returns.
        timeout: longest time that it may take [s].

    Raises:
        InvalidInput: what the task raised, or that it crashed, took too long or too much memory.
    """
    answer = isolated(task, path, *arguments, timeout=timeout, headroom=FILE_HEADROOM)
    if isinstance(answer, Ended):
        raise InvalidInput(f"{path}: it cannot be used: {answer.outcome.meaning} ({answer.reason})")
    return answer
