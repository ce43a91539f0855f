"""Crank speed at a fixed step."""

from __future__ import annotations

import math
from typing import ClassVar

from conrod.studies.limits.axis import Axis, Scale
from conrod.studies.limits.case import Case
from conrod.studies.limits.cell import LimitCell

STEP = 0.6e-3  # [s]; divides the revolutions of 1 rpm and of 50000 rpm, into a hundred thousand and into two
STEPS_AT_ONE_RPM = 60.0 / STEP


class CrankSpeed(Axis):
    """The same machine, the same step [s], another speed.

    A revolution has a whole number of steps, so only speeds that make it so exist: 100000 rpm over 2, 3, 4 .. The sense
    of rotation stays. A cam's preload stays the multiple that it is: how one lets go of its cam is another axis.
    """

    name: ClassVar[str] = "speed"
    title: ClassVar[str] = "Crank speed at a fixed step of 0.6 ms"
    label: ClassVar[str] = "crank speed (rpm)"
    scale: ClassVar[Scale] = Scale.LOG
    harmless: ClassVar[float] = 1.0
    hopeless: ClassVar[float] = 50000.0
    allowed: ClassVar[tuple[float, float]] = (1.0, 50000.0)

    def refusal(self, case: Case) -> str | None:
        return None

    def spans(self, case: Case) -> tuple[tuple[float, float], ...]:
        return ((self.harmless, min(self.hopeless, STEPS_AT_ONE_RPM / case.fewest_steps)),)

    def cell(self, case: Case, value: float) -> LimitCell:
        steps = _steps(value)
        speed = 2.0 * math.pi / (steps * STEP)
        scene = case.variant(speed=math.copysign(speed, case.scene.speed))
        return LimitCell(case.name, scene, case.settings(scene, steps))

    def nearest(self, value: float) -> float:
        return STEPS_AT_ONE_RPM / _steps(value)

    def text(self, case: Case, value: float) -> str:
        return f"{self.nearest(value):.4g} rpm ({_steps(value)} steps)"


def _steps(rpm: float) -> int:
    return max(2, round(STEPS_AT_ONE_RPM / rpm))
