"""What a pymunk model may carry, and the minimal model that it is added to. Imports no engine."""

from __future__ import annotations

from dataclasses import replace

from conrod.engines.engine import Machine
from conrod.engines.ingredient import Ingredient
from conrod.engines.left_out_rod import BODY, DISTANCE_JOINT, form_refusal
from conrod.engines.pymunk.ingredients.carried import carried
from conrod.engines.pymunk.ingredients.needed import needed
from conrod.engines.pymunk.settings import PymunkSettings

# pymunk's default. With rods as distance joints the velocity and the acceleration are then within 3 % of what ten
# thousand give on the press and the saw (1000 steps a turn), and within a third where the transmission angle falls to
# ten degrees; with one iteration the saw's acceleration is wrong by a tenth of its size.
ENOUGH = 10


def minimal(machine: Machine, steps_per_revolution: int) -> PymunkSettings:
    """The cheapest settings that have the observed motion right.

    Joints mended whole at every step, rods as distance joints, and no gravity: with the crank prescribed the motion
    depends on no mass. Rods as bodies have the same motion, and need iterations in proportion to the ratio of masses:
    at ten of them the press is off in acceleration by 0.19 of omega^2 L, at a hundred it is as accurate as this one, at
    several times its cost (1000 steps a turn).
    """
    mechanism = machine.kinematics.mechanism
    tuned = replace(PymunkSettings.tuned(machine, steps_per_revolution), preset="custom", gravity=False)
    if mechanism.cam_contacts:
        return replace(tuned, iterations=ENOUGH)
    if form_refusal(mechanism, DISTANCE_JOINT):
        return replace(tuned, rod=BODY)
    return replace(tuned, rod=DISTANCE_JOINT, iterations=ENOUGH)


def ingredients(machine: Machine, minimal: PymunkSettings) -> tuple[Ingredient[PymunkSettings], ...]:
    """What may be added to the minimal model, and what may be taken from it; only what applies to the machine."""
    return (*carried(machine, minimal), *needed(machine, minimal))
