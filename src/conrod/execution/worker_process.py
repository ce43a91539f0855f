"""Worker processes as their owner sees them: called, limited, replaced when they die."""

from __future__ import annotations

import os
import pickle
import signal
import subprocess
import sys
import threading
from collections.abc import Callable
from contextlib import suppress
from typing import Any, TypeVar

from conrod.errors import InvalidInput
from conrod.execution.limits import Limits
from conrod.execution.worker import receive, send

Result = TypeVar("Result")


class WorkerDied(RuntimeError):
    """The process that a call ran in ended before the call did; says how."""


class WorkerProcess:
    """A Python interpreter of its own that serves one call after another.

    It has pipes of its own: no death of another one, at whatever moment, can leave this one waiting. And it ends with
    its owner, however that ends.
    """

    def __init__(self, limits: Limits) -> None:
        self._limits = limits
        self._process = subprocess.Popen(
            [sys.executable, "-c", f"from conrod.execution.worker import main; main({limits.memory!r})"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            env={**os.environ, "PYTHONPATH": os.pathsep.join(path or os.getcwd() for path in sys.path)},
            # In a group of its own: Ctrl-C at the terminal is for the owner to answer.
            process_group=0,
        )
        self._welcomed = False

    def call(self, function: Callable[..., Result], arguments: tuple[Any, ...], named: dict[str, Any]) -> Result:
        """What a function returns or raises there.

        Raises:
            WorkerDied: the process died of it.
            TimeoutError: it took longer than the limit; the process was killed.
            MemoryError: it needed more than the limit.
            InvalidInput: also where the process cannot start at all, or not within the memory limit.
        """
        call = pickle.dumps((function, arguments, named))
        self._welcome()
        late = threading.Event()
        timer = None if self._limits.timeout is None else threading.Timer(self._limits.timeout, self._stop, (late,))
        if timer is not None:
            timer.daemon = True
            timer.start()
        try:
            returned, content = pickle.loads(self._exchange(call))
        except (EOFError, OSError):
            status = self._process.wait()
            if late.is_set():
                raise TimeoutError(f"no result after {self._limits.timeout:g} s") from None
            raise WorkerDied(how_it_ended(status)) from None
        finally:
            if timer is not None:
                timer.cancel()
        if returned:
            result: Result = content
            return result
        if isinstance(content, MemoryError) and self._limits.memory is not None:
            raise MemoryError(f"the limit was {self._limits.memory} bytes")
        raise content

    def kill(self) -> None:
        """End the process, whatever it is doing; a call under way ends as died."""
        self._process.kill()

    def end(self) -> None:
        """End the process, wait for its end and close its pipes; for the thread that has it."""
        self._process.kill()
        self._process.wait()
        for pipe in (self._process.stdin, self._process.stdout):
            assert pipe is not None
            # What was still to be written has nobody to read it.
            with suppress(BrokenPipeError):
                pipe.close()

    @property
    def alive(self) -> bool:
        """Whether the process still runs."""
        return self._process.poll() is None

    def _welcome(self) -> None:
        """Wait for a new process to be ready, which is not its first call's time."""
        if self._welcomed:
            return
        assert self._process.stdout is not None
        try:
            refusal: InvalidInput | None = pickle.loads(receive(self._process.stdout))
        except EOFError:
            how = how_it_ended(self._process.wait())
            raise InvalidInput(f"a worker process cannot start: it {how} before its first cell") from None
        if refusal is not None:
            raise refusal
        self._welcomed = True

    def _exchange(self, call: bytes) -> bytes:
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        send(self._process.stdin, call)
        return receive(self._process.stdout)

    def _stop(self, late: threading.Event) -> None:
        late.set()
        self._process.kill()


def how_it_ended(status: int | None) -> str:
    """How a process ended, by its exit status as Python gives it: negative for a signal."""
    if status is not None and status < 0:
        return f"ended by signal {signal.Signals(-status).name}"
    return f"ended with status {status}"


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
        worker = self._taken()
        usable = True
        try:
            return worker.call(function, arguments, named)
        except MemoryError:
            # What the process still holds would be missing to the next call.
            usable = False
            raise
        finally:
            self._give_back(worker, usable)

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
            while self._idle:
                worker = self._idle.pop()
                if worker.alive:
                    return worker
                # Killed from outside while it had nothing to do.
                self._all.discard(worker)
                worker.end()
            worker = WorkerProcess(self.limits)
            self._all.add(worker)
            return worker

    def _give_back(self, worker: WorkerProcess, usable: bool) -> None:
        with self._lock:
            if usable and worker.alive and not self._stopped:
                self._idle.append(worker)
                return
            self._all.discard(worker)
        worker.end()
