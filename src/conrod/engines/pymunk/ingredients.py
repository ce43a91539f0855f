"""What a pymunk model may carry, and the minimal model that it is added to. Imports no engine."""

from __future__ import annotations

from conrod.engines.engine import Machine
from conrod.engines.ingredient import Ingredient
from conrod.engines.pymunk.settings import PymunkSettings


def minimal(machine: Machine, steps_per_revolution: int) -> PymunkSettings:
    """The cheapest settings that have the observed motion right."""
    return PymunkSettings.tuned(machine, steps_per_revolution)


def ingredients(machine: Machine, minimal: PymunkSettings) -> tuple[Ingredient[PymunkSettings], ...]:
    """What may be added to the minimal model, and what may be taken from it."""
    return ()
