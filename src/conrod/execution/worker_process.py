"""Worker processes as their owner sees them: called, limited, replaced when they die."""

from __future__ import annotations

import os
import pickle
import subprocess
import sys
import threading
from collections.abc import Callable
from contextlib import suppress
from typing import Any, TypeVar

from conrod.errors import InvalidInput
from conrod.execution.limits import Limits
from conrod.execution.worker import BEGUN, receive, send
from conrod.process import how_it_ended

Result = TypeVar("Result")


class WorkerDied(RuntimeError):
    """The process that a call ran in ended before the call did; says how."""


class NotBegun(RuntimeError):
    """The process ended before it began with the call, which is not what it died of."""


class WorkerProcess:
    """A Python interpreter of its own that serves one call after another.

    It has pipes of its own: no death of another one, at whatever moment, can leave this one waiting. And it ends with
    its owner, however that ends. InvalidInput where the system cannot start one.
    """

    def __init__(self, limits: Limits) -> None:
        self._limits = limits
        self._process = _started(limits)
        self._welcomed = False

    def call(self, function: Callable[..., Result], arguments: tuple[Any, ...], named: dict[str, Any]) -> Result:
        """What a function returns or raises there.

        Raises:
            WorkerDied: the process died of it.
            TimeoutError: it took longer than the limit; the process was killed.
            MemoryError: it needed more than the limit.
            NotBegun: the process died before, of something else.
            InvalidInput: also where the process cannot start at all, or not within the memory limit.
        """
        call = pickle.dumps((function, arguments, named))
        self._welcome()
        self._begin(call)
        returned, content = pickle.loads(self._answer())
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
    def ready(self) -> bool:
        """Whether the process has started and still runs."""
        return self._welcomed and self._process.poll() is None

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

    def _begin(self, call: bytes) -> None:
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        try:
            send(self._process.stdin, call)
            begun = receive(self._process.stdout)
        except (EOFError, OSError):
            raise NotBegun(how_it_ended(self._process.wait())) from None
        assert begun == BEGUN

    def _answer(self) -> bytes:
        assert self._process.stdout is not None
        late = threading.Event()
        timer = None if self._limits.timeout is None else threading.Timer(self._limits.timeout, self._stop, (late,))
        if timer is not None:
            timer.daemon = True
            timer.start()
        try:
            return receive(self._process.stdout)
        except EOFError:
            status = self._process.wait()
            if late.is_set():
                raise TimeoutError(f"no result after {self._limits.timeout:g} s") from None
            raise WorkerDied(how_it_ended(status)) from None
        finally:
            if timer is not None:
                timer.cancel()

    def _stop(self, late: threading.Event) -> None:
        late.set()
        self._process.kill()


# There are as many processes as cores: the threads of their linear algebra would only get in each other's way.
ONE_THREAD = {"OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1", "MKL_NUM_THREADS": "1"}


def _started(limits: Limits) -> subprocess.Popen[bytes]:
    try:
        return subprocess.Popen(
            [sys.executable, "-c", f"from conrod.execution.worker import main; main({limits.memory!r})"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            env={**ONE_THREAD, **os.environ, "PYTHONPATH": os.pathsep.join(path or os.getcwd() for path in sys.path)},
            # In a group of its own: Ctrl-C at the terminal is for the owner to answer.
            process_group=0,
        )
    except OSError as error:
        raise InvalidInput(f"a worker process cannot start: {error.strerror or error}") from None


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
