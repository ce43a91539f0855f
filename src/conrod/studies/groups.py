"""Dimensionless groups that a setting and a scene are compared with others by."""

from __future__ import annotations

import math
from dataclasses import dataclass

from conrod.mass_ratio import mass_ratio
from conrod.scenes import Scene
from conrod.trajectory import Settings
from conrod.transmission import least_transmission_angle


@dataclass(frozen=True)
class Groups:
    """What a recommendation depends on, free of size, mass and speed.

    Attributes:
        steps_per_revolution: 2 pi over the step of the crank angle.
        time_constant: crank speed x time constant of what closes the joints [rad]; 0 where they are closed at once.
        mass_ratio: heaviest link over the lightest that a joint feels.
        transmission_angle: the least over a turn [rad]; None where there is none.
    """

    steps_per_revolution: int
    time_constant: float
    mass_ratio: float
    transmission_angle: float | None

    def in_words(self) -> str:
        """One line for people."""
        angle = self.transmission_angle
        words = [
            f"{self.steps_per_revolution} steps per revolution",
            f"omega x time constant = {self.time_constant:.3g}",
            f"mass ratio = {self.mass_ratio:.3g}",
            *([] if angle is None else [f"least transmission angle = {math.degrees(angle):.1f} deg"]),
        ]
        return ", ".join(words)


def groups_of(scene: Scene, settings: Settings) -> Groups:
    """The groups of a setting on a scene."""
    mechanism = scene.kinematics.mechanism
    return Groups(
        settings.steps_per_revolution,
        abs(scene.speed) * settings.time_constant(bool(mechanism.cam_contacts)),
        mass_ratio(mechanism),
        least_transmission_angle(scene.kinematics),
    )
