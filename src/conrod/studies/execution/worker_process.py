"""Worker processes as their owner sees them: started, called, limited, replaced when they die.

Nothing is imported from the working folder there: files beside a user's model are data, whatever their names. A worker
has a connection of its own: what is printed there is no message, and no other worker's death can leave it waiting.
"""

from __future__ import annotations

import os
import pickle
import signal
import subprocess
import sys
import threading
from collections.abc import Callable
from dataclasses import dataclass
from multiprocessing import Pipe
from pathlib import Path
from typing import Any, TypeVar

from conrod.errors import InvalidInput
from conrod.runs.trajectory import Outcome
from conrod.working_folder import ONE_THREAD, SAFE_PATH

Result = TypeVar("Result")

LEAST_TIMEOUT, MOST_TIMEOUT = 0.1, 2e6  # [s]; a wait for a connection takes no more
# Where this very conrod is.
HOME = str(Path(__file__).parents[3])
# What a kernel short of memory, a batch system or a person sends; an engine does not end itself so.
FROM_OUTSIDE = {-signal.SIGKILL, -signal.SIGTERM}


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


class KilledFromOutside(InvalidInput):
    """A process was killed, and not by conrod: nothing is known of the call that it was busy with.

    Attributes:
        how: the signal.
        begun: whether the process had begun with the call.
    """

    def __init__(self, how: str, begun: bool = True) -> None:
        super().__init__(how, begun)
        self.how, self.begun = how, begun

    def __str__(self) -> str:
        return f"a process was killed from outside{'' if self.begun else ' before it began'}: {self.how}"

    @property
    def again(self) -> Exception:
        """Error of a second kill, with nothing beside the call: the call's own doing, if it had begun."""
        return WorkerDied(f"{self.how}, and again with nothing beside it") if self.begun else self


class WorkerProcess:
    """A Python interpreter of its own that serves one call after another; it ends with its owner, however that ends."""

    def __init__(self, limits: Limits, interpreter: str | None = None) -> None:
        """Start it.

        Args:
            interpreter: of an environment whose packages come before those of this process; None for this one's.

        Raises:
            InvalidInput: the system cannot start it.
        """
        self._limits = limits
        self._pipe, theirs = Pipe()
        before, behind = (import_path(), []) if interpreter is None else ([], import_path())
        interpreter = sys.executable if interpreter is None else interpreter
        # Ended without a word by what OpenBLAS sends itself where it may not start its threads.
        code = (
            "import signal as s, sys; s.signal(s.SIGINT, s.SIG_DFL); sys.path += {!r}; "
            "from conrod.studies.execution.worker import main; main{}"
        )
        try:
            self._process = subprocess.Popen(
                # -P: not from the working folder, which Python would put in front of its own library.
                [interpreter, "-P", "-c", code.format(behind, (theirs.fileno(), limits.memory, limits.headroom))],
                stdin=subprocess.DEVNULL,
                # What an engine prints is not what the command has to say.
                stdout=2,
                pass_fds=[theirs.fileno()],
                env={**ONE_THREAD, **os.environ, **SAFE_PATH, "PYTHONPATH": os.pathsep.join(before)},
                # In a group of its own: Ctrl-C at the terminal is for the owner to answer.
                process_group=0,
            )
        except OSError as error:
            raise InvalidInput(f"a worker process cannot start: {error.strerror or error}") from None
        finally:
            theirs.close()
        self._killed = self._served = self._busy = False

    def call(self, function: Callable[..., Result], *arguments: Any, **named: Any) -> Result:
        """Call a function there; return or raise what it does.

        Raises:
            WorkerDied: the process died of it.
            KilledFromOutside: the process was killed, and not by conrod.
            TimeoutError: it took longer than the limit; the process was killed.
            MemoryError: it needed more than the limit; the process was killed.
            NotBegun: the process died before, of something else.
            InvalidInput: also where the process cannot start at all, or not within the memory limit.
        """
        call = pickle.dumps((function, arguments, named))
        self._busy = True
        self._begin(call)
        # A new process's start is not its first call's time.
        if not self._pipe.poll(self._limits.timeout):
            self.kill()
            raise TimeoutError(f"no result after {self._limits.timeout:g} s")
        try:
            returned, content = self._pipe.recv()
        except (EOFError, OSError):
            raise self._ended() from None
        self._busy = False
        if returned:
            result: Result = content
            return result
        if isinstance(content, MemoryError):
            # What the process still holds would be missing to the next call.
            self.kill()
            raise self._out_of_memory(content)
        raise content

    @property
    def ready(self) -> bool:
        """True if it can be called."""
        return not self._busy and not self._killed and self._process.poll() is None

    def kill(self) -> None:
        """End the process, whatever it is doing; a call under way ends as died."""
        self._killed = True
        self._process.kill()

    def end(self) -> None:
        """End the process and wait for its end; for the thread that has it."""
        self.kill()
        self._process.wait()
        self._pipe.close()

    def _begin(self, call: bytes) -> None:
        """Send the call, and wait until the process begins with it."""
        try:
            self._pipe.send_bytes(call)
            refusal: InvalidInput | None = self._pipe.recv()
        except (EOFError, OSError):
            raise NotBegun if self._served else self._ended() from None
        if refusal is not None:
            raise refusal
        self._served = True

    def _ended(self) -> Exception:
        """The error of a process that has ended; waits for its end."""
        status = self._process.wait()
        how = f"ended by signal {signal.Signals(-status).name}" if status < 0 else f"ended with status {status}"
        if status in FROM_OUTSIDE and not self._killed:
            return KilledFromOutside(how, begun=self._served)
        if not self._served:
            return InvalidInput(f"a worker process cannot start: it {how} before its first cell")
        return WorkerDied(how)

    def _out_of_memory(self, error: MemoryError) -> MemoryError:
        memory, headroom = self._limits.memory, self._limits.headroom
        if memory is headroom is None:
            return error
        return MemoryError(
            f"the limit was {headroom} bytes more than it began with"
            if memory is None
            else f"the limit was {memory} bytes"
        )


def import_path() -> list[str]:
    """Folders that a worker imports from: those of this process but the working folder, and that of conrod."""
    # An empty entry stands for the working folder, where an interpreter begins that was given no script.
    path = [entry for entry in sys.path if entry]
    return path if HOME in path else [HOME, *path]


class WorkerProcesses:
    """As many worker processes as are called at a time, used again and again until one dies."""

    def __init__(self, limits: Limits, interpreter: str | None = None) -> None:
        self.limits, self._interpreter = limits, interpreter
        self._lock = threading.Lock()
        self._all: set[WorkerProcess] = set()
        self._idle: list[WorkerProcess] = []
        self._stopped = False

    def call(self, function: Callable[..., Result], *arguments: Any, **named: Any) -> Result:
        """As `WorkerProcess.call`, in an idle worker or a new one; for any number of threads at once."""
        while True:
            worker = self._taken()
            try:
                return worker.call(function, *arguments, **named)
            except NotBegun:
                pass  # killed from outside while it had nothing to do: the call is for the next one
            finally:
                self._give_back(worker)

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
            for worker in self._all:
                worker.kill()
        self.rest()

    def _taken(self) -> WorkerProcess:
        with self._lock:
            if self._stopped:
                raise WorkerDied("ended before it began")
            if self._idle:
                return self._idle.pop()
            worker = WorkerProcess(self.limits, interpreter=self._interpreter)
            self._all.add(worker)
            return worker

    def _give_back(self, worker: WorkerProcess) -> None:
        with self._lock:
            if worker.ready and not self._stopped:
                self._idle.append(worker)
                return
            self._all.discard(worker)
        worker.end()
