"""The MJCF files that people reuse: dressed to be looked at, complete to be run on their own. Imports no engine."""

from __future__ import annotations

import math
from typing import Protocol

import numpy as np

from conrod.engines.engine import Machine, default_steps
from conrod.engines.mujoco.mjcf import Dress, mjcf
from conrod.engines.mujoco.settings import MuJoCoSettings
from conrod.engines.tree import spanning_tree


class DescribedMachine(Machine, Protocol):
    """A machine that can say what it is: a scene."""

    @property
    def title(self) -> str:
        """What the machine is."""
        ...

    @property
    def source(self) -> str:
        """Where its dimensions come from."""
        ...


def standalone_mjcf(name: str, machine: DescribedMachine, steps_per_revolution: int | None = None) -> str:
    """MJCF text of a machine with the tuned settings, geoms to look at and a keyframe to start from."""
    kinematics = machine.kinematics
    tree = spanning_tree(kinematics.mechanism, kinematics.start[0])
    poses, slopes = kinematics.derivatives(np.zeros(1), 1)
    rates = tree.rates(poses, slopes * machine.speed)[0]
    settings = MuJoCoSettings.tuned(machine, steps_per_revolution or default_steps(machine))
    dress = Dress(_header(name, machine, settings), tuple(float(rate) for rate in rates))
    return mjcf(tree, settings, f"conrod-{name}", dress)


def _header(name: str, machine: DescribedMachine, settings: MuJoCoSettings) -> str:
    rpm = machine.speed * 60.0 / (2.0 * math.pi)
    points = ", ".join(point.name for point in machine.kinematics.mechanism.observed)
    lines = [
        f"{machine.title}, scene {name} of conrod.",
        f"Source: {machine.source}.",
        "",
        f"Frame: x-y is the document's, z points to the viewer. Joint 'crank' is driven at {rpm:.6g} rpm by its",
        f"armature, a flywheel that nothing can slow down; sites {points} are the observed points, with sensors",
        "for position, velocity and acceleration (an accelerometer's: gravity included).",
        "",
        "LOAD THE KEYFRAME 'start' FIRST: it sets the machine in motion (mj_resetDataKeyframe(model, data, 0)).",
        "Without it the machine stands still.",
        "",
        f"Settings: preset 'tuned', {settings.steps_per_revolution} steps a revolution. The tolerance of 0 is needed:",
        "with this armature MuJoCo's default ends the solver before its first iteration, and the loop opens.",
        "Sensor values after mj_step belong to the instant before the step.",
        f"Written by `conrod export {name}`, format mjcf.",
    ]
    return "\n".join(f"  {line}".rstrip() for line in lines)
