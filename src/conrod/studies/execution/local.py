"""Calls in processes of this machine: what one of them does to its process costs that call alone."""

from __future__ import annotations

import threading
from abc import abstractmethod
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, Future, ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import Any, ParamSpec, TypeVar

from conrod.errors import InvalidInput
from conrod.runs.trajectory import Outcome
from conrod.studies.execution.worker_process import (
    KilledFromOutside,
    Limits,
    NeverBegun,
    WorkerDied,
    WorkerProcess,
    cannot_start,
)
from conrod.studies.frame.case import Case

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
        # Each call takes a place; one that must be alone takes all of them.
        self._count, self._places, self._lone = threads, threading.Semaphore(threads), threading.Lock()

    @abstractmethod
    def call(self, function: Callable[..., Result], *arguments: Any, **named: Any) -> Result:
        """The result of a call, made once.

        Raises:
            WorkerDied, TimeoutError, MemoryError: what the call did to its process.
            KilledFromOutside: its process was killed, and not by conrod.
        """

    @abstractmethod
    def stop(self) -> None:
        """End all calls, and let none begin."""

    def submit(
        self, fn: Callable[Arguments, Result], /, *args: Arguments.args, **kwargs: Arguments.kwargs
    ) -> Future[Result]:
        """The future of a call; see `call` for what it may raise."""
        return self._threads.submit(self._called, fn, args, kwargs)

    def _called(self, function: Callable[..., Result], arguments: tuple[Any, ...], named: dict[str, Any]) -> Result:
        try:
            with self._places:
                return self.call(function, *arguments, **named)
        except KilledFromOutside:
            pass
        with self._alone():
            try:
                return self.call(function, *arguments, **named)
            except KilledFromOutside as error:
                how, begun = error.args
                again = WorkerDied(f"{how}, and again with nothing beside it")
                raise again if begun else InvalidInput(cannot_start(how)) from None

    @contextmanager
    def _alone(self) -> Iterator[None]:
        with self._lone:
            for _ in range(self._count):
                self._places.acquire()
        try:
            yield
        finally:
            self._places.release(self._count)

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """Let the calls under way finish, and, unless they are cancelled, those that wait; then end the processes."""
        self._threads.shutdown(wait=wait, cancel_futures=cancel_futures)
        if wait:
            self.stop()

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None
    ) -> bool | None:
        if error is not None:
            # An interrupt must not wait for calls that take minutes.
            self.stop()
        self.shutdown(cancel_futures=error is not None)
        return None


class LocalProcesses(RepeatingExecutor):
    """An executor with as many worker processes as it has calls at a time, each used again until it dies."""

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
            cell_memory: address space that a process may take beyond what it has then [bytes]; POSIX only.
            interpreter: of the processes, see `WorkerProcess`.

        Raises:
            InvalidInput: a number that has no meaning.
        """
        if not 1 <= jobs <= MOST_JOBS:
            raise InvalidInput(f"{jobs} jobs: give a number from 1 to {MOST_JOBS}")
        super().__init__(Limits(cell_timeout, cell_memory), 4 * jobs, jobs)
        self._interpreter = interpreter
        self._lock, self._stopped = threading.Lock(), False
        self._all: set[WorkerProcess] = set()
        self._idle: list[WorkerProcess] = []
        # By worker, the engine of another package that runs in it: what that does to its process is done to no other.
        self._engines: dict[WorkerProcess, str | None] = {}

    def call(self, function: Callable[..., Result], *arguments: Any, **named: Any) -> Result:
        engine = next((one.plugin_name for one in arguments if isinstance(one, Case)), None)
        while True:
            worker = self._taken(engine)
            try:
                return worker.call(function, *arguments, **named)
            except NeverBegun:  # as many as were killed while they had nothing to do
                continue
            finally:
                self._give_back(worker)

    def stop(self) -> None:
        with self._lock:
            self._stopped = True
            idle, self._idle = self._idle, []
            for worker in self._all:
                worker.kill()
        for worker in idle:
            worker.end()

    def _taken(self, engine: str | None) -> WorkerProcess:
        """A worker in which no engine of another package but this one has run."""
        with self._lock:
            if self._stopped:
                raise WorkerDied("ended before it began")
            for idle in [one for one in self._idle if not one.ready]:
                self._drop(idle)
            mine = [one for one in self._idle if self._engines[one] == engine]
            if mine:
                self._idle.remove(mine[-1])
                return mine[-1]
            if self._idle and len(self._all) >= self._count:
                self._drop(self._idle[0])  # of another engine, in the place of which a new one starts
            worker = WorkerProcess(self.limits, interpreter=self._interpreter)
            self._all.add(worker)
            self._engines[worker] = engine
            return worker

    def _drop(self, idle: WorkerProcess) -> None:
        self._idle.remove(idle)
        self._all.discard(idle)
        del self._engines[idle]
        idle.end()

    def _give_back(self, worker: WorkerProcess) -> None:
        with self._lock:
            if worker.ready and not self._stopped:
                self._idle.append(worker)
                return
            self._all.discard(worker)
            del self._engines[worker]
        worker.end()


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
