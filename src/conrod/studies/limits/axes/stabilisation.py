"""Time constant of what closes the joints."""

from __future__ import annotations

from typing import ClassVar

from conrod.studies.limits.axis import Axis, Scale
from conrod.studies.limits.case import Case
from conrod.studies.limits.cell import LimitCell


class Stabilisation(Axis):
    """From the preset's own two ways: as slow as a revolution, and shorter than a step; of a cam that of the contact.

    Either end may be the hopeless one: what is hard by itself may be closed slowly, what is soft has to be closed fast.
    The preset's other settings stay.
    """

    name: ClassVar[str] = "stabilisation"
    title: ClassVar[str] = "Time constant of stabilisation"
    label: ClassVar[str] = "time constant (steps)"
    scale: ClassVar[Scale] = Scale.LOG
    harmless: ClassVar[float] = 1000.0
    hopeless: ClassVar[float] = 0.1
    allowed: ClassVar[tuple[float, float]] = (0.01, 1e6)

    def refusal(self, case: Case) -> str | None:
        return None

    def spans(self, case: Case) -> tuple[tuple[float, float], ...]:
        slow, fast = float(case.steps), self.hopeless
        settings = case.settings()
        own = min(max(settings.time_constant(case.contact) / settings.timestep, fast), slow)
        return tuple((own, end) for end in (slow, fast) if end != own)

    def cell(self, case: Case, value: float) -> LimitCell:
        settings = case.made_by.variations.stabilised(case.scene, case.settings(), value)
        return LimitCell(case.name, case.scene, settings)

    def text(self, case: Case, value: float) -> str:
        # An engine that cannot express so short a time mends all at once.
        at_once = self.cell(case, value).settings.time_constant(case.contact) == 0.0
        return f"{value:.4g} steps" + (" (all at once)" if at_once else "")
