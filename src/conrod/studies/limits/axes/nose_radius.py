"""Nose radius of a cam, towards a knife edge."""

from __future__ import annotations

from typing import ClassVar

from conrod.scenes import CamFollower
from conrod.studies.limits.axes.flank_radius import no_such_cam
from conrod.studies.limits.axis import Axis, Scale
from conrod.studies.limits.case import Case
from conrod.studies.limits.cell import LimitCell

MM = 1e-3  # [m]


class NoseRadius(Axis):
    """The nose's centre moves out as its radius shrinks, so that the lift, and the least flank radius, stay."""

    name: ClassVar[str] = "nose-radius"
    title: ClassVar[str] = "Nose radius towards zero"
    label: ClassVar[str] = "nose radius (mm)"
    scale: ClassVar[Scale] = Scale.LOG
    harmless: ClassVar[float] = 29.0
    hopeless: ClassVar[float] = 0.01
    allowed: ClassVar[tuple[float, float]] = (0.001, 1e6)

    def refusal(self, case: Case) -> str | None:
        if not isinstance(case.scene, CamFollower):
            return no_such_cam(case, self.name)
        return None

    def spans(self, case: Case) -> tuple[tuple[float, float], ...]:
        return ((case.scene.parameters["nose_radius"] / MM, self.hopeless),)

    def cell(self, case: Case, value: float) -> LimitCell:
        assert isinstance(case.scene, CamFollower)
        nose = value * MM
        scene = case.variant(nose_radius=nose, centre_distance=case.scene.full_lift + case.scene.base_radius - nose)
        return LimitCell(case.name, scene, case.settings(scene))

    def text(self, case: Case, value: float) -> str:
        return f"{value:.3g} mm"
