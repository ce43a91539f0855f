"""What a MuJoCo model may carry, and the minimal model that it is added to. Imports no engine."""

from __future__ import annotations

from conrod.engines.engine import Machine
from conrod.engines.ingredient import Ingredient
from conrod.engines.mujoco.settings import MuJoCoSettings


def minimal(machine: Machine, steps_per_revolution: int) -> MuJoCoSettings:
    """The cheapest settings that have the observed motion right."""
    contact = bool(machine.kinematics.mechanism.cam_contacts)
    preset = MuJoCoSettings.tuned if contact else MuJoCoSettings.hardened
    return preset(machine, steps_per_revolution)


def ingredients(machine: Machine, minimal: MuJoCoSettings) -> tuple[Ingredient[MuJoCoSettings], ...]:
    """What may be added to the minimal model, and what may be taken from it."""
    return ()
