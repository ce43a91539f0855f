"""Processes in which releases of MuJoCo are called, each started at its first call."""

from __future__ import annotations

from collections.abc import Callable
from types import TracebackType
from typing import Any, Self

from conrod.engines.releases import Releases
from conrod.errors import InvalidInput
from conrod.execution.local import FILE_TIMEOUT
from conrod.execution.releases import release_interpreter
from conrod.execution.worker_process import CallLimits, WorkerDied, WorkerProcess


class ReleaseProcesses:
    """Calls functions in processes of releases, which end with the context."""

    def __init__(self, releases: Releases) -> None:
        """Start no process yet."""
        self._releases = releases
        self._processes: dict[tuple[str, int], WorkerProcess] = {}

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        for process in self._processes.values():
            process.end()

    def call(self, version: str, process: int, function: Callable[..., Any], *arguments: Any) -> Any:
        """Call a function in a process of a release, and return its result.

        Raises:
            InvalidInput: the release cannot be installed, refuses the model, ends or takes too long; says which.
        """
        key = version, process
        if key not in self._processes:
            python = release_interpreter("mujoco", self._releases.requirement(version), version)
            self._processes[key] = WorkerProcess(CallLimits(timeout=FILE_TIMEOUT), interpreter=python)
        try:
            return self._processes[key].call(function, *arguments)
        except (WorkerDied, TimeoutError) as error:
            self._processes.pop(key).end()
            raise InvalidInput(f"it {error}" if isinstance(error, WorkerDied) else str(error)) from None
        except (AttributeError, TypeError) as error:
            # A release lacks something that conrod uses of it.
            raise InvalidInput(f"conrod cannot drive it: {type(error).__name__}: {error}") from None
