"""Steps per revolution."""

from __future__ import annotations

from typing import ClassVar

from conrod.studies.limits.axis import Axis, Scale
from conrod.studies.limits.case import Case
from conrod.studies.limits.cell import LimitCell


class Steps(Axis):
    """From a fine step to two in a revolution, or three in a pass; a rule that follows the step follows it here too."""

    name: ClassVar[str] = "steps"
    title: ClassVar[str] = "Steps per revolution"
    label: ClassVar[str] = "steps per revolution"
    scale: ClassVar[Scale] = Scale.COUNT
    harmless: ClassVar[float] = 20000.0
    hopeless: ClassVar[float] = 2.0
    allowed: ClassVar[tuple[float, float]] = (2.0, 1e6)

    def refusal(self, case: Case) -> str | None:
        return None

    def spans(self, case: Case) -> tuple[tuple[float, float], ...]:
        return ((self.harmless, max(self.hopeless, float(case.fewest_steps))),)

    def cell(self, case: Case, value: float) -> LimitCell:
        return LimitCell(case.name, case.scene, case.settings(steps=round(value)))

    def text(self, case: Case, value: float) -> str:
        return f"{round(value)} steps"
