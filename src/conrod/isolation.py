"""A run in a process of its own: what kills the process, hangs it or fills the memory is an outcome like any other."""

from __future__ import annotations

import multiprocessing
import os
import pickle
import threading
from collections.abc import Callable
from dataclasses import dataclass
from multiprocessing.connection import Connection
from typing import Any, TypeVar

from conrod.engines import engine_named
from conrod.engines.engine import Machine
from conrod.errors import portable
from conrod.process import RESERVE, address_space, how_it_ended, ran_out_of_memory
from conrod.running import run
from conrod.trajectory import Outcome, Settings, Trajectory

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

    The process ends with the one that called, however that ends.

    Args:
        task: what to do there; a function that can be pickled, as its arguments.
        timeout: longest time that the call may take there [s], from when it begins; None for no limit.
        memory: largest address space that the process may have [bytes], None for no limit.
        headroom: the same, counted from what the process has when the call begins [bytes].

    Raises:
        Exception: what the task raised there, other than MemoryError.
    """
    context = multiprocessing.get_context("spawn")
    receiver, sender = context.Pipe(duplex=False)
    process = context.Process(target=_work, args=(sender, task, arguments, memory, headroom), daemon=True)
    process.start()
    sender.close()
    try:
        # Its first word is that it begins: to start takes longer than many a call.
        receiver.recv()
        if not receiver.poll(timeout):
            return Ended(Outcome.TIMED_OUT, f"no result after {timeout:g} s")
        answer: _Returned = pickle.loads(receiver.recv_bytes())
    except EOFError:
        process.join()
        return Ended(Outcome.CRASHED, how_it_ended(process.exitcode))
    finally:
        # Also where the wait was interrupted.
        process.kill()
        process.join()
        receiver.close()
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


def _work(
    sender: Connection,
    task: Callable[..., Any],
    arguments: tuple[Any, ...],
    memory: int | None,
    headroom: int | None,
) -> None:
    _end_with_owner()
    reserve = bytearray(RESERVE)
    sender.send(None)
    try:
        _confine(memory, headroom)
        # Within the limits too: a result that there is no memory to send is none.
        answer = pickle.dumps(_Returned(task(*arguments)))
    except Exception as error:
        ran_out = ran_out_of_memory(error)
        reserve.clear()
        answer = pickle.dumps(_Returned(error=MemoryError(str(error)) if ran_out else portable(error)))
    sender.send_bytes(answer)


def _end_with_owner() -> None:
    """A call that never ends must not outlive the one who waits for it."""
    owner = multiprocessing.parent_process()
    assert owner is not None

    def follow() -> None:
        owner.join()
        os._exit(1)

    threading.Thread(target=follow, daemon=True).start()


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
