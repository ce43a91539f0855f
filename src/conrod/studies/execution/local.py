"""Cells in processes of this machine: what one of them does to its process costs that cell alone."""

from __future__ import annotations

import threading
from collections.abc import Callable
from concurrent.futures import Executor, Future, ThreadPoolExecutor
from types import TracebackType
from typing import Any, ParamSpec, TypeVar

from conrod.errors import InvalidInput
from conrod.studies.execution.child import KilledFromOutside
from conrod.studies.execution.worker_process import Limits, WorkerProcesses, killed_again

MOST_JOBS = 1024
Arguments = ParamSpec("Arguments")
Result = TypeVar("Result")


class LocalProcesses(Executor):
    """An executor of which every job has a worker process; a call that kills, hangs or fills one ends by itself.

    A future then raises WorkerDied, TimeoutError or MemoryError; only that worker is replaced. A call whose worker is
    killed from outside, by a person or for want of memory, is repeated once with nothing beside it. What is called must
    be importable by its module's name, as with any process that does not fork, and not from the working folder.
    """

    def __init__(self, jobs: int = 1, *, cell_timeout: float | None = None, cell_memory: int | None = None) -> None:
        """Start nothing yet: processes start when they are needed.

        Args:
            jobs: how many calls run at a time.
            cell_timeout: longest wall time of a call [s], from when its process begins with it.
            cell_memory: largest address space of a process [bytes], the libraries it has loaded included; POSIX only.

        Raises:
            InvalidInput: a number that has no meaning.
        """
        if not 1 <= jobs <= MOST_JOBS:
            raise InvalidInput(f"{jobs} jobs: give a number from 1 to {MOST_JOBS}")
        self.limits = Limits(cell_timeout, cell_memory)
        # Enough waiting that no worker ever does, and few enough that an interrupt is quick.
        self.in_flight = 4 * jobs
        self._workers = WorkerProcesses(self.limits)
        # Each call takes a place; one that must be alone takes all, while no other passes the turnstile.
        self._jobs, self._places, self._turnstile = jobs, threading.Semaphore(jobs), threading.Lock()
        # A thread does nothing but wait for its worker's answer.
        self._threads = ThreadPoolExecutor(jobs, thread_name_prefix="conrod-worker")

    def submit(
        self, fn: Callable[Arguments, Result], /, *args: Arguments.args, **kwargs: Arguments.kwargs
    ) -> Future[Result]:
        """The future of a call; see the class for what it may raise."""
        return self._threads.submit(self._called, fn, args, kwargs)

    def _called(self, function: Callable[..., Result], arguments: tuple[Any, ...], named: dict[str, Any]) -> Result:
        """Result of a call; one whose process was killed from outside is repeated before that is believed."""
        try:
            with self._turnstile:
                self._places.acquire()
            try:
                return self._workers.call(function, arguments, named)
            finally:
                self._places.release()
        except KilledFromOutside:
            return self._called_alone(function, arguments, named)

    def _called_alone(
        self, function: Callable[..., Result], arguments: tuple[Any, ...], named: dict[str, Any]
    ) -> Result:
        with self._turnstile:
            for _ in range(self._jobs):
                self._places.acquire()
            try:
                self._workers.rest()
                return self._workers.call(function, arguments, named)
            except KilledFromOutside as error:
                raise killed_again(error) from None
            finally:
                self._places.release(self._jobs)

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """Let the calls under way finish, and, unless they are cancelled, those that wait; then end the processes."""
        self._threads.shutdown(wait=wait, cancel_futures=cancel_futures)
        if wait:
            self._workers.stop()

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None
    ) -> bool | None:
        if error is not None:
            # An interrupt must not wait for cells that take minutes.
            self._workers.stop()
        self.shutdown(wait=True, cancel_futures=error is not None)
        return None
