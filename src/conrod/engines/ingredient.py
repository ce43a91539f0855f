"""What a model may carry, or do without: one thing each, added to settings or taken away from them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum
from typing import Generic

from conrod.engines.variations import AnySettings


class Quantity(Enum):
    """What a study may want besides the observed motion; the members' texts are for people."""

    DRIVE_TORQUE = "drive torque"
    REACTIONS = "joint reactions"
    IMPACT = "impact"
    WEAR = "wear"


@dataclass(frozen=True)
class Ingredient(Generic[AnySettings]):
    """Something that the minimal model lacks, or that it consists of.

    Attributes:
        name: short, for the command line and for results: "sensors-8".
        title: for people: "eight sensors".
        meaning: what is added to the model, or taken from it, in a sentence.
        minimal: whether the minimal model has it; it is then only taken away.
        group: ingredients of one group are amounts or ways of the same thing, of which a model has one; the last of a
            group is the one that the fully dressed model has. Empty for an ingredient on its own.
        needed_by: quantities that need it although the motion does not.
        added, removed: settings with it, and without it.
    """

    name: str
    title: str
    meaning: str
    added: Callable[[AnySettings], AnySettings]
    removed: Callable[[AnySettings], AnySettings]
    minimal: bool = False
    group: str = ""
    needed_by: tuple[Quantity, ...] = ()
