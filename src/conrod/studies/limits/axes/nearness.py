"""Nearness to a change point, where a linkage gains a freedom and may go on along either of two branches."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import ClassVar

from conrod.scenes import Saw, Scene, ShearPress
from conrod.studies.limits.axis import Axis, Scale
from conrod.studies.limits.case import Case
from conrod.studies.limits.cell import LimitCell

Values = Mapping[str, float]


def _press(p: Values, nearness: float) -> Values:
    """Crank as long as the rod: the slider could stand still on the shaft while both turn together."""
    return {"crank": nearness * p["rod"]}


def _saw(p: Values, nearness: float) -> Values:
    """Offset as large as rod - crank: the rod stands across the slide when the crank points away from it."""
    return {"offset": math.copysign(nearness * (p["rod"] - p["crank"]), p["offset"])}


# What has to change, and alone does, to bring a machine to its change point.
APPROACHES: Mapping[type[Scene], Callable[[Values, float], Values]] = {ShearPress: _press, Saw: _saw}


# Near a change point all happens within a small part of a turn: with the usual steps nothing holds as far as it could.
STEPS = 5000


class Nearness(Axis):
    """A length over its limit: of the press crank / rod, of the saw offset / (rod - crank)."""

    name: ClassVar[str] = "nearness"
    title: ClassVar[str] = "Nearness to the change point"
    label: ClassVar[str] = "length over its limit (crank : rod, or offset : rod - crank)"
    scale: ClassVar[Scale] = Scale.NEARNESS
    harmless: ClassVar[float] = 0.1
    hopeless: ClassVar[float] = 1.0 - 1e-9
    allowed: ClassVar[tuple[float, float]] = (0.01, 1.0 - 1e-9)
    near_singular: ClassVar[bool] = True

    def refusal(self, case: Case) -> str | None:
        # By what a scene is: a machine from a file may have any name.
        if type(case.scene) in APPROACHES:
            return None
        known = f"the {case.scene.kind} has no change point"
        return f"{known if case.scene.closed_form else not_known(case.scene)}: {self.name} does not apply"

    def cell(self, case: Case, value: float) -> LimitCell:
        scene = self.scene(case, value)
        return LimitCell(case.name, scene, case.settings(scene, case.steps_per_revolution or STEPS))

    def scene(self, case: Case, value: float) -> Scene:
        """The machine at a nearness."""
        return case.variant(**APPROACHES[type(case.scene)](case.scene.parameters, value))

    def text(self, case: Case, value: float) -> str:
        return f"{value:.3g}" if value < 0.99 else f"1 - {1.0 - value:.3g}"


def not_known(scene: Scene) -> str:
    """Why a machine from a file is not brought to its change point."""
    return f"which lengths bring {scene.kind}, from a file, to a change point is not known"
