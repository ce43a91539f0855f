"""Cost of a run in a release of an engine relative to another release: processes of both step in turns.

Each process measures the CPU time of its own blocks, so that neither the way to it nor waiting for the other counts.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from functools import partial

from conrod.engines import engine_named
from conrod.engines.capabilities import TimedStepping, require_capability
from conrod.errors import InvalidInput
from conrod.execution.paired_timing import Block, PairedTiming, cpu_time, time_block_pair, time_passes
from conrod.execution.releases import ReleaseProcesses, VersionCase
from conrod.execution.worker_process import WorkerDied

BLOCK_TIMEOUT = 60.0  # [s] for a block of some ms


def time_in_releases(processes: ReleaseProcesses, case: VersionCase, other: VersionCase) -> PairedTiming:
    """Time a step of a case, or a pass, against that in another release; two processes if both are of one release.

    Raises:
        InvalidInput: a release cannot step the case, or takes too long; says which.
    """
    return time_block_pair(lambda: (_block(processes, case, 0), _block(processes, other, 1)))


def _block(processes: ReleaseProcesses, case: VersionCase, which: int) -> Block:
    """Make the case's machine anew in a process, and return a function that advances it there."""
    _call(processes, case, which, prepare_stepper)
    return partial(_call, processes, case, which, advance_stepper)


def _call(
    processes: ReleaseProcesses, case: VersionCase, which: int, function: Callable[..., int], *arguments: int
) -> int:
    try:
        return int(processes.call(case.version, which, function, case, *arguments))
    except (WorkerDied, TimeoutError) as error:
        raise InvalidInput(f"{case.settings.engine} {case.version}: {error}") from None


# -- in the process of a release ---------------------------------------------------------------------------------------

_steppers: list[Block] = []  # of the case that the process steps now; an earlier one is let go


def prepare_stepper(case: VersionCase) -> int:
    """Make the machine of a case in this process; return 0.

    Raises:
        InvalidInput: the release cannot make it.
    """
    _steppers.clear()
    try:
        make = require_capability(engine_named(case.settings.engine), TimedStepping).stepper
        if case.scene.kinematics.mechanism.driver.span is None:
            _steppers.append(partial(cpu_time, make(case.scene, case.settings), 1, time.thread_time_ns))
        else:
            _steppers.append(partial(time_passes, make, case.scene, case.settings, time.thread_time_ns))
    except Exception as error:  # of any kind: an old release may fail in any way
        raise InvalidInput(f"{case.settings.engine} {case.version}: {type(error).__name__}: {error}") from None
    return 0


def advance_stepper(case: VersionCase, units: int) -> int:
    """Advance the machine of a case, which was made before, by steps or passes; return the CPU time [ns]."""
    return _steppers[0](units)
