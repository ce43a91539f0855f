"""The crank angle at which a run begins."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import ClassVar

from conrod.facts import dead_centres
from conrod.scenes import Scene
from conrod.studies.limits.axis import Axis, Scale
from conrod.studies.limits.case import Case
from conrod.studies.limits.cell import LimitCell

SPACING = 5  # [deg]
SAME = 1e-6  # [deg], as close as a dead centre may lie to one of the others and not be run beside it
SCENES_KEPT = 16


class StartPose(Axis):
    """Every five degrees, and the dead centres, where the output turns back."""

    name: ClassVar[str] = "start-pose"
    title: ClassVar[str] = "Start pose"
    label: ClassVar[str] = "crank angle at the start (deg)"
    scale: ClassVar[Scale] = Scale.LISTED

    def refusal(self, case: Case) -> str | None:
        if case.one_pass:
            return f"the input of {case.scene.kind} makes one pass from its start: {self.name} does not apply"
        return None

    def values(self, case: Case) -> tuple[float, ...]:
        even = [float(angle) for angle in range(0, 360, SPACING)]
        dead = [a for a in _dead_centres(case.scene) if min(abs(a - other) for other in even) > SAME]
        return tuple(sorted([*even, *dead]))

    def cell(self, case: Case, value: float) -> LimitCell:
        return LimitCell(case.name, case.scene, case.settings(), start_angle=math.radians(value))

    def text(self, case: Case, value: float) -> str:
        dead = min((abs(value - angle) for angle in _dead_centres(case.scene)), default=math.inf) <= SAME
        return f"{value:.5g} deg" + (" (dead centre)" if dead else "")


@lru_cache(SCENES_KEPT)
def _dead_centres(scene: Scene) -> tuple[float, ...]:
    """Their crank angles [deg]."""
    return tuple(math.degrees(centre.angle) for centre in dead_centres(scene))
