"""CPU time of a run with nothing recorded, also as a ratio to the engine's fixed reference loop.

The reference loop is timed just before each repeat, in the same process, so that a ratio carries from one machine to
another.
"""

from __future__ import annotations

import math
import os
import platform
import time
from collections.abc import Callable, Sequence
from concurrent.futures import Future
from contextlib import suppress
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from conrod.comparison.trajectory import Settings
from conrod.engines import Engine, engine_named
from conrod.engines.engine import Machine, run_extent
from conrod.engines.plugin_values import EngineFault
from conrod.execution.local import LocalProcesses
from conrod.execution.runner import Runner, process_unclaimed
from conrod.execution.worker import call_with_cached_scene
from conrod.execution.worker_process import WorkerDied

if TYPE_CHECKING:
    from conrod.execution.run import RunCase

REPEATS = 3
REFERENCE_STEPS = 1000
# A repeat is at least this long [s], in whole revolutions: far above what the clock and the calls cost.
MIN_REPEAT_TIME = 5e-3
MAX_REPEAT_REVOLUTIONS = 1000
STEPS_PER_CALL = 2000  # steps in one call of the engine

# CPU time of the process [ns]: an engine may step in threads of its own, as MJX does.
Clock = Callable[[], int]


def time_run(
    engine: Engine[Any],
    machine: Machine,
    settings: Settings,
    *,
    clock: Clock = time.process_time_ns,
) -> Timing | None:
    """Measure the least CPU time of a revolution over some repeats, after a warm-up.

    An input that makes one pass makes it as often as a repeat is long, and each time a new machine.

    Args:
        settings: of this engine, such that a run with them completes: what a step costs after a run has diverged is
            of no use, and may be fifty times as much (MuJoCo, cam).

    Returns:
        The timing; None where the engine cannot be timed, or breaks off when it makes many steps at once.
    """
    from conrod.engines.capabilities import MissingCapability, TimedStepping, capability, failure_of

    made = capability(engine, TimedStepping)
    if isinstance(made, MissingCapability):
        return None
    reference, advance = made.reference_loop(), made.stepper(machine, settings)
    turns, turn = machine.kinematics.mechanism.driver.span is None, settings.steps_per_revolution
    length = round(turn * run_extent(machine, turn, 1.0)[1])  # a revolution, or the pass
    reference(REFERENCE_STEPS)
    first = min(length, STEPS_PER_CALL)
    warm_up = _cpu_time([(advance, first)], clock)
    # [ns]; a clock too coarse to see a revolution does not ask for endlessly many.
    turn_time = max(warm_up * length / first, 1e9 * MIN_REPEAT_TIME / MAX_REPEAT_REVOLUTIONS)
    runs = math.ceil(1e9 * MIN_REPEAT_TIME / turn_time)
    steps = runs * length
    references, spent = list[int](), list[int]()
    for _ in range(REPEATS):
        # In turns, so that whatever else the machine is doing then slows both alike.
        timed = [(advance, steps)] if turns else [(made.stepper(machine, settings), length) for _ in range(runs)]
        references.append(_cpu_time([(reference, REFERENCE_STEPS)], clock))
        spent.append(_cpu_time(timed, clock))
        if any(failure_of(stepper) for stepper, _ in timed):
            return None
    seconds, reference_seconds = 1e-9 * min(spent) * turn / steps, 1e-9 * min(references) / REFERENCE_STEPS
    return Timing(seconds, reference_seconds, seconds / reference_seconds, steps, len(spent), machine_fingerprint())


def _cpu_time(timed: Sequence[tuple[Callable[[int], None], int]], clock: Clock) -> int:
    """CPU time [ns] of some steppers, each with its number of steps."""
    begin = clock()
    for advance, steps in timed:
        for done in range(0, steps, STEPS_PER_CALL):
            advance(min(STEPS_PER_CALL, steps - done))
    return clock() - begin


@cache
def machine_fingerprint() -> str:
    """Name of this machine in timings: processor, number of cores, version of Python.

    The engine's version is not in it: it is part of a case's key.
    """
    return f"{_processor()}, {os.cpu_count()} cores, Python {platform.python_version()}"


def _processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        lines = []
    models = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return models[0] if models else platform.processor() or platform.machine()


@dataclass(frozen=True)
class Timing:
    """CPU time of a case on one machine, the least of several repeats.

    Attributes:
        seconds_per_revolution: CPU time of one simulated revolution [s].
        reference_seconds: CPU time of one step of the engine's fixed reference loop, timed just before in the same
            process [s].
        ratio: the first over the second: a revolution costs as much as so many steps of the reference loop.
        steps: time steps that were timed in each repeat.
        repeats: number of times that the run was timed.
        machine: fingerprint of the machine, for people and to tell machines apart.
    """

    seconds_per_revolution: float
    reference_seconds: float
    ratio: float
    steps: int
    repeats: int
    machine: str


# -- timings of many cases, kept in the ledger -------------------------------------------------------------------------


def time_cases(runner: Runner, cases: Sequence[RunCase]) -> dict[str, Timing]:
    """Time the cases that the ledger of a runner has no timing of; return the timings of all by key.

    Each is timed in a process of this machine, even if its run was made on a cluster: timings of different machines
    cannot be compared. A case that cannot be timed within the limit, or whose process dies, has no timing.
    """
    by_key, ledger, fresh = {case.key: case for case in cases}, runner.ledger, runner.runs.fresh
    known = {} if fresh else ledger.timings(by_key, machine_fingerprint())

    def keep_timing(case: RunCase, future: Future[Timing | None]) -> str:
        timing = None
        # The outcome of the run says what went wrong; a failed timing adds nothing to it.
        with suppress(WorkerDied, TimeoutError, MemoryError, EngineFault):
            timing = future.result()
        if timing is None:
            return "without a timing"
        ledger.keep_timing(case, timing)
        return "timed"

    with runner.runs.progress("costs", "timed") as watcher, LocalProcesses(1, timeout=runner.runs.timeout) as worker:
        watcher.on_start(len(by_key), len(known))
        process_unclaimed(
            [case for key, case in by_key.items() if key not in known],
            ledger,
            watcher,
            # One timing at a time, by all processes of this machine on this ledger.
            claim_name=lambda _: f"timing on {machine_fingerprint()}",
            is_unfinished=lambda case: fresh or case.key not in ledger.timings([case.key], machine_fingerprint()),
            submit=lambda case: worker.submit(call_with_cached_scene, _time_case, case),
            keep_result=keep_timing,
            max_in_flight=lambda: 1,
        )
    return ledger.timings(by_key, machine_fingerprint())


def _time_case(case: RunCase) -> Timing | None:
    """Time the run of a case in this process; None if its engine cannot be timed."""
    return time_run(engine_named(case.settings.engine), case.scene, case.settings)
