"""Variations of pymunk's settings, and settings as lines of a user's own program. Imports no engine."""

from __future__ import annotations

import math

from conrod.engines.engine import Machine, with_fields
from conrod.engines.massless_rod import DISTANCE_JOINT
from conrod.engines.pymunk.settings import PymunkSettings


def stabilised(machine: Machine, settings: PymunkSettings, steps: float) -> PymunkSettings:
    """The share left after a step is e^(-1 / steps), which the engine wants as that left after a second.

    That one is no number any more where the second has very many time constants (745): it becomes zero, and a step
    mends all.
    """
    bias = math.exp(-1.0 / (steps * settings.timestep))
    if machine.kinematics.mechanism.cam_contacts:
        return with_fields(settings, collision_bias=bias)
    return with_fields(settings, error_bias=bias)


def regularised(machine: Machine, settings: PymunkSettings, share: float) -> None:
    """Neither joints nor contacts have any; a contact's slop is an overlap that is left, not a softness."""
    return


def paste(machine: Machine, settings: PymunkSettings) -> str:
    """Statements on a `pymunk.Space` called space."""
    lines = [f"space.iterations = {settings.iterations}"]
    if machine.kinematics.mechanism.cam_contacts:
        lines += [
            f"space.collision_bias = {settings.collision_bias!r}",
            f"space.collision_slop = {settings.collision_slop!r}",
        ]
    lines += ["for constraint in space.constraints:", f"    constraint.error_bias = {settings.error_bias!r}"]
    if settings.rod == DISTANCE_JOINT:
        lines.append("# the connecting rod is a pymunk.PinJoint of its length, not a body")
    return "\n".join([*lines, f"space.step({settings.timestep!r})"])
