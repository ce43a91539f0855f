"""A worker process as its owner sees it: started, called, limited, killed.

Nothing is imported from the working folder there: files beside a user's model are data, whatever their names. A worker
has a connection of its own: what is printed there is no message, and no other worker's death can leave it waiting.
"""

from __future__ import annotations

import codecs
import mmap
import os
import pickle
import resource
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from multiprocessing import Pipe
from pathlib import Path
from typing import IO, Any, TypeVar

from conrod import ONE_THREAD, SAFE_PATH
from conrod.errors import COMMANDING_CHARACTERS, InvalidInput
from conrod.runs.trajectory import Outcome

Result = TypeVar("Result")

LOOK, GRACE = 0.1, 5.0  # [s] between two looks whether a process is there; for one to end that answers no more
# Of a message: the length that a text reads as which an engine writes into the connection (0x20202020) is more.
MOST_BYTES = 1 << 29
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
        memory: address space that its process may take beyond what it has then [bytes].
    """

    timeout: float | None = None
    memory: int | None = None

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


class KilledFromOutside(Exception):
    """A process was killed, and not by conrod: nothing is known of the call that it was busy with.

    Its arguments are how, and whether the process had begun with any call.
    """


class NeverBegun(Exception):
    """A process that had served calls ended before it began with this one, which another can be given."""


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
                [interpreter, "-P", "-c", code.format(behind, (theirs.fileno(), limits.memory))],
                stdin=subprocess.DEVNULL,
                # What an engine prints is not what the command has to say, and commands no terminal: see `_relay`.
                stdout=subprocess.PIPE,
                stderr=subprocess.STDOUT,
                pass_fds=[theirs.fileno()],
                env={**ONE_THREAD, **os.environ, **SAFE_PATH, "PYTHONPATH": os.pathsep.join(before)},
                # In a session of its own: Ctrl-C at the terminal is for the owner to answer, and what an engine
                # forks ends with its group.
                start_new_session=True,
            )
        except OSError as error:
            raise InvalidInput(f"a worker process cannot start: {error.strerror or error}") from None
        finally:
            theirs.close()
        assert self._process.stdout is not None
        self._relay = threading.Thread(target=_relay, args=(self._process.stdout,), daemon=True)
        self._relay.start()
        self._killed = self._served = self._busy = False

    def call(self, function: Callable[..., Result], *arguments: Any, **named: Any) -> Result:
        """Call a function there; return or raise what it does.

        Raises:
            WorkerDied: the process died of it.
            KilledFromOutside: the process was killed, and not by conrod.
            NeverBegun: the process had ended while it had nothing to do.
            TimeoutError: it took longer than the limit; the process was killed.
            MemoryError: it needed more than the limit; the process was killed.
            InvalidInput: also where the process cannot start at all.
        """
        call = pickle.dumps((function, arguments, named))
        with suppress(OSError):  # of a process that has ended: what it answers says so
            self._pipe.send_bytes(call)
        # It says when it begins: a new process's start is not its first call's time.
        self._received()
        self._served = self._busy = True
        if not self._answered(self._limits.timeout):
            self.kill()
            raise TimeoutError(f"no result after {self._limits.timeout:g} s")
        returned, content = self._received()
        if not returned and isinstance(content, MemoryError):
            # What the process still holds would be missing to the next call.
            self.kill()
            memory = self._limits.memory
            raise content if memory is None else MemoryError(f"the limit was {memory} bytes more than it began with")
        self._busy = False
        if not returned:
            raise content
        result: Result = content
        return result

    @property
    def ready(self) -> bool:
        """True if it can be called."""
        return not self._busy and not self._killed and self._process.poll() is None

    def kill(self) -> None:
        """End the process and all that it has forked, whatever it is doing; a call under way ends as died."""
        self._killed = True
        # What it forked is in its group, and would hold the owner's output open; there may be nobody left in it.
        with suppress(ProcessLookupError, PermissionError):
            os.killpg(self._process.pid, signal.SIGKILL)
        self._process.kill()

    def end(self) -> None:
        """End the process and wait for its end; for the thread that has it."""
        self.kill()
        self._process.wait()
        self._pipe.close()
        # What it forked and lives in a group of its own may hold its output open.
        self._relay.join(LOOK)

    def _answered(self, timeout: float | None) -> bool:
        """Wait for a message or the end of the process; False where neither came in time [s].

        What the process has forked may hold the connection open after it, so that no end of it would be read.
        """
        deadline = None if timeout is None else time.monotonic() + timeout
        while True:
            left = LOOK if deadline is None else min(LOOK, max(0.0, deadline - time.monotonic()))
            if self._pipe.poll(left) or self._process.poll() is not None:
                return True
            if deadline is not None and time.monotonic() >= deadline:
                return False

    def _received(self) -> Any:
        """Next message of the worker; where there is none, the error of its end, which is waited for."""
        with suppress(EOFError, OSError):
            self._answered(None)
            # Nothing is waited for of a process that has ended without a message.
            if self._pipe.poll(0.0):
                return self._opened(self._pipe.recv_bytes(MOST_BYTES))
        how = self._end_told()
        if self._served and not self._busy and not self._killed:
            raise NeverBegun(how)
        if self._process.returncode in FROM_OUTSIDE and not self._killed:
            raise KilledFromOutside(how, self._served)
        raise WorkerDied(how) if self._served else InvalidInput(cannot_start(how))

    def _opened(self, message: bytes) -> Any:
        try:
            return pickle.loads(message)
        except Exception:  # what is no message may raise anything
            self.kill()
            raise WorkerDied("wrote into conrod's connection with it, so that no answer can be read") from None

    def _end_told(self) -> str:
        """How the process ended; one that has closed its connection, or filled it with what is no message, is ended."""
        try:
            status = self._process.wait(GRACE)
        except subprocess.TimeoutExpired:
            self.kill()
            self._process.wait()
            return "broke conrod's connection with it"
        return f"ended by signal {signal.Signals(-status).name}" if status < 0 else f"ended with status {status}"


def _relay(printed: IO[bytes]) -> None:
    """Pass what a worker prints to standard error, without what would command a terminal."""
    decoder = codecs.getincrementaldecoder("utf-8")("replace")
    with printed, suppress(OSError, ValueError):
        while chunk := os.read(printed.fileno(), 1 << 16):
            text = decoder.decode(chunk).translate(COMMANDING_CHARACTERS)
            with suppress(OSError):  # nobody reads it
                os.write(2, text.encode())


def cannot_start(how: str) -> str:
    """The message where nothing can be said of a call."""
    return f"a worker process cannot start: it {how} before its first cell"


def import_path() -> list[str]:
    """Folders that a worker imports from: those of this process but the working folder, and that of conrod."""
    # An empty entry stands for the working folder, where an interpreter begins that was given no script.
    path = [entry for entry in sys.path if entry]
    return path if HOME in path else [HOME, *path]


# Room [bytes] that OpenBLAS's buffer takes, and numbers enough for it to be made.
BLAS_ROOM, BLAS_SIZE = 1 << 27, 256


def take_blas_buffer() -> None:
    """Have OpenBLAS make its buffer where memory is limited; it ends the process where it finds no room for it later.

    Raises:
        InvalidInput: there is no room.
    """
    limit, _ = resource.getrlimit(resource.RLIMIT_AS)
    if limit == resource.RLIM_INFINITY:
        return
    try:
        mmap.mmap(-1, BLAS_ROOM).close()
    except OSError:
        room = BLAS_ROOM >> 20
        raise InvalidInput(
            f"only {limit >> 20} MiB of address space are allowed here (ulimit -v), with fewer than {room} left: "
            f"linear algebra needs as many; allow {(limit >> 20) + 2 * room} MiB"
        ) from None
    import numpy as np

    numbers = np.ones((BLAS_SIZE, BLAS_SIZE))
    np.linalg.solve(numbers + BLAS_SIZE * np.eye(BLAS_SIZE), numbers @ numbers)
