"""What an executor does with a cell at an engine's limits; importable, so that any worker process can."""

from __future__ import annotations

from functools import singledispatch

from conrod.studies.limits.cell import LimitCell
from conrod.studies.limits.watch import watch
from conrod.studies.measurement import Measurement


@singledispatch
def perform(cell: LimitCell) -> Measurement:
    """The measurement of a cell, by its kind."""
    return watch(cell)
