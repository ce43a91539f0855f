"""Speed of a cam whose follower is held down by a constant force."""

from __future__ import annotations

import math
from typing import ClassVar

from conrod.studies.limits.axis import Axis, Scale
from conrod.studies.limits.case import Case
from conrod.studies.limits.cell import LimitCell

PRELOAD = "preload"  # force on the follower over (its mass x its largest downward acceleration at the scene's speed)


class FollowerFloat(Axis):
    """The force stays and the speed grows, over the speed at which the force just gives the least acceleration.

    Accelerations grow with the square of the speed, so at s times the float speed the preload is 1 / s^2. Up to 1 the
    exact motion keeps the follower on its cam; beyond, nothing does.
    """

    name: ClassVar[str] = "float"
    title: ClassVar[str] = "Speed against preload"
    label: ClassVar[str] = "crank speed over the float speed"
    scale: ClassVar[Scale] = Scale.LOG
    harmless: ClassVar[float] = 0.2
    hopeless: ClassVar[float] = 5.0
    allowed: ClassVar[tuple[float, float]] = (0.01, 100.0)

    def refusal(self, case: Case) -> str | None:
        if not case.scene.closed_form and case.contact:
            return f"the float speed of {case.scene.kind}, from a file, is not known: {self.name} does not apply"
        if case.scene.parameters.get(PRELOAD, 0.0) <= 0.0:
            return f"the {case.scene.kind} has no follower that a force holds down: {self.name} does not apply"
        return None

    def cell(self, case: Case, value: float) -> LimitCell:
        float_speed = case.scene.speed * math.sqrt(case.scene.parameters[PRELOAD])
        scene = case.variant(speed=value * float_speed, **{PRELOAD: 1.0 / value**2})
        return LimitCell(case.name, scene, case.settings(scene))

    def text(self, case: Case, value: float) -> str:
        return f"{value:.4g} x the float speed"
