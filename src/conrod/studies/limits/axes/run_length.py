"""Revolutions in one run."""

from __future__ import annotations

from typing import ClassVar

from conrod.studies.limits.axis import Axis, Scale
from conrod.studies.limits.case import Case
from conrod.studies.limits.cell import LimitCell

# So few that very many revolutions are affordable, and so many that the tuned presets are still within a hundredth: of
# the linkages' travel 7e-6 to 5e-3 over a thousand revolutions, of the cam's 4e-3 and 5e-3 over ten.
LINKAGE_STEPS, CONTACT_STEPS = 50, 1000


class RunLength(Axis):
    """One run, by the preset's rule at few steps per revolution.

    The usual end is what an ordinary study affords; `allowed` is how far a range may reach.
    """

    name: ClassVar[str] = "run-length"
    title: ClassVar[str] = "Length of the run"
    label: ClassVar[str] = "revolutions"
    scale: ClassVar[Scale] = Scale.COUNT
    harmless: ClassVar[float] = 1.0
    hopeless: ClassVar[float] = 1000.0
    allowed: ClassVar[tuple[float, float]] = (1.0, 1e6)

    def refusal(self, case: Case) -> str | None:
        if case.one_pass:
            return f"the input of {case.scene.kind} makes one pass and no more: {self.name} does not apply"
        return None

    def cell(self, case: Case, value: float) -> LimitCell:
        steps = CONTACT_STEPS if case.contact else LINKAGE_STEPS
        return LimitCell(case.name, case.scene, case.settings(steps=steps), revolutions=float(round(value)))

    def text(self, case: Case, value: float) -> str:
        return f"{round(value)} revolutions" if value > 1.0 else "1 revolution"
