"""The state rounded to single precision after each step."""

from __future__ import annotations

from typing import ClassVar

from conrod.studies.limits.axis import Axis, Scale
from conrod.studies.limits.case import Case
from conrod.studies.limits.cell import LimitCell


class Rounding(Axis):
    """Off, or on: what an engine in single precision would make of the preset, at the least."""

    name: ClassVar[str] = "rounding"
    title: ClassVar[str] = "State rounded to single precision"
    label: ClassVar[str] = "rounded after each step (0: no, 1: yes)"
    scale: ClassVar[Scale] = Scale.LISTED

    def refusal(self, case: Case) -> str | None:
        return None

    def values(self, case: Case) -> tuple[float, ...]:
        return (0.0, 1.0)

    def cell(self, case: Case, value: float) -> LimitCell:
        return LimitCell(case.name, case.scene, case.made_by.variations.rounded(case.settings(), bool(value)))

    def text(self, case: Case, value: float) -> str:
        return "single precision" if value else "double precision"
