"""A process that runs many cases of one scene computes the scene's tables once.

What runs in a worker process: one call after another, as they come in, until its owner is gone.

Calls and answers are pickled.
"""

from __future__ import annotations

import pickle
from collections.abc import Callable
from dataclasses import replace
from functools import lru_cache
from typing import TypeVar

from conrod.errors import InvalidInput, portable
from conrod.scenes import Scene
from conrod.studies.execution.child import BEGUN, RESERVE, Owner, address_space, ran_out_of_memory
from conrod.studies.frame.case import Case
from conrod.studies.frame.measurement import Measurement

Result = TypeVar("Result")
AnyCase = TypeVar("AnyCase", bound=Case)

# A sweep has few scenes, a map of limits one in each of its rows; each takes 0.8 MB.
SCENES_KEPT = 128


def perform(case: Case) -> Measurement:
    """The result of a case, for a worker process to be called with."""
    return case.perform()


def on_known_scene(task: Callable[[AnyCase], Result], case: AnyCase) -> Result:
    """The result of a task with a case whose scene is the equal one that this process has met before, if it has.

    A case that arrives from another process brings its scene's parameters alone. Tables that are computed from them
    take longer than most runs.
    """
    return task(replace(case, scene=_known(case.scene)))


@lru_cache(SCENES_KEPT)
def _known(scene: Scene) -> Scene:
    return scene


def main(owner: Owner, memory: int | None) -> None:
    """Serve calls until their owner ends.

    Args:
        owner: whose calls they are.
        memory: largest address space of this process [bytes], None for no limit.
    """
    reserve = bytearray(0 if memory is None else RESERVE)
    owner.send(pickle.dumps(_limit(memory)))
    while True:
        call = owner.receive()
        # Before the call is looked at: to unpickle it may take the process down.
        owner.send(BEGUN)
        owner.send(_answer(call, reserve))


def _limit(memory: int | None) -> InvalidInput | None:
    """Limit this process; the answer says why it cannot be."""
    if memory is None:
        return None
    import resource  # POSIX only; without a limit the rest works anywhere

    import conrod.studies.frame.run  # noqa: F401  what every case loads is loaded before the limit is compared

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
