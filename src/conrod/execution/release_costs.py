"""Cost of a run in a release of an engine relative to another release: processes of both step in turns.

Each process measures the CPU time of its own blocks, so that neither the way to it nor waiting for the other counts.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from functools import partial
from types import TracebackType
from typing import Self

from conrod.engines import engine_named
from conrod.engines.capabilities import TimedStepping, require_capability
from conrod.errors import InvalidInput
from conrod.execution.paired_timing import Block, PairedTiming, cpu_time, time_block_pair, time_passes
from conrod.execution.releases import VersionCase, release_interpreter
from conrod.execution.worker_process import CallLimits, WorkerDied, WorkerProcess

BLOCK_TIMEOUT = 60.0  # [s] for a block of some ms


class ReleaseTimer:
    """Times runs in releases of an engine, each release in a separate process, started at its first run."""

    def __init__(self, requirement: Callable[[str], str]) -> None:
        """Start no process yet.

        Args:
            requirement: requirement for pip of a version, such as mujoco==3.6.0.
        """
        self._requirement = requirement
        self._processes: dict[tuple[str, int], WorkerProcess] = {}

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        for process in self._processes.values():
            process.end()

    def time(self, case: VersionCase, other: VersionCase) -> PairedTiming:
        """Time a step of a case, or a pass, against that in another release; two processes if both are of one release.

        Raises:
            InvalidInput: a release cannot step the case, or takes too long; says which.
        """
        return time_block_pair(lambda: (self._block(case, 0), self._block(other, 1)))

    def _block(self, case: VersionCase, which: int) -> Block:
        """Make the case's machine anew in the process, and return a function that advances it there."""
        self._call(case, which, prepare_stepper)
        return partial(self._call, case, which, advance_stepper)

    def _call(self, case: VersionCase, which: int, function: Callable[..., int], *arguments: int) -> int:
        key = (case.version, which)
        try:
            if key not in self._processes:
                python = release_interpreter(case.settings.engine, self._requirement(case.version), case.version)
                self._processes[key] = WorkerProcess(CallLimits(timeout=BLOCK_TIMEOUT), interpreter=python)
            return self._processes[key].call(function, case, *arguments)
        except (WorkerDied, TimeoutError) as error:
            self._processes.pop(key).end()
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
