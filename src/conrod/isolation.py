"""A run in a process of its own: what kills the process, hangs it or fills the memory is an outcome like any other."""

from __future__ import annotations

import multiprocessing
import signal
from collections.abc import Callable
from multiprocessing.connection import Connection

from conrod.engines import engine_named
from conrod.engines.engine import Machine
from conrod.errors import InvalidInput
from conrod.running import run
from conrod.trajectory import Outcome, Settings, Trajectory

Task = Callable[[Machine, Settings, float], Trajectory]
Answer = Trajectory | InvalidInput | Outcome


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
        timeout: longest time that the process may take [s].
        memory: largest address space that it may have [bytes], None for no limit.
        task: what to do there; a function that can be pickled.

    Raises:
        InvalidInput: as `run`.

    Returns:
        The trajectory, or one without samples that ended as crashed, timed-out or out-of-memory.
    """
    context = multiprocessing.get_context("spawn")
    receiver, sender = context.Pipe(duplex=False)
    process = context.Process(target=_work, args=(sender, task, machine, settings, revolutions, memory), daemon=True)
    process.start()
    sender.close()
    answer = _answer(receiver, timeout)
    if isinstance(answer, InvalidInput):
        process.join()
        raise answer
    if isinstance(answer, Trajectory):
        process.join()
        return answer
    if answer is None:
        process.kill()
        process.join()
        return _ended(machine, settings, revolutions, Outcome.TIMED_OUT, f"no result after {timeout:g} s")
    process.join()
    if answer is Outcome.OUT_OF_MEMORY:
        return _ended(machine, settings, revolutions, answer, f"the limit was {memory} bytes")
    return _ended(machine, settings, revolutions, Outcome.CRASHED, _how(process.exitcode))


def _answer(receiver: Connection, timeout: float) -> Answer | None:
    """What the process sent; crashed where it ended without a word, None where it is still silent."""
    if not receiver.poll(timeout):
        return None
    try:
        answer: Answer = receiver.recv()
    except EOFError:
        return Outcome.CRASHED
    return answer


def _work(
    sender: Connection, task: Task, machine: Machine, settings: Settings, revolutions: float, memory: int | None
) -> None:
    if memory is not None:
        import resource  # POSIX only; without a limit the rest works anywhere

        resource.setrlimit(resource.RLIMIT_AS, (memory, memory))
    try:
        answer: Answer = task(machine, settings, revolutions)
    except InvalidInput as error:
        answer = error
    except MemoryError:
        answer = Outcome.OUT_OF_MEMORY
    sender.send(answer)


def _how(exit_code: int | None) -> str:
    if exit_code is not None and exit_code < 0:
        return f"ended by signal {signal.Signals(-exit_code).name}"
    return f"ended with status {exit_code}"


def _ended(machine: Machine, settings: Settings, revolutions: float, outcome: Outcome, reason: str) -> Trajectory:
    return Trajectory(
        engine=settings.engine,
        engine_version=engine_named(settings.engine).version,
        settings=settings,
        speed=machine.speed,
        revolutions=revolutions,
        outcome=outcome,
        reason=reason,
        points={},
        bodies=None,
    )
