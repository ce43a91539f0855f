"""Settings as the lines that a user puts into a program of their own. Imports no engine."""

from __future__ import annotations

from conrod.engines.engine import Machine
from conrod.engines.left_out_rod import DISTANCE_JOINT
from conrod.engines.pymunk.settings import PymunkSettings


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
