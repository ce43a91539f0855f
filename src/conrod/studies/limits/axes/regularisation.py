"""Regularisation of the constraints."""

from __future__ import annotations

from typing import ClassVar

from conrod.ranges import check_number
from conrod.studies.limits.axis import Axis, Scale
from conrod.studies.limits.case import Case
from conrod.studies.limits.cell import LimitCell

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
        if case.made_by.variations.regularised(case.scene, case.settings(), self.harmless) is None:
            return f"{case.engine} does not regularise its constraints: {self.name} does not apply"
        return None

    def spans(self, case: Case) -> tuple[tuple[float, float], ...]:
        return ((CONTACT_HARMLESS, CONTACT_LEAST) if case.contact else (self.harmless, self.hopeless),)

    def cell(self, case: Case, value: float) -> LimitCell:
        if case.contact:
            check_number(f"{self.name} of a contact", value, CONTACT_LEAST, self.harmless)
        settings = case.made_by.variations.regularised(case.scene, case.settings(), value)
        assert settings is not None
        return LimitCell(case.name, case.scene, settings)

    def text(self, case: Case, value: float) -> str:
        return f"{value:.3g}"
