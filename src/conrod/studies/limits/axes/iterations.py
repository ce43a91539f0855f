"""Iterations of the solver."""

from __future__ import annotations

from typing import ClassVar

from conrod.studies.limits.axis import Axis, Scale
from conrod.studies.limits.case import Case
from conrod.studies.limits.cell import LimitCell


class Iterations(Axis):
    """From more than a preset takes to a single one; an engine that is done earlier stops earlier."""

    name: ClassVar[str] = "iterations"
    title: ClassVar[str] = "Solver iterations"
    label: ClassVar[str] = "iterations allowed in a step"
    scale: ClassVar[Scale] = Scale.COUNT
    harmless: ClassVar[float] = 1000.0
    hopeless: ClassVar[float] = 1.0
    allowed: ClassVar[tuple[float, float]] = (1.0, 1e5)

    def refusal(self, case: Case) -> str | None:
        return None

    def cell(self, case: Case, value: float) -> LimitCell:
        settings = case.made_by.variations.iterated(case.settings(), round(value))
        return LimitCell(case.name, case.scene, settings)

    def text(self, case: Case, value: float) -> str:
        return f"{round(value)} iterations" if value > 1.0 else "1 iteration"
