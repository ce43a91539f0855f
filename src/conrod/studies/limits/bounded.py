"""A run that has limits of its own, in a process of its own, whatever those of the executor are."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from conrod.isolation import Ended, isolated_once
from conrod.studies.cell import Cell
from conrod.studies.limits.cell import LimitCell
from conrod.studies.limits.perform import perform
from conrod.studies.limits.watch import watch
from conrod.studies.measurement import Measurement, measure

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

    def _identity(self, parameters: dict[str, float] | None) -> dict[str, Any]:
        bounds = {"timeout": self.timeout, "headroom": self.headroom, "whole": self.whole}
        return super()._identity(parameters) | {"bounds": bounds}


@perform.register
def _bounded(cell: BoundedCell) -> Measurement:
    answer = isolated_once(_run, cell, timeout=cell.timeout, headroom=cell.headroom)
    return Measurement(answer.outcome.slug, answer.reason) if isinstance(answer, Ended) else answer


def _run(cell: BoundedCell) -> Measurement:
    if not cell.whole:
        return watch(cell)
    return measure(Cell(cell.name, cell.scene, cell.settings, cell.revolutions, cell.start_angle))
