"""A worker process from inside: it answers one pickled call after another, until its owner is gone.

A process that runs many cases of one scene computes the scene's tables once.
"""

from __future__ import annotations

import fcntl
import os
import pickle
import resource
import signal
import threading
from collections.abc import Callable
from dataclasses import replace
from functools import lru_cache
from multiprocessing.connection import Connection
from queue import SimpleQueue
from typing import TypeVar

from conrod import engines
from conrod.engines.plugin_values import EngineFault, error_line
from conrod.errors import InvalidInput, portable
from conrod.runs.trajectory import Outcome
from conrod.scenes import Scene
from conrod.studies.frame.case import Case, Measurement

Result = TypeVar("Result")
AnyCase = TypeVar("AnyCase", bound=Case)

# A sweep has few scenes, a map of limits one in each of its rows; each takes 0.8 MB.
SCENES_KEPT = 128


def perform(case: Case) -> Measurement:
    """The result of a case, for a worker process to be called with.

    What an engine of another package raises is the end of that run; where conrod's own do, conrod is at fault.
    """
    if (engine := case.plugin_name) is None:
        return case.perform()
    loaded = engines.engine_named(engine)
    before = getattr(loaded, "handed_over", 0)
    try:
        return case.perform()
    except Exception as error:
        # What conrod refuses before the engine has handed anything over is a mistake in what was asked for.
        asked = isinstance(error, InvalidInput) and getattr(loaded, "handed_over", 0) == before
        if asked or _out_of_memory(error):
            raise
        said = str(error) if isinstance(error, EngineFault) else f"{type(error).__name__}: {error_line(error)}"
        return Measurement(Outcome.CRASHED.slug, said)


def on_known_scene(task: Callable[[AnyCase], Result], case: AnyCase) -> Result:
    """The result of a task with a case whose scene is the equal one that this process has met before, if it has.

    A case that arrives from another process brings its scene's parameters alone. Tables that are computed from them
    take longer than most runs.
    """
    return task(replace(case, scene=_known(case.scene)))


@lru_cache(SCENES_KEPT)
def _known(scene: Scene) -> Scene:
    return scene


# -- the process ------------------------------------------------------------------------------------------------------


HIDDEN = 200  # least descriptor of the connection: an engine that writes into a wrong one writes into a lower


def main(pipe: int, memory: int | None) -> None:
    """Serve calls until their owner ends.

    Args:
        pipe: descriptor of the owner's connection.
        memory: address space that a call may take beyond what this process has when it begins [bytes].
    """
    engines.load_plugin = engines.load_plugin_here  # this process is there for what an engine may do to it
    # Closed in what an engine starts, and where nobody writes who means another file.
    least = min(HIDDEN, resource.getrlimit(resource.RLIMIT_NOFILE)[0] // 2)
    hidden = fcntl.fcntl(pipe, fcntl.F_DUPFD_CLOEXEC, least)
    os.close(pipe)
    owner, calls, served_by = Connection(hidden), SimpleQueue[bytes](), os.getpid()
    threading.Thread(target=_listen, args=(owner, calls), daemon=True).start()
    reserve = bytearray(0 if memory is None else RESERVE)
    while True:
        call = calls.get()
        # Before the call is looked at: to unpickle it may take the process down.
        owner.send(None)
        answer = _answer(call, reserve, memory)
        if os.getpid() != served_by:
            os._exit(0)  # an engine has forked, and this copy came back from its call, too
        owner.send_bytes(answer)


def _listen(owner: Connection, calls: SimpleQueue[bytes]) -> None:
    """Receive calls; the end of the owner is the end of this process, busy or not."""
    while True:
        try:
            calls.put(owner.recv_bytes())
        except (EOFError, OSError):
            _leave()


def _leave() -> None:
    """End this process, and what an engine has forked, which nobody else is there to end."""
    if os.getpgrp() == os.getpid():
        os.killpg(os.getpid(), signal.SIGKILL)
    os._exit(0)


def _answer(call: bytes, reserve: bytearray, memory: int | None) -> bytes:
    """The pickled pair of whether the call returned, and what it returned or raised."""
    try:
        function, arguments, named = pickle.loads(call)
        if memory is not None:
            _limit(address_space() + memory)
        # Within the limits too: a result that there is no memory to send is none.
        return pickle.dumps((True, function(*arguments, **named)))
    except Exception as error:  # the caller's, whatever it is: it is raised again there
        if _out_of_memory(error):
            reserve.clear()
            return pickle.dumps((False, MemoryError(str(error))))
        return pickle.dumps((False, portable(error)))


# -- its memory -------------------------------------------------------------------------------------------------------

# Kept back by a process whose memory is limited: to say that all is taken takes some.
RESERVE = 1 << 24  # bytes
# Less than this is too little for an engine to load its libraries, compile a model or make its state. (With 32 MB left,
# MuJoCo fails in a handful of ways, of which only some say why; with 64 MB it does not.)
SPARE = 1 << 26  # bytes
# What libraries say that were given no memory, and as what kinds of error. (The last is MuJoCo's of a height field.)
SIGNS = ("allocate memory", "insufficient memory", "failed to map segment", "unknown exception")
FOREIGN = (ImportError, OSError, RuntimeError, ValueError)


def address_space() -> int:
    """Address space of this process [bytes]; 0 where the system does not say."""
    try:
        with open("/proc/self/statm", encoding="ascii") as file:
            return int(file.read().split()[0]) * os.sysconf("SC_PAGE_SIZE")
    except FileNotFoundError:
        return 0


def _limit(memory: int) -> None:
    """Limit the address space [bytes] of this process, within what it was itself started with."""
    _, most = resource.getrlimit(resource.RLIMIT_AS)
    least = memory if most == resource.RLIM_INFINITY else min(memory, most)
    resource.setrlimit(resource.RLIMIT_AS, (least, most))


def _out_of_memory(error: Exception) -> bool:
    """True if an error came of this process's memory limit; to be asked before what the process holds is let go."""
    if isinstance(error, MemoryError):
        return True
    limit, _ = resource.getrlimit(resource.RLIMIT_AS)
    if limit == resource.RLIM_INFINITY or isinstance(error, InvalidInput):
        return False
    said = any(sign in str(error) for sign in SIGNS)
    return said or (isinstance(error, FOREIGN) and limit - address_space() < SPARE)
