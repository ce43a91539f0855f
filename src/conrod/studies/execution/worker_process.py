"""Worker processes as their owner sees them: called, limited, replaced when they die."""

from __future__ import annotations

import pickle
import threading
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeVar

from conrod.errors import InvalidInput
from conrod.runs.trajectory import Outcome
from conrod.studies.execution.child import BEGUN, Child, KilledFromOutside

Result = TypeVar("Result")

LEAST_TIMEOUT, MOST_TIMEOUT = 0.1, 1e7


@dataclass(frozen=True)
class Limits:
    """Limits of one call; None is no limit.

    Attributes:
        timeout: wall time [s], from the moment a process begins with it.
        memory: address space of the process that runs it [bytes], the libraries it has loaded included.
        headroom: the same, counted from what the process has when the call begins [bytes].
    """

    timeout: float | None = None
    memory: int | None = None
    headroom: int | None = None

    def __post_init__(self) -> None:
        """Refuse limits that no run could keep.

        Raises:
            InvalidInput: names the limit and its range.
        """
        if self.timeout is not None and not LEAST_TIMEOUT <= self.timeout <= MOST_TIMEOUT:
            raise InvalidInput(
                f"--cell-timeout: {self.timeout:g} s for a run is not in {LEAST_TIMEOUT:g}..{MOST_TIMEOUT:g} s"
            )
        if self.memory is not None and self.memory < 1:
            raise InvalidInput(f"--cell-memory: {self.memory} bytes for a run is no memory at all")

    def of(self, outcome: str) -> float | None:
        """The limit at which a run with this outcome ended: [s] or [bytes]; None if it did not end at one."""
        return {Outcome.TIMED_OUT.slug: self.timeout, Outcome.OUT_OF_MEMORY.slug: self.memory}.get(outcome)

    def allow_more(self, outcome: str, allowed: float) -> bool:
        """True if a run that ended at a limit would now get further."""
        now = self.of(outcome)
        return now is None or now > allowed


class WorkerDied(RuntimeError):
    """The process that a call ran in ended before the call did; says how."""


class NotBegun(RuntimeError):
    """The process ended before it began with the call, which is not what it died of."""


def killed_again(error: KilledFromOutside) -> Exception:
    """Error of a second kill, with nothing beside the call: the call's own doing, if it had begun."""
    return WorkerDied(f"{error.how}, and again with nothing beside it") if error.begun else error


# There are as many processes as cores: the threads of their linear algebra would only get in each other's way.
ONE_THREAD = {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1", "MKL_NUM_THREADS": "1"}


class WorkerProcess:
    """A Python interpreter of its own that serves one call after another.

    It has pipes of its own: no death of another one, at whatever moment, can leave this one waiting. And it ends with
    its owner, however that ends. InvalidInput where the system cannot start one.
    """

    def __init__(self, limits: Limits, threads_of_its_own: bool = False) -> None:
        """Start it.

        Args:
            threads_of_its_own: whether its linear algebra may use several cores.
        """
        self._limits = limits
        self._child = _started(limits, threads_of_its_own)
        self._welcomed = False

    def call(self, function: Callable[..., Result], arguments: tuple[Any, ...], named: dict[str, Any]) -> Result:
        """Call a function there; return or raise what it does.

        Raises:
            WorkerDied: the process died of it.
            KilledFromOutside: the process was killed, and not by conrod.
            TimeoutError: it took longer than the limit; the process was killed.
            MemoryError: it needed more than the limit.
            NotBegun: the process died before, of something else.
            InvalidInput: also where the process cannot start at all, or not within the memory limit.
        """
        call = pickle.dumps((function, arguments, named))
        self._welcome()
        self._begin(call)
        try:
            returned, content = pickle.loads(self._child.receive(self._limits.timeout))
        except EOFError:
            raise WorkerDied(self._child.how_it_ended()) from None
        if returned:
            result: Result = content
            return result
        if isinstance(content, MemoryError) and self._limits.memory is not None:
            raise MemoryError(f"the limit was {self._limits.memory} bytes")
        if isinstance(content, MemoryError) and self._limits.headroom is not None:
            raise MemoryError(f"the limit was {self._limits.headroom} bytes more than it began with")
        raise content

    def kill(self) -> None:
        """End the process, whatever it is doing; a call under way ends as died."""
        self._child.kill()

    def end(self) -> None:
        """End the process and wait for its end; for the thread that has it."""
        self._child.end()

    @property
    def ready(self) -> bool:
        """True if the process has started and still runs."""
        return self._welcomed and self._child.alive

    def _welcome(self) -> None:
        """Wait for a new process to be ready, which is not its first call's time."""
        if self._welcomed:
            return
        try:
            refusal: InvalidInput | None = pickle.loads(self._child.receive())
        except EOFError:
            raise self._not_started() from None
        if refusal is not None:
            raise refusal
        self._welcomed = True

    def _not_started(self) -> InvalidInput:
        try:
            how = self._child.how_it_ended()
        except KilledFromOutside as error:
            return KilledFromOutside(error.how, begun=False)
        return InvalidInput(f"a worker process cannot start: it {how} before its first cell")

    def _begin(self, call: bytes) -> None:
        try:
            self._child.send(call)
            begun = self._child.receive()
        except EOFError:
            raise NotBegun from None
        assert begun == BEGUN


def _started(limits: Limits, threads_of_its_own: bool = False) -> Child:
    environment = {} if threads_of_its_own else ONE_THREAD
    return Child("conrod.studies.execution.worker", limits.memory, limits.headroom, environment=environment)


class WorkerProcesses:
    """As many worker processes as are called at a time, used again and again until one dies."""

    def __init__(self, limits: Limits) -> None:
        self.limits = limits
        self._lock = threading.Lock()
        self._all: set[WorkerProcess] = set()
        self._idle: list[WorkerProcess] = []
        self._stopped = False

    def call(self, function: Callable[..., Result], arguments: tuple[Any, ...], named: dict[str, Any]) -> Result:
        """As `WorkerProcess.call`, in an idle worker or a new one; for any number of threads at once."""
        while True:
            worker = self._taken()
            try:
                result = worker.call(function, arguments, named)
            except NotBegun:
                # Killed from outside while it had nothing to do: the call is for the next one.
                self._give_back(worker, usable=False)
            except BaseException as error:
                # After a MemoryError, what the process still holds would be missing to the next call.
                self._give_back(worker, usable=worker.ready and not isinstance(error, MemoryError))
                raise
            else:
                self._give_back(worker, usable=True)
                return result

    def rest(self) -> None:
        """End those that have nothing to do, which hold memory all the same."""
        with self._lock:
            idle, self._idle = self._idle, []
            self._all.difference_update(idle)
        for worker in idle:
            worker.end()

    def stop(self) -> None:
        """Kill all of them; calls under way end as died, and no new ones begin."""
        with self._lock:
            self._stopped = True
            idle, self._idle = self._idle, []
            for worker in self._all:
                worker.kill()
        for worker in idle:
            worker.end()

    def _taken(self) -> WorkerProcess:
        with self._lock:
            if self._stopped:
                raise WorkerDied("ended before it began")
            if self._idle:
                return self._idle.pop()
            worker = WorkerProcess(self.limits)
            self._all.add(worker)
            return worker

    def _give_back(self, worker: WorkerProcess, usable: bool) -> None:
        with self._lock:
            if usable and not self._stopped:
                self._idle.append(worker)
                return
            self._all.discard(worker)
        worker.end()
