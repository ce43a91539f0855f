"""A Python process of its own: where it imports from, how messages go to it and back, what memory it has, how it ended.

Nothing is imported from the working folder there: files beside a user's model are data, whatever their names. Messages
go in on standard input and come out on a pipe of their own: what is printed there, whenever, is no message.
"""

from __future__ import annotations

import os
import queue
import signal
import subprocess
import sys
import threading
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import IO

from conrod.errors import InvalidInput

# Kept back by a process whose memory is limited: to say that all is taken takes some.
RESERVE = 1 << 24  # bytes


# Less than this is too little for an engine to load its libraries, compile a model or make its state. (With 32 MB left,
# MuJoCo fails in a handful of ways, of which only some say why; with 64 MB it does not.)
SPARE = 1 << 26  # bytes
# What libraries say that were given no memory, and as what kinds of error.
SIGNS = ("allocate memory", "insufficient memory", "failed to map segment")
FOREIGN = (ImportError, OSError, RuntimeError, ValueError)


def ran_out_of_memory(error: Exception) -> bool:
    """True if an error came of this process's memory limit; to be asked before what the process holds is let go."""
    if isinstance(error, MemoryError):
        return True
    limit = memory_limit()
    if limit is None or isinstance(error, InvalidInput):
        return False
    said = any(sign in str(error) for sign in SIGNS)
    return said or (isinstance(error, FOREIGN) and limit - address_space() < SPARE)


def memory_limit() -> int | None:
    """Largest address space that this process may have [bytes]; None where there is no limit."""
    try:
        import resource
    except ImportError:  # not POSIX
        return None
    limit, _ = resource.getrlimit(resource.RLIMIT_AS)
    return None if limit == resource.RLIM_INFINITY else limit


def address_space() -> int:
    """Address space of this process [bytes]; 0 where the system does not say."""
    try:
        with open("/proc/self/statm", encoding="ascii") as file:
            return int(file.read().split()[0]) * os.sysconf("SC_PAGE_SIZE")
    except FileNotFoundError:
        return 0


def how_it_ended(status: int | None) -> str:
    """Describe a process's end by its exit status as Python gives it: negative for a signal."""
    if status is not None and status < 0:
        return f"ended by signal {signal.Signals(-status).name}"
    return f"ended with status {status}"


LENGTH = 8  # bytes, of a message's length in front of it
# What a process says before it begins with a call: one that ends without this word has not died of the call.
BEGUN = b"begun"
# Where this very conrod is.
HOME = str(Path(__file__).parents[3])
# What a kernel short of memory, a batch system or a person sends; an engine does not end itself so.
FROM_OUTSIDE = {-signal.SIGKILL, -signal.SIGTERM}


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


class Child:
    """A process as its owner sees it; it ends with its owner, however that ends."""

    def __init__(self, module: str, *arguments: object, environment: Mapping[str, str] | None = None) -> None:
        """Start it.

        Args:
            module: its `main` is called, with an `Owner` and the arguments.
            arguments: plain values.
            environment: what variables are there unless this process has others.

        Raises:
            InvalidInput: the system cannot start it.
        """
        answers, theirs = os.pipe()
        # -P: not from the working folder, which Python would put in front of its own library.
        code = f"from {__name__} import Owner; from {module} import main; main(Owner({theirs}), *{arguments!r})"
        try:
            self._process = subprocess.Popen(
                [sys.executable, "-P", "-c", code],
                stdin=subprocess.PIPE,
                # What an engine prints is not what the command has to say.
                stdout=2,
                pass_fds=[theirs],
                env={**(environment or {}), **os.environ, "PYTHONPATH": os.pathsep.join(import_path())},
                # In a group of its own: Ctrl-C at the terminal is for the owner to answer.
                process_group=0,
            )
        except OSError as error:
            os.close(answers)
            raise InvalidInput(f"a worker process cannot start: {error.strerror or error}") from None
        finally:
            os.close(theirs)
        self._answers = os.fdopen(answers, "rb")
        self._killed = False

    @property
    def alive(self) -> bool:
        """True while it runs."""
        return self._process.poll() is None

    def send(self, message: bytes) -> None:
        """Write a message; EOFError if the process has ended."""
        assert self._process.stdin is not None
        try:
            _write(self._process.stdin, message)
        except OSError:
            raise EOFError from None

    def receive(self, timeout: float | None = None) -> bytes:
        """Read a message.

        Args:
            timeout: longest time to wait [s]; None for no limit.

        Raises:
            EOFError: the process has ended.
            TimeoutError: it took longer; the process was killed.
        """
        late = threading.Event()
        timer = None if timeout is None else threading.Timer(timeout, self._stop, (late,))
        if timer is not None:
            timer.daemon = True
            timer.start()
        try:
            return _read(self._answers)
        except EOFError:
            if late.is_set():
                raise TimeoutError(f"no result after {timeout:g} s") from None
            raise
        finally:
            if timer is not None:
                timer.cancel()

    def how_it_ended(self) -> str:
        """The signal or status that the process ended with; waits for its end.

        Raises:
            KilledFromOutside: it was killed, and not by its owner.
        """
        status = self._process.wait()
        if status in FROM_OUTSIDE and not self._killed:
            raise KilledFromOutside(how_it_ended(status))
        return how_it_ended(status)

    def kill(self) -> None:
        """End the process, whatever it is doing."""
        self._killed = True
        self._process.kill()

    def end(self) -> None:
        """End the process, wait for its end and close its pipes; for the thread that has it."""
        self.kill()
        self._process.wait()
        assert self._process.stdin is not None
        # What was still to be written has nobody to read it.
        with suppress(BrokenPipeError):
            self._process.stdin.close()
        self._answers.close()

    def _stop(self, late: threading.Event) -> None:
        late.set()
        self.kill()


class Owner:
    """The process that started this one, as this one sees it; the end of it is the end of this one, busy or not."""

    def __init__(self, answers: int) -> None:
        os.set_inheritable(answers, False)
        self._answers = os.fdopen(answers, "wb")
        self._messages: queue.SimpleQueue[bytes] = queue.SimpleQueue()
        threading.Thread(target=self._listen, daemon=True).start()

    def receive(self) -> bytes:
        """Wait for a message."""
        return self._messages.get()

    def send(self, message: bytes) -> None:
        """Write a message; OSError if nobody reads."""
        _write(self._answers, message)

    def _listen(self) -> None:
        # Not `sys.stdin`, which Python closes as it ends, and aborts if a thread still reads from it.
        with open(0, "rb", closefd=False) as calls:
            while True:
                try:
                    self._messages.put(_read(calls))
                except EOFError:
                    os._exit(0)


def import_path() -> list[str]:
    """Folders that a child imports from: those of this process but the working folder, and that of conrod."""
    # An empty entry stands for the working folder, where an interpreter begins that was given no script.
    path = [entry for entry in sys.path if entry]
    return path if HOME in path else [HOME, *path]


def _write(stream: IO[bytes], message: bytes) -> None:
    stream.write(len(message).to_bytes(LENGTH, "big") + message)
    stream.flush()


def _read(stream: IO[bytes]) -> bytes:
    return _exactly(stream, int.from_bytes(_exactly(stream, LENGTH), "big"))


def _exactly(stream: IO[bytes], length: int) -> bytes:
    content = stream.read(length)
    if len(content) < length:
        raise EOFError
    return content
