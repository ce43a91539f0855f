"""Flank radius of a cam, down to the least one."""

from __future__ import annotations

from typing import ClassVar

from conrod.scenes import CamFollower
from conrod.scenes.cam_follower import LEAST_FLANK_WIDTH
from conrod.studies.limits.axis import Axis, Scale
from conrod.studies.limits.case import Case
from conrod.studies.limits.cell import LimitCell

MM = 1e-3  # [m]
LEAST = LEAST_FLANK_WIDTH / MM * 1.001  # rounding of the scene's own radius must not decide which cam it is


class FlankRadius(Axis):
    """By what the radius exceeds the least one, at which base, flank and nose are one circle and the dwell is gone."""

    name: ClassVar[str] = "flank-radius"
    title: ClassVar[str] = "Flank radius towards its minimum"
    label: ClassVar[str] = "flank radius over the least one (mm)"
    scale: ClassVar[Scale] = Scale.LOG
    harmless: ClassVar[float] = 45.5
    hopeless: ClassVar[float] = LEAST_FLANK_WIDTH / MM
    allowed: ClassVar[tuple[float, float]] = (LEAST_FLANK_WIDTH / MM, 1000.0)

    def refusal(self, case: Case) -> str | None:
        if not isinstance(case.scene, CamFollower):
            return no_such_cam(case, self.name)
        if case.scene.is_one_circle:
            return f"the {case.scene.kind} has its least flank radius already: {self.name} does not apply"
        return None

    def spans(self, case: Case) -> tuple[tuple[float, float], ...]:
        assert isinstance(case.scene, CamFollower)
        own = (case.scene.flank_radius - case.scene.least_flank_radius) / MM
        return ((own, self.hopeless),)

    def cell(self, case: Case, value: float) -> LimitCell:
        assert isinstance(case.scene, CamFollower)
        excess = value * MM if value > LEAST else 0.0
        scene = case.variant(flank_radius=case.scene.least_flank_radius + excess)
        return LimitCell(case.name, scene, case.settings(scene))

    def text(self, case: Case, value: float) -> str:
        return f"{value:.3g} mm over the least" if value > LEAST else "the least: one circle"


def no_such_cam(case: Case, axis: str) -> str:
    """Why a radius of the cam that ships is not varied on another machine."""
    if case.contact:
        return f"which radii of {case.scene.kind}, from a file, go together is not known: {axis} does not apply"
    return f"the {case.scene.kind} has no cam: {axis} does not apply"
