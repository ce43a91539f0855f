"""Flank radius of a cam, down to the least one.

Nose radius of a cam, towards a knife edge.

Speed of a cam whose follower is held down by a constant force.
"""

from __future__ import annotations

import math
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


NOSE_MM = 1e-3  # [m]


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
        return ((case.scene.parameters["nose_radius"] / NOSE_MM, self.hopeless),)

    def cell(self, case: Case, value: float) -> LimitCell:
        assert isinstance(case.scene, CamFollower)
        nose = value * NOSE_MM
        scene = case.variant(nose_radius=nose, centre_distance=case.scene.full_lift + case.scene.base_radius - nose)
        return LimitCell(case.name, scene, case.settings(scene))

    def text(self, case: Case, value: float) -> str:
        return f"{value:.3g} mm"


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
