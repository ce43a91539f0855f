"""Steps per revolution.

Iterations of the solver.

Time constant of what closes the joints.

Regularisation of the constraints.

The state rounded to single precision after each step.
"""

from __future__ import annotations

from typing import ClassVar

from conrod.mechanism.units import check_number
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
        return case.not_varied

    def spans(self, case: Case) -> tuple[tuple[float, float], ...]:
        return ((self.harmless, max(self.hopeless, float(case.fewest_steps))),)

    def cell(self, case: Case, value: float) -> LimitCell:
        return LimitCell(case.name, case.scene, case.settings(steps=round(value)))

    def text(self, case: Case, value: float) -> str:
        return f"{round(value)} steps"


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
        return case.not_varied

    def cell(self, case: Case, value: float) -> LimitCell:
        settings = case.variations.iterated(case.settings(), round(value))
        return LimitCell(case.name, case.scene, settings)

    def text(self, case: Case, value: float) -> str:
        return f"{round(value)} iterations" if value > 1.0 else "1 iteration"


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
        return case.not_varied

    def spans(self, case: Case) -> tuple[tuple[float, float], ...]:
        slow, fast = float(case.steps), self.hopeless
        settings = case.settings()
        own = min(max(settings.time_constant(case.contact) / settings.timestep, fast), slow)
        return tuple((own, end) for end in (slow, fast) if end != own)

    def cell(self, case: Case, value: float) -> LimitCell:
        settings = case.variations.stabilised(case.scene, case.settings(), value)
        return LimitCell(case.name, case.scene, settings)

    def text(self, case: Case, value: float) -> str:
        # An engine that cannot express so short a time mends all at once.
        at_once = self.cell(case, value).settings.time_constant(case.contact) == 0.0
        return f"{value:.4g} steps" + (" (all at once)" if at_once else "")


# What a contact's impedance lacks of one; MuJoCo admits no less than the second (mjMAXIMP).
CONTACT_HARMLESS, CONTACT_LEAST = 0.5, 1e-4


class Regularisation(Axis):
    """Of loops the share that is left of the engine's own, past the point where the forces lose their digits.

    Of a cam what the contact's impedance lacks of one. The preset's other settings stay.
    """

    name: ClassVar[str] = "regularisation"
    title: ClassVar[str] = "Regularisation left"
    label: ClassVar[str] = "share of the engine's own regularisation (contact: 1 - impedance)"
    scale: ClassVar[Scale] = Scale.LOG
    harmless: ClassVar[float] = 1.0
    hopeless: ClassVar[float] = 1e-15
    allowed: ClassVar[tuple[float, float]] = (1e-15, 1.0)

    def refusal(self, case: Case) -> str | None:
        if case.not_varied:
            return case.not_varied
        if case.variations.regularised(case.scene, case.settings(), self.harmless) is None:
            return f"{case.engine} does not regularise its constraints: {self.name} does not apply"
        return None

    def spans(self, case: Case) -> tuple[tuple[float, float], ...]:
        return ((CONTACT_HARMLESS, CONTACT_LEAST) if case.contact else (self.harmless, self.hopeless),)

    def cell(self, case: Case, value: float) -> LimitCell:
        if case.contact:
            check_number(f"{self.name} of a contact", value, CONTACT_LEAST, self.harmless)
        settings = case.variations.regularised(case.scene, case.settings(), value)
        assert settings is not None
        return LimitCell(case.name, case.scene, settings)

    def text(self, case: Case, value: float) -> str:
        return f"{value:.3g}"


class Rounding(Axis):
    """Off, or on: what an engine in single precision would make of the preset, at the least."""

    name: ClassVar[str] = "rounding"
    title: ClassVar[str] = "State rounded to single precision"
    label: ClassVar[str] = "rounded after each step (0: no, 1: yes)"
    scale: ClassVar[Scale] = Scale.LISTED

    def refusal(self, case: Case) -> str | None:
        return case.not_varied

    def values(self, case: Case) -> tuple[float, ...]:
        return (0.0, 1.0)

    def cell(self, case: Case, value: float) -> LimitCell:
        return LimitCell(case.name, case.scene, case.variations.rounded(case.settings(), bool(value)))

    def text(self, case: Case, value: float) -> str:
        return "single precision" if value else "double precision"
