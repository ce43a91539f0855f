"""A run in a process of its own: what kills the process, hangs it or fills the memory is an outcome like any other."""

from __future__ import annotations

import pickle
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from typing import Any, TypeVar

from conrod.engines import engine_named
from conrod.engines.engine import Machine
from conrod.engines.running import run
from conrod.errors import portable
from conrod.runs.trajectory import Outcome, Settings, Trajectory
from conrod.studies.execution.child import (
    BEGUN,
    RESERVE,
    Child,
    KilledFromOutside,
    Owner,
    address_space,
    ran_out_of_memory,
)

Task = Callable[[Machine, Settings, float], Trajectory]
Result = TypeVar("Result")


@dataclass(frozen=True)
class Ended:
    """How a call in a process of its own ended without a result."""

    outcome: Outcome
    reason: str


@dataclass(frozen=True)
class _Returned:
    """What a call came to in the other process."""

    result: Any = None
    error: Exception | None = None


def isolated(
    task: Callable[..., Result],
    *arguments: Any,
    timeout: float | None = None,
    memory: int | None = None,
    headroom: int | None = None,
) -> Result | Ended:
    """What a function returns in a fresh process, or how that process ended.

    The process ends with the one that called, however that ends. Where it is killed from outside, the call is repeated
    once before that is believed.

    Args:
        task: what to do there; a function that can be pickled, as its arguments.
        timeout: longest time that the call may take there [s], from when it begins; None for no limit.
        memory: largest address space that the process may have [bytes], None for no limit.
        headroom: the same, counted from what the process has when the call begins [bytes].

    Raises:
        Exception: what the task raised there, other than MemoryError.
    """
    with suppress(KilledFromOutside):
        return isolated_once(task, *arguments, timeout=timeout, memory=memory, headroom=headroom)
    try:
        return isolated_once(task, *arguments, timeout=timeout, memory=memory, headroom=headroom)
    except KilledFromOutside as error:
        return Ended(Outcome.CRASHED, f"{error.how}, and again when it was repeated")


def isolated_once(
    task: Callable[..., Result],
    *arguments: Any,
    timeout: float | None = None,
    memory: int | None = None,
    headroom: int | None = None,
) -> Result | Ended:
    """As `isolated`, for a part of a cell, which its executor repeats as a whole and with nothing beside it.

    Raises:
        KilledFromOutside: the process was killed, and not by conrod.
    """
    child = Child("conrod.studies.execution.isolation")
    try:
        child.send(pickle.dumps((task, arguments, memory, headroom)))
        # To start takes longer than many a call; what cannot be unpickled there has no beginning.
        first = child.receive()
        answer: _Returned = pickle.loads(child.receive(timeout) if first == BEGUN else first)
    except TimeoutError as error:
        return Ended(Outcome.TIMED_OUT, str(error))
    except EOFError:
        return Ended(Outcome.CRASHED, child.how_it_ended())
    finally:
        # Also where the wait was interrupted.
        child.end()
    if isinstance(answer.error, MemoryError):
        return Ended(Outcome.OUT_OF_MEMORY, _limit(memory, headroom) or str(answer.error))
    if answer.error is not None:
        raise answer.error
    result: Result = answer.result
    return result


def run_isolated(
    machine: Machine,
    settings: Settings,
    revolutions: float = 2.0,
    *,
    timeout: float,
    memory: int | None = None,
    task: Task = run,
) -> Trajectory:
    """As `run`, in a process of its own.

    Args:
        timeout: longest time that the run may take [s].
        memory: largest address space that the process may have [bytes], None for no limit.
        task: what to do there; a function that can be pickled.

    Raises:
        InvalidInput: as `run`.

    Returns:
        The trajectory, or one without samples that ended as crashed, timed-out or out-of-memory.
    """
    answer = isolated(task, machine, settings, revolutions, timeout=timeout, memory=memory)
    if isinstance(answer, Trajectory):
        return answer
    return Trajectory(
        engine=settings.engine,
        engine_version=engine_named(settings.engine).version,
        settings=settings,
        speed=machine.speed,
        revolutions=revolutions,
        outcome=answer.outcome,
        reason=answer.reason,
        points={},
        bodies=None,
    )


def main(owner: Owner) -> None:
    """Answer the one call that comes, in the process that was started for it."""
    reserve = bytearray()
    try:
        task, arguments, memory, headroom = pickle.loads(owner.receive())
        reserve = bytearray(RESERVE)
        owner.send(BEGUN)
        _confine(memory, headroom)
        # Within the limits too: a result that there is no memory to send is none.
        answer = pickle.dumps(_Returned(task(*arguments)))
    except Exception as error:
        ran_out = ran_out_of_memory(error)
        reserve.clear()
        answer = pickle.dumps(_Returned(error=MemoryError(str(error)) if ran_out else portable(error)))
    owner.send(answer)


def _confine(memory: int | None, headroom: int | None) -> None:
    """Limit the address space of this process, within what it was itself started with."""
    if memory is None and headroom is None:
        return
    import resource  # POSIX only; without a limit the rest works anywhere

    _, most = resource.getrlimit(resource.RLIMIT_AS)
    limits = [memory, None if headroom is None else address_space() + headroom]
    least = min(limit for limit in (*limits, None if most == resource.RLIM_INFINITY else most) if limit is not None)
    resource.setrlimit(resource.RLIMIT_AS, (least, least))


def _limit(memory: int | None, headroom: int | None) -> str:
    told = [
        *([] if memory is None else [f"{memory} bytes"]),
        *([] if headroom is None else [f"{headroom} bytes more than it began with"]),
    ]
    return f"the limit was {' and '.join(told)}" if told else ""
