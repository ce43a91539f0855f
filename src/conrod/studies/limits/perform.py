"""The memory that a run at an engine's limits takes: that of one piece, however long the run.

A run that has limits of its own, in a process of its own, whatever those of the executor are.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from conrod.engines import engine_named, engine_names
from conrod.errors import InvalidInput
from conrod.studies.execution.child import address_space
from conrod.studies.execution.isolation import Ended, isolated, isolated_once
from conrod.studies.frame.measurement import Measurement
from conrod.studies.frame.run import RunCase, measure
from conrod.studies.limits.cell import LimitCell
from conrod.studies.limits.stream_run import watch

# Beyond what a process starts with [bytes]; measured: 73 to 108 MB, the most for a cam in MuJoCo.
OF_A_RUN = 128_000_000
PATIENCE = 120.0  # [s], for a process to start


def check_memory(limit: int | None) -> None:
    """Refuse a limit in which not every run could end as it would without one.

    Args:
        limit: address space of a process [bytes]; None is none.

    Raises:
        InvalidInput: with both figures.
    """
    if limit is None:
        return
    begins_with = isolated(_at_the_start, timeout=PATIENCE)
    if isinstance(begins_with, Ended):
        return  # what stops every process is told by the first that runs a cell
    if limit < begins_with + OF_A_RUN:
        raise InvalidInput(
            f"a cell's memory limit of {limit} bytes is too little: a run may need {begins_with + OF_A_RUN}, "
            f"{begins_with} of which a process starts with"
        )


def _at_the_start() -> int:
    for name in engine_names():
        engine_named(name)
    return address_space()


MINUTE = 60.0  # [s]


@dataclass(frozen=True)
class BoundedCell(LimitCell):
    """A run within limits.

    Attributes:
        timeout: longest time that it may take [s].
        headroom: most memory that it may take beyond what its process begins with [bytes], None for no limit.
        whole: kept whole and compared at its end, as the runs of a sweep are, rather than streamed.
    """

    timeout: float = MINUTE
    headroom: int | None = None
    whole: bool = False

    def perform(self) -> Measurement:
        answer = isolated_once(_run, self, timeout=self.timeout, headroom=self.headroom)
        return Measurement(answer.outcome.slug, answer.reason) if isinstance(answer, Ended) else answer

    def _identity(self, parameters: dict[str, float] | None) -> dict[str, Any]:
        bounds = {"timeout": self.timeout, "headroom": self.headroom, "whole": self.whole}
        return super()._identity(parameters) | {"bounds": bounds}


def _run(cell: BoundedCell) -> Measurement:
    if not cell.whole:
        return watch(cell)
    return measure(RunCase(cell.name, cell.scene, cell.settings, cell.revolutions, cell.start_angle))
