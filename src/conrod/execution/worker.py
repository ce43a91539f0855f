"""What runs in a worker process: one call after another, as they come in, until its owner is gone.

Calls arrive on standard input and answers leave on standard output, each pickled behind its length. Whatever an engine
prints goes to standard error.
"""

from __future__ import annotations

import os
import pickle
import queue
import sys
import threading
from typing import IO

from conrod.errors import InvalidInput, portable
from conrod.process import RESERVE, address_space, ran_out_of_memory

LENGTH = 8  # bytes
# Sent before a call is looked at: a process that dies without this word has not died of the call.
BEGUN = b"begun"


def send(stream: IO[bytes], content: bytes) -> None:
    """Write one message; OSError if nobody reads."""
    stream.write(len(content).to_bytes(LENGTH, "big") + content)
    stream.flush()


def receive(stream: IO[bytes]) -> bytes:
    """Read one message.

    Raises:
        EOFError: the other side ended, perhaps in the middle of it.
    """
    length = int.from_bytes(_exactly(stream, LENGTH), "big")
    return _exactly(stream, length)


def _exactly(stream: IO[bytes], length: int) -> bytes:
    content = stream.read(length)
    if len(content) < length:
        raise EOFError
    return content


def main(memory: int | None) -> None:
    """Serve calls until standard input ends.

    Args:
        memory: largest address space of this process [bytes], None for no limit.
    """
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)
    calls: queue.SimpleQueue[bytes] = queue.SimpleQueue()
    threading.Thread(target=_listen, args=(calls,), daemon=True).start()
    reserve = bytearray(0 if memory is None else RESERVE)
    send(answers, pickle.dumps(_limit(memory)))
    while True:
        call = calls.get()
        send(answers, BEGUN)
        send(answers, _answer(call, reserve))


def _listen(calls: queue.SimpleQueue[bytes]) -> None:
    """Take calls as they come; the end of them is the end of the owner, and so of this process, busy or not."""
    while True:
        try:
            calls.put(receive(sys.stdin.buffer))
        except EOFError:
            os._exit(0)


def _limit(memory: int | None) -> InvalidInput | None:
    """Limit this process; the answer says why it cannot be."""
    if memory is None:
        return None
    import resource  # POSIX only; without a limit the rest works anywhere

    import conrod.studies.measurement  # noqa: F401  what every cell loads is loaded before the limit is compared

    used = address_space()
    if memory <= used:
        return InvalidInput(
            f"a cell's memory limit of {memory} bytes is less than the {used} that a process starts with"
        )
    resource.setrlimit(resource.RLIMIT_AS, (memory, memory))
    return None


def _answer(call: bytes, reserve: bytearray) -> bytes:
    """The pickled pair of whether the call returned, and what it returned or raised."""
    try:
        function, arguments, named = pickle.loads(call)
        return pickle.dumps((True, function(*arguments, **named)))
    except Exception as error:
        if ran_out_of_memory(error):
            reserve.clear()
            return pickle.dumps((False, MemoryError(str(error))))
        return pickle.dumps((False, portable(error)))
