"""Start, call, limit and end a worker process; its other side is `worker.main`.

A worker imports nothing from the working folder: files beside a user's model are data, whatever their names. Each
worker has a separate connection: text that an engine prints is no message, and the death of another worker cannot
leave it waiting.
"""

from __future__ import annotations

import codecs
import mmap
import os
import pickle
import secrets
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
from conrod.comparison.trajectory import Outcome
from conrod.errors import COMMANDING_CHARACTERS, InvalidInput
from conrod.system import EXTERNAL_KILLS, WORKER_MARK, address_space_limit, kill_group, kill_marked, popen_arguments

Result = TypeVar("Result")

POLL_INTERVAL = 0.1  # [s], between two looks whether a process still runs
END_TIMEOUT = 5.0  # [s], for a process to end after its connection has closed
# Spaces that an engine prints into the connection read as a message length of 0x20202020, which is larger.
MAX_MESSAGE_BYTES = 1 << 29
MIN_TIMEOUT, MAX_TIMEOUT = 0.1, 2e6  # [s]; the wait for a connection takes no larger number
# The folder that this conrod is imported from.
SOURCE_FOLDER = str(Path(__file__).parents[3])


@dataclass(frozen=True)
class CallLimits:
    """Limits of a call in a worker process; None is no limit.

    Attributes:
        timeout: wall time [s], from when the process begins with the call.
        memory: address space that the process may take beyond what it has then [bytes].
    """

    timeout: float | None = None
    memory: int | None = None

    def __post_init__(self) -> None:
        """Refuse limits out of range.

        Raises:
            InvalidInput: names the limit and its range.
        """
        if self.timeout is not None and not MIN_TIMEOUT <= self.timeout <= MAX_TIMEOUT:
            raise InvalidInput(
                f"--cell-timeout: {self.timeout:g} s for a run is not in {MIN_TIMEOUT:g}..{MAX_TIMEOUT:g} s"
            )
        if self.memory is not None and self.memory < 1:
            raise InvalidInput(f"--cell-memory: {self.memory} bytes for a run is no memory at all")

    def limit_for(self, outcome: str) -> float | None:
        """Return the limit, [s] or [bytes], that ends a run with an outcome; None for other outcomes."""
        return {Outcome.TIMED_OUT.slug: self.timeout, Outcome.OUT_OF_MEMORY.slug: self.memory}.get(outcome)

    def allow_more(self, outcome: str, allowed: float) -> bool:
        """True if a run that ended with this outcome at a limit of `allowed` has a wider limit now."""
        now = self.limit_for(outcome)
        return now is None or now > allowed


class WorkerDied(RuntimeError):
    """A worker process ended before its call returned; the message says how."""


class KilledFromOutside(Exception):
    """A worker process was killed, and not by conrod, so nothing is known of its call.

    Its arguments are how the process ended, and whether it had begun with any call.
    """


class CallNotStarted(Exception):
    """A worker process ended while it was idle, so another worker can make its call."""


class WorkerProcess:
    """A separate Python process that serves one call after another, and ends with its owner."""

    def __init__(self, limits: CallLimits, interpreter: str | None = None) -> None:
        """Start the process.

        Args:
            interpreter: Python of an environment whose packages take precedence over those of this process; None for
                the Python of this process.

        Raises:
            InvalidInput: the system cannot start the process.
        """
        self._limits, self._mark = limits, secrets.token_hex(8)
        self._pipe, theirs = Pipe()
        before, behind = (import_path(), []) if interpreter is None else ([], import_path())
        interpreter = sys.executable if interpreter is None else interpreter
        # SIGINT keeps its default: OpenBLAS sends it to itself if it may not start threads, and the process must end.
        code = (
            "import signal as s, sys; s.signal(s.SIGINT, s.SIG_DFL); sys.path += {!r}; "
            "from conrod.execution.worker import main; main{}"
        )
        try:
            self._process = subprocess.Popen(
                # -P: Python would put the working folder in front of its own library.
                [interpreter, "-P", "-c", code.format(behind, (theirs.fileno(), limits.memory))],
                stdin=subprocess.DEVNULL,
                # Text that an engine prints is no output of the command, and must not command a terminal.
                stdout=subprocess.PIPE,
                stderr=subprocess.STDOUT,
                env={
                    **ONE_THREAD,
                    **os.environ,
                    **SAFE_PATH,
                    "PYTHONPATH": os.pathsep.join(before),
                    WORKER_MARK: self._mark,
                },
                **popen_arguments(theirs.fileno()),
            )
        except OSError as error:
            raise InvalidInput(f"a worker process cannot start: {error.strerror or error}") from None
        finally:
            theirs.close()
        assert self._process.stdout is not None
        self._relay = threading.Thread(target=_relay_output, args=(self._process.stdout,), daemon=True)
        self._relay.start()
        self._killed = self._served = self._busy = False

    def call(self, function: Callable[..., Result], *arguments: Any, **named: Any) -> Result:
        """Call a function in the process; return its result, or raise its error.

        Raises:
            WorkerDied: the process ended during the call.
            KilledFromOutside: the process was killed, and not by conrod.
            CallNotStarted: the process had ended while it was idle.
            TimeoutError: the call took longer than the limit; the process was killed.
            MemoryError: the call needed more than the limit; the process was killed.
            InvalidInput: raised by the function, or the process cannot start.
        """
        call = pickle.dumps((function, arguments, named))
        with suppress(OSError):  # if the process has ended, the next read says so
            self._pipe.send_bytes(call)
        # The process reports when it begins with the call: its own start does not count against the time limit.
        self._receive()
        self._served = self._busy = True
        if not self._wait_for_message(self._limits.timeout):
            self.kill()
            raise TimeoutError(f"no result after {self._limits.timeout:g} s")
        returned, content = self._receive()
        if not returned and isinstance(content, MemoryError):
            # Memory that the process still holds would be missing in its next call.
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
        """True if the process can be called."""
        return not self._busy and not self._killed and self._process.poll() is None

    def kill(self) -> None:
        """Kill the process and all that it has forked; a call in progress raises WorkerDied."""
        self._killed = True
        # Forked processes are in its group, and would hold the owner's output open.
        kill_group(self._process.pid)
        self._process.kill()

    def end(self) -> None:
        """Kill the process and all that it has started, wait for its end and close its connection.

        To be called in the thread that calls the worker, which alone reads the connection.
        """
        self.kill()
        self._process.wait()
        kill_marked(f"{WORKER_MARK}={self._mark}")
        self._pipe.close()
        # A forked process that has left the group, and cleared its environment, may hold the output open.
        self._relay.join(POLL_INTERVAL)

    def _wait_for_message(self, timeout: float | None) -> bool:
        """Wait for a message or the end of the process; False if neither came within a timeout [s].

        The process is polled, because processes that it has forked may hold the connection open after its end.
        """
        deadline = None if timeout is None else time.monotonic() + timeout
        while True:
            interval = POLL_INTERVAL if deadline is None else min(POLL_INTERVAL, max(0.0, deadline - time.monotonic()))
            if self._pipe.poll(interval) or self._process.poll() is not None:
                return True
            if deadline is not None and time.monotonic() >= deadline:
                return False

    def _receive(self) -> Any:
        """Return the next message of the process; if it ends without one, raise how."""
        with suppress(EOFError, OSError):
            self._wait_for_message(None)
            # A process that has ended without a message is not waited for.
            if self._pipe.poll(0.0):
                return self._unpickle(self._pipe.recv_bytes(MAX_MESSAGE_BYTES))
        how = self._describe_end()
        if self._served and not self._busy and not self._killed:
            raise CallNotStarted(how)
        if self._process.returncode in EXTERNAL_KILLS and not self._killed:
            raise KilledFromOutside(how, self._served)
        raise WorkerDied(how) if self._served else InvalidInput(start_failure_message(how))

    def _unpickle(self, message: bytes) -> Any:
        """Unpickle a message; raise WorkerDied if an engine has written into the connection."""
        try:
            return pickle.loads(message)
        except Exception:  # text that is no message may raise any error
            self.kill()
            raise WorkerDied("wrote into conrod's connection with it, so that no answer can be read") from None

    def _describe_end(self) -> str:
        """Say how the process ended; kill it if it runs on without a usable connection."""
        try:
            status = self._process.wait(END_TIMEOUT)
        except subprocess.TimeoutExpired:
            self.kill()
            self._process.wait()
            return "broke conrod's connection with it"
        return f"ended by signal {signal.Signals(-status).name}" if status < 0 else f"ended with status {status}"


def _relay_output(printed: IO[bytes]) -> None:
    """Copy the output of a worker to standard error, without characters that command a terminal."""
    decoder = codecs.getincrementaldecoder("utf-8")("replace")
    with printed, suppress(OSError, ValueError):
        while chunk := os.read(printed.fileno(), 1 << 16):
            text = decoder.decode(chunk).translate(COMMANDING_CHARACTERS)
            with suppress(OSError):  # standard error may be closed
                os.write(2, text.encode())


def start_failure_message(how: str) -> str:
    """Return the error message for a worker process that ended before its first call."""
    return f"a worker process cannot start: it {how} before its first cell"


def import_path() -> list[str]:
    """Return a worker's import path: this process's, with conrod, without the working folder."""
    # An empty entry is the working folder, for an interpreter that was given no script.
    path = [entry for entry in sys.path if entry]
    return path if SOURCE_FOLDER in path else [SOURCE_FOLDER, *path]


# Address space of OpenBLAS's buffer [bytes], and the size of a matrix for which it makes the buffer.
BLAS_BUFFER_BYTES, BLAS_MATRIX_SIZE = 1 << 27, 256


def allocate_blas_buffer() -> None:
    """Allocate OpenBLAS's buffer now if memory is limited; failing later would end the process.

    Raises:
        InvalidInput: there is too little address space.
    """
    limit = address_space_limit()
    if limit is None:
        return
    try:
        mmap.mmap(-1, BLAS_BUFFER_BYTES).close()
    except OSError:
        room = BLAS_BUFFER_BYTES >> 20
        raise InvalidInput(
            f"only {limit >> 20} MiB of address space are allowed here (ulimit -v), with fewer than {room} left: "
            f"linear algebra needs as many; allow {(limit >> 20) + 2 * room} MiB"
        ) from None
    import numpy as np

    numbers = np.ones((BLAS_MATRIX_SIZE, BLAS_MATRIX_SIZE))
    np.linalg.solve(numbers + BLAS_MATRIX_SIZE * np.eye(BLAS_MATRIX_SIZE), numbers @ numbers)
