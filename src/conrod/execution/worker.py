"""Main loop of a worker process: it answers pickled calls until its owner ends.

A worker that runs many cases of one scene computes the scene's tables once.
"""

from __future__ import annotations

import os
import pickle
import threading
from collections.abc import Callable
from dataclasses import replace
from functools import lru_cache
from multiprocessing.connection import Connection
from queue import SimpleQueue
from typing import TypeVar

from conrod import engines
from conrod.comparison.plain_values import plain_values
from conrod.comparison.trajectory import Outcome
from conrod.engines.plugin_values import EngineFault, error_line
from conrod.errors import InvalidInput, portable
from conrod.execution.case import Case, CaseResult
from conrod.execution.local import FailedCall
from conrod.scenes import Scene
from conrod.system import (
    WORKER_MARK,
    address_space_limit,
    end_own_group,
    inherited_connection,
    kill_marked,
    limit_address_space,
    used_address_space,
)

Result = TypeVar("Result")
AnyCase = TypeVar("AnyCase", bound=Case)

# A sweep has few scenes, a map of limits one scene per row; each takes 0.8 MB.
CACHED_SCENES = 128


def perform(case: Case) -> CaseResult | FailedCall:
    """Perform a case in this process, and return its result.

    An error that an engine of another package raises is the outcome `crashed` of that run; an error of conrod's own
    engines is conrod's fault, and is raised.
    """
    if (engine := case.plugin_name) is None:
        return case.perform()
    loaded = engines.engine_named(engine)
    before = getattr(loaded, "handed_over", 0)
    try:
        # What a plugin gave is made conrod's own values where it can harm its own case alone.
        return case.restore_result(plain_values(case.perform()))
    except Exception as error:
        # An input that conrod refuses before the engine has returned anything is the user's mistake.
        refused_input = isinstance(error, InvalidInput) and getattr(loaded, "handed_over", 0) == before
        if refused_input or _is_out_of_memory(error):
            raise
        reason = str(error) if isinstance(error, EngineFault) else f"{type(error).__name__}: {error_line(error)}"
        return FailedCall(Outcome.CRASHED, reason)


def call_with_cached_scene(task: Callable[[AnyCase], Result], case: AnyCase) -> Result:
    """Call a task with a case, whose scene is replaced by an equal scene that is cached here.

    A case from another process brings the parameters of its scene alone, and tables computed from them take longer
    than most runs.
    """
    return task(replace(case, scene=_cached_scene(case.scene)))


@lru_cache(CACHED_SCENES)
def _cached_scene(scene: Scene) -> Scene:
    """Return the first equal scene that this process has used, with its computed tables."""
    return scene


# -- the process ------------------------------------------------------------------------------------------------------


# Least file descriptor of the connection: an engine that writes into a wrong descriptor hits a lower one.
MIN_DESCRIPTOR = 200


def main(pipe: int, memory: int | None) -> None:
    """Serve calls until the owner, the process that started this one, ends.

    Args:
        pipe: file descriptor of the owner's connection; on Windows its handle.
        memory: address space that a call may take beyond what this process has when it begins [bytes].
    """
    engines.load_plugin = engines.load_plugin_here  # here an engine can harm this process alone
    owner, calls, served_by = inherited_connection(pipe, MIN_DESCRIPTOR), SimpleQueue[bytes](), os.getpid()
    threading.Thread(target=_receive_calls, args=(owner, calls), daemon=True).start()
    reserve = bytearray(0 if memory is None else RESERVED_BYTES)
    while True:
        call = calls.get()
        # Before the call is unpickled, which may crash the process.
        owner.send(None)
        answer = _answer_call(call, reserve, memory)
        if os.getpid() != served_by:
            os._exit(0)  # an engine has forked, and the copy has returned from the call, too
        owner.send_bytes(answer)


def _receive_calls(owner: Connection, calls: SimpleQueue[bytes]) -> None:
    """Receive calls, in a thread; end this process when its owner has ended."""
    while True:
        try:
            calls.put(owner.recv_bytes())
        except (EOFError, OSError):
            kill_marked(f"{WORKER_MARK}={os.environ.get(WORKER_MARK)}")
            end_own_group()


def _answer_call(call: bytes, reserve: bytearray, memory: int | None) -> bytes:
    """Make a pickled call; return the pickled pair (True, result) or (False, error).

    Args:
        reserve: memory that is released if there is too little to pickle the error.
        memory: address space that the call may take beyond what this process has now [bytes].
    """
    try:
        function, arguments, named = pickle.loads(call)
        if memory is not None:
            limit_address_space(used_address_space() + memory)
        # Pickled within the limits, too: a result that is too large to send has not been given.
        return pickle.dumps((True, function(*arguments, **named)))
    except Exception as error:  # of any kind: it is raised again in the owner
        if _is_out_of_memory(error):
            reserve.clear()
            return pickle.dumps((False, MemoryError(str(error))))
        return pickle.dumps((False, portable(error)))


# -- its memory -------------------------------------------------------------------------------------------------------

# Kept back by a process whose memory is limited: to report that memory is short takes memory.
RESERVED_BYTES = 1 << 24
# Less than this is too little for an engine to load its libraries, compile a model or make its state. (With 32 MB left,
# MuJoCo fails in several ways, of which only some say why; with 64 MB it does not.)
MIN_SPARE_BYTES = 1 << 26
# Parts of the messages of libraries that get no memory, and classes of their errors. (The last message is MuJoCo's, of
# a height field.)
OUT_OF_MEMORY_MESSAGES = ("allocate memory", "insufficient memory", "failed to map segment", "unknown exception")
LIBRARY_ERRORS = (ImportError, OSError, RuntimeError, ValueError)


def _is_out_of_memory(error: Exception) -> bool:
    """True if an error was caused by the memory limit; call it before the process frees memory."""
    if isinstance(error, MemoryError):
        return True
    limit = address_space_limit()
    if limit is None or isinstance(error, InvalidInput):
        return False
    says_so = any(part in str(error) for part in OUT_OF_MEMORY_MESSAGES)
    return says_so or (isinstance(error, LIBRARY_ERRORS) and limit - used_address_space() < MIN_SPARE_BYTES)
