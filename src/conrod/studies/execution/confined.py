"""Work on a file of a user's in a process of its own: one that takes the process down is a user's error like any."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

from conrod.errors import InvalidInput
from conrod.studies.execution.isolation import Ended, isolated

Result = TypeVar("Result")

TIMEOUT = 600.0  # [s]
HEADROOM = 4 << 30  # [bytes]


def confined(
    task: Callable[..., Result],
    path: Path,
    *arguments: Any,
    timeout: float = TIMEOUT,
    headroom: int = HEADROOM,
) -> Result:
    """What a task makes of a file, in a fresh process.

    Args:
        task: called with the path and the arguments; a function that can be pickled, as is what it returns.
        timeout: longest time that it may take [s].
        headroom: memory that it may take beyond what a process begins with [bytes].

    Raises:
        InvalidInput: what the task raised, or that it crashed, took too long or too much memory.
    """
    answer = isolated(task, path, *arguments, timeout=timeout, headroom=headroom)
    if isinstance(answer, Ended):
        raise InvalidInput(f"{path}: it cannot be used: {answer.outcome.meaning} ({answer.reason})")
    return answer
