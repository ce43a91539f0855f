"""The models that are compared: the minimal one, with each ingredient, with all, with all but one, with a part less."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum
from functools import reduce
from typing import Any

from conrod.engines.ingredient import Ingredient
from conrod.trajectory import Settings


class Role(Enum):
    """What a variant is; the members' values are for results."""

    MINIMAL = "minimal"
    ADDED = "added"  # minimal and one ingredient more
    DRESSED = "dressed"  # minimal and all of them, of each group the last one
    TAKEN = "taken"  # all of them but one
    REDUCED = "reduced"  # minimal without one of its own parts


@dataclass(frozen=True)
class Variant:
    """A model.

    Attributes:
        ingredient: name of the one that it differs by from what it is compared with; empty where it is none.
        settings: that it is run with.
        against: settings of what it is compared with: the dressed model for TAKEN, the minimal one for all others.
    """

    role: Role
    ingredient: str
    settings: Settings
    against: Settings


def variants_of(minimal: Settings, ingredients: Sequence[Ingredient[Any]]) -> tuple[Variant, ...]:
    """All variants, the minimal one first and the dressed one after those with one ingredient."""
    own = [ingredient for ingredient in ingredients if ingredient.minimal]
    extra = [ingredient for ingredient in ingredients if not ingredient.minimal]
    found = [Variant(Role.MINIMAL, "", minimal, minimal)]
    found += [Variant(Role.ADDED, one.name, one.added(minimal), minimal) for one in extra]
    worn = dressing_of(ingredients)
    if worn:
        dressed: Settings = reduce(lambda settings, one: one.added(settings), worn, minimal)
        found.append(Variant(Role.DRESSED, "", dressed, minimal))
        found += [Variant(Role.TAKEN, one.name, one.removed(dressed), dressed) for one in worn]
    return (*found, *(Variant(Role.REDUCED, one.name, one.removed(minimal), minimal) for one in own))


def dressing_of(ingredients: Sequence[Ingredient[Any]]) -> tuple[Ingredient[Any], ...]:
    """Ingredients of the dressed model that the minimal one lacks: of each group the last one."""
    extra = [ingredient for ingredient in ingredients if not ingredient.minimal]
    last = {one.group: one.name for one in extra if one.group}
    return tuple(one for one in extra if not one.group or last[one.group] == one.name)
