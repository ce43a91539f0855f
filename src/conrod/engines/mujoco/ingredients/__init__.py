"""What a MuJoCo model may carry, and the minimal model that it is added to. Imports no engine."""

from __future__ import annotations

from dataclasses import replace

from conrod.engines.engine import Machine
from conrod.engines.ingredient import Ingredient
from conrod.engines.mujoco.dressing import dressing_refusal
from conrod.engines.mujoco.ingredients.carried import carried
from conrod.engines.mujoco.ingredients.needed import by_contact, needed
from conrod.engines.mujoco.settings import MuJoCoSettings
from conrod.equivalent_linkage import linkage_refusal


def minimal(machine: Machine, steps_per_revolution: int) -> MuJoCoSettings:
    """The cheapest settings that have the observed motion right.

    Those of the best preset without what the motion does not need: no gravity, a single iteration of Newton's method
    and a short line search, which are exact as long as the set of acting constraints stays, and none of what MuJoCo
    does unasked for models of many bodies and shapes.
    """
    contact = bool(machine.kinematics.mechanism.cam_contacts)
    preset = MuJoCoSettings.tuned if contact else MuJoCoSettings.hardened
    return replace(
        preset(machine, steps_per_revolution),
        preset="custom",
        gravity=False,
        iterations=1,
        dressing=("no-islands", "no-multiccd", "short-line-search"),
    )


def ingredients(machine: Machine, minimal: MuJoCoSettings) -> tuple[Ingredient[MuJoCoSettings], ...]:
    """What may be added to the minimal model, and what may be taken from it; only what applies to the machine."""
    mechanism = machine.kinematics.mechanism
    contact = bool(mechanism.cam_contacts)
    found = (*carried(mechanism, minimal), *needed(contact, minimal))
    if contact and linkage_refusal(mechanism) is None:
        found = (*found, by_contact(machine, minimal))
    # What is added is what must apply; of what the model consists of, it is what is missing then.
    return tuple(
        one for one in found if not dressing_refusal(mechanism, (one.removed if one.minimal else one.added)(minimal))
    )
