"""Calls in processes of this machine; one that crashes, hangs or fills memory fails alone."""

from __future__ import annotations

import threading
from abc import abstractmethod
from collections.abc import Callable, Generator, Iterator, Sequence
from concurrent.futures import Executor, Future, ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from pkgutil import resolve_name
from types import TracebackType
from typing import Any, ParamSpec, TypeVar

from conrod.comparison.trajectory import Outcome
from conrod.errors import InvalidInput
from conrod.execution.worker_process import (
    CallLimits,
    CallNotStarted,
    KilledFromOutside,
    WorkerDied,
    WorkerProcess,
    start_failure_message,
)

MAX_JOBS = 1024
Arguments = ParamSpec("Arguments")
Argument = TypeVar("Argument")
Result = TypeVar("Result")


class RetryingExecutor(Executor):
    """An executor in other processes; it repeats a call whose process was killed from outside.

    If a person or a kernel short of memory kills the process, the call is made once more, with no other call beside
    it. A function must be importable by its module's name, as with any process that does not fork, and not from the
    working folder.

    Attributes:
        limits: limits of each call.
        in_flight: number of calls to submit at a time: enough that no process waits, few enough to cancel quickly.
    """

    def __init__(self, limits: CallLimits, in_flight: int, threads: int) -> None:
        self.limits, self.in_flight = limits, in_flight
        # A thread only waits for the answer to its call.
        self._threads = ThreadPoolExecutor(threads, thread_name_prefix="conrod-call")
        # Each call takes a place; a call that must be alone takes all places.
        self._count, self._places, self._lone = threads, threading.Semaphore(threads), threading.Lock()

    @abstractmethod
    def call(self, function: Callable[..., Result], *arguments: Any, **named: Any) -> Result:
        """Call a function once in another process, and return its result.

        Raises:
            WorkerDied, TimeoutError, MemoryError: the call crashed its process, or reached a limit.
            KilledFromOutside: the process was killed, and not by conrod.
        """

    @abstractmethod
    def stop(self) -> None:
        """End all calls, and refuse new ones."""

    def submit(
        self, fn: Callable[Arguments, Result], /, *args: Arguments.args, **kwargs: Arguments.kwargs
    ) -> Future[Result]:
        """Submit a call; return its future, which raises the errors of `call`."""
        return self._threads.submit(self._call_with_retry, fn, args, kwargs)

    def _call_with_retry(
        self, function: Callable[..., Result], arguments: tuple[Any, ...], named: dict[str, Any]
    ) -> Result:
        """Make a call; if its process is killed from outside, repeat it while no other call runs."""
        try:
            with self._places:
                return self.call(function, *arguments, **named)
        except KilledFromOutside:
            pass
        with self._hold_all_places():
            try:
                return self.call(function, *arguments, **named)
            except KilledFromOutside as error:
                how, has_served = error.args
                again = WorkerDied(f"{how}, and again with nothing beside it")
                raise again if has_served else InvalidInput(start_failure_message(how)) from None

    @contextmanager
    def _hold_all_places(self) -> Iterator[None]:
        """Hold the places of all concurrent calls, so that no other call runs meanwhile."""
        with self._lone:
            for _ in range(self._count):
                self._places.acquire()
        try:
            yield
        finally:
            self._places.release(self._count)

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """Wait for calls, or cancel the waiting calls; then end the processes."""
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


class LocalProcesses(RetryingExecutor):
    """An executor with one worker process per simultaneous call; workers serve until they die."""

    def __init__(
        self,
        jobs: int = 1,
        *,
        timeout: float | None = None,
        memory: int | None = None,
        interpreter: str | None = None,
    ) -> None:
        """Prepare the executor; processes start when they are needed.

        Args:
            jobs: number of calls at a time.
            timeout: longest wall time of a call [s], from when its process begins with it.
            memory: address space that a process may take beyond what it has then [bytes]; POSIX only.
            interpreter: Python interpreter of the processes, see `WorkerProcess`.

        Raises:
            InvalidInput: a number out of range.
        """
        if not 1 <= jobs <= MAX_JOBS:
            raise InvalidInput(f"{jobs} jobs: give a number from 1 to {MAX_JOBS}")
        super().__init__(CallLimits(timeout, memory), 4 * jobs, jobs)
        self._interpreter = interpreter
        self._lock, self._stopped = threading.Lock(), False
        self._all: set[WorkerProcess] = set()
        self._idle: list[WorkerProcess] = []
        # By worker, the plugin engine that runs in it: two plugins never share a process.
        self._engines: dict[WorkerProcess, str | None] = {}

    def call(self, function: Callable[..., Result], *arguments: Any, **named: Any) -> Result:
        engine = next((one.plugin_name for one in arguments if hasattr(one, "plugin_name")), None)
        while True:
            worker = self._take_worker(engine)
            try:
                return worker.call(function, *arguments, **named)
            except CallNotStarted:  # the idle worker had been killed: try the next
                continue
            finally:
                self._return_worker(worker)

    def stop(self) -> None:
        with self._lock:
            self._stopped = True
            idle, self._idle = self._idle, []
            for worker in self._all:
                worker.kill()
        for worker in idle:
            worker.end()

    def _take_worker(self, engine: str | None) -> WorkerProcess:
        """Return a worker, idle or new, that has run no plugin engine but the given one."""
        with self._lock:
            if self._stopped:
                raise WorkerDied("ended before it began")
            for idle in [worker for worker in self._idle if not worker.ready]:
                self._end_idle_worker(idle)
            usable = [worker for worker in self._idle if self._engines[worker] == engine]
            if usable:
                self._idle.remove(usable[-1])
                return usable[-1]
            if self._idle and len(self._all) >= self._count:
                self._end_idle_worker(self._idle[0])  # it has another engine: the new worker takes its place
            worker = WorkerProcess(self.limits, interpreter=self._interpreter)
            self._all.add(worker)
            self._engines[worker] = engine
            return worker

    def _end_idle_worker(self, idle: WorkerProcess) -> None:
        """End an idle worker; the caller holds the lock."""
        self._idle.remove(idle)
        self._all.discard(idle)
        del self._engines[idle]
        idle.end()

    def _return_worker(self, worker: WorkerProcess) -> None:
        """Make a worker idle again after a call; end it if it cannot be called again."""
        with self._lock:
            if worker.ready and not self._stopped:
                self._idle.append(worker)
                return
            self._all.discard(worker)
            del self._engines[worker]
        worker.end()


# Limits of a task on a user's file.
FILE_TIMEOUT = 600.0  # [s]
FILE_MEMORY = 4 << 30  # [bytes]


@dataclass(frozen=True)
class FailedCall:
    """The outcome of a call that gave no result, with the reason: its process ended, or a plugin's engine failed."""

    outcome: Outcome
    reason: str

    @classmethod
    def from_error(cls, error: TimeoutError | MemoryError | WorkerDied) -> FailedCall:
        """Return the failed call for an error that an executor raised."""
        outcomes = {TimeoutError: Outcome.TIMED_OUT, MemoryError: Outcome.OUT_OF_MEMORY}
        return cls(outcomes.get(type(error), Outcome.CRASHED), str(error) or "there was no more")


def call_isolated(
    task: Callable[..., Result], *arguments: Any, timeout: float | None = None, memory: int | None = None
) -> Result | FailedCall:
    """Call a function in a fresh process; return its result, or how that process ended.

    The process ends with the calling process, however that ends. If it is killed from outside, the call is repeated
    once.

    Args:
        task: a function that can be pickled, as its arguments.
        timeout: longest wall time of the call [s]; None for no limit.
        memory: address space that the process may take beyond what it has when the call begins [bytes]; None for no
            limit.

    Raises:
        Exception: any error that the task raised, other than MemoryError.
    """
    with LocalProcesses(1, timeout=timeout, memory=memory) as process:
        return _outcome_of(process.submit(task, *arguments))


def _outcome_of(call: Future[Result]) -> Result | FailedCall:
    """Wait for a call; return its result, or how its process ended."""
    try:
        return call.result()
    except (TimeoutError, MemoryError, WorkerDied) as error:
        return FailedCall.from_error(error)


def call_on_file(task: Callable[..., Result], path: Path, *arguments: Any, timeout: float = FILE_TIMEOUT) -> Result:
    """Call a task on a user's file in a fresh process, and return its result.

    Args:
        task: called with the path and the arguments; a function that can be pickled, as its result.
        timeout: longest wall time of the task [s].

    Raises:
        InvalidInput: raised by the task, or the task crashed, took too long or too much memory.
    """
    return _usable(path, call_isolated(task, path, *arguments, timeout=timeout, memory=FILE_MEMORY))


def call_named(path: Path, task: str, *arguments: Any) -> Any:
    """Call the function of a full name on a file: a task for `call_on_file` whose module the calling process needs not.

    It and the libraries that it imports are loaded in the process of the call alone.
    """
    return resolve_name(task)(path, *arguments)


def call_on_own_files(
    task: Callable[..., Result], calls: Sequence[tuple[Path, tuple[Any, ...]]], jobs: int
) -> Generator[Result, None, None]:
    """Call a task on files that conrod wrote, several at a time, and yield the results in order.

    Args:
        task: as in `call_on_file`; processes serve one call after another, so that it must not leave anything behind.
        calls: path and further arguments of each call.
        jobs: number of calls at a time.

    Raises:
        InvalidInput: as in `call_on_file`; the other calls are ended.
    """
    with LocalProcesses(min(jobs, len(calls)), timeout=FILE_TIMEOUT, memory=FILE_MEMORY) as processes:
        made = [processes.submit(task, path, *arguments) for path, arguments in calls]
        for (path, _), call in zip(calls, made, strict=True):
            result = _outcome_of(call)
            yield _usable(path, result)


def call_each(
    processes: RetryingExecutor, task: Callable[[Argument], Result], arguments: Sequence[Argument]
) -> Iterator[Result | FailedCall]:
    """Call a task with each argument, one call a process at a time, and yield the results in order.

    A call whose process crashes, or that takes too long or too much memory, yields how it ended.
    """
    calls = [processes.submit(task, one) for one in arguments]
    yield from map(_outcome_of, calls)


def _usable(path: Path, result: Result | FailedCall) -> Result:
    """Return the result of a task on a file; raise InvalidInput if it has none."""
    if isinstance(result, FailedCall):
        raise InvalidInput(f"{path}: it cannot be used: {result.outcome.meaning} ({result.reason})")
    return result
