"""Calls in processes of this machine: what one of them does to its process costs that call alone."""

from __future__ import annotations

import threading
from abc import abstractmethod
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, Future, ThreadPoolExecutor
from contextlib import contextmanager
from types import TracebackType
from typing import Any, ParamSpec, TypeVar

from conrod.errors import InvalidInput
from conrod.studies.execution.worker_process import KilledFromOutside, Limits, WorkerProcesses

MOST_JOBS = 1024
Arguments = ParamSpec("Arguments")
Result = TypeVar("Result")


class RepeatingExecutor(Executor):
    """An executor of calls in other processes; one that is killed from outside is repeated before it is blamed.

    Killed by a person or for want of memory, it is made once more, with nothing beside it. What is called must be
    importable by its module's name, as with any process that does not fork, and not from the working folder.

    Attributes:
        limits: of each call.
        in_flight: how many calls are to be handed over at a time: no process ever waits, and an interrupt is quick.
    """

    def __init__(self, limits: Limits, in_flight: int, threads: int) -> None:
        self.limits, self.in_flight = limits, in_flight
        # A thread does nothing but wait for its call's answer.
        self._threads = ThreadPoolExecutor(threads, thread_name_prefix="conrod-call")
        # Each call passes the turnstile; one that must be alone stays in it, until the others have ended and it has.
        self._turnstile, self._under_way, self._ended = threading.Lock(), 0, threading.Condition()

    @abstractmethod
    def _call(self, alone: bool, function: Callable[..., Result], *arguments: Any, **named: Any) -> Result:
        """The result of a call.

        Args:
            alone: whether nothing is to be beside it.

        Raises:
            WorkerDied, TimeoutError, MemoryError: what the call did to its process.
            KilledFromOutside: its process was killed, and not by conrod.
        """

    @abstractmethod
    def _stop(self) -> None:
        """End all calls, and let none begin."""

    def submit(
        self, fn: Callable[Arguments, Result], /, *args: Arguments.args, **kwargs: Arguments.kwargs
    ) -> Future[Result]:
        """The future of a call; see `_call` for what it may raise."""
        return self._threads.submit(self._called, fn, args, kwargs)

    def _called(self, function: Callable[..., Result], arguments: tuple[Any, ...], named: dict[str, Any]) -> Result:
        try:
            with self._beside_others():
                return self._call(False, function, *arguments, **named)
        except KilledFromOutside:
            pass
        with self._turnstile:
            with self._ended:
                self._ended.wait_for(lambda: self._under_way == 0)
            try:
                return self._call(True, function, *arguments, **named)
            except KilledFromOutside as error:
                raise error.again from None

    @contextmanager
    def _beside_others(self) -> Iterator[None]:
        with self._turnstile, self._ended:
            self._under_way += 1
        try:
            yield
        finally:
            with self._ended:
                self._under_way -= 1
                self._ended.notify_all()

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """Let the calls under way finish, and, unless they are cancelled, those that wait; then end the processes."""
        self._threads.shutdown(wait=wait, cancel_futures=cancel_futures)
        if wait:
            self._stop()

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None
    ) -> bool | None:
        if error is not None:
            # An interrupt must not wait for calls that take minutes.
            self._stop()
        self.shutdown(cancel_futures=error is not None)
        return None


class LocalProcesses(RepeatingExecutor):
    """An executor of which every job has a worker process; a call that kills, hangs or fills one ends by itself."""

    def __init__(
        self,
        jobs: int = 1,
        *,
        cell_timeout: float | None = None,
        cell_memory: int | None = None,
        interpreter: str | None = None,
    ) -> None:
        """Start nothing yet: processes start when they are needed.

        Args:
            jobs: how many calls run at a time.
            cell_timeout: longest wall time of a call [s], from when its process begins with it.
            cell_memory: largest address space of a process [bytes], the libraries it has loaded included; POSIX only.
            interpreter: of the processes, see `WorkerProcess`.

        Raises:
            InvalidInput: a number that has no meaning.
        """
        if not 1 <= jobs <= MOST_JOBS:
            raise InvalidInput(f"{jobs} jobs: give a number from 1 to {MOST_JOBS}")
        super().__init__(Limits(cell_timeout, cell_memory), 4 * jobs, jobs)
        self._workers = WorkerProcesses(self.limits, interpreter)

    def _call(self, alone: bool, function: Callable[..., Result], *arguments: Any, **named: Any) -> Result:
        if alone:
            self._workers.rest()
        return self._workers.call(function, *arguments, **named)

    def _stop(self) -> None:
        self._workers.stop()
