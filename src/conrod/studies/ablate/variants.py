"""The models that are compared: the minimal one, with each ingredient, with all, with all but one, with a part less."""

from __future__ import annotations

from collections.abc import Collection, Sequence
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
    REDUCED = "reduced"  # minimal without one of its own parts
    DRESSED = "dressed"  # minimal and all ingredients that do it no harm, of each group the last one
    TAKEN = "taken"  # dressed without one of them, or without a part of the minimal model
    HARMED = "harmed"  # dressed and one of those that do harm
    ALL = "all"  # minimal and all ingredients, those that do harm as well


@dataclass(frozen=True)
class Variant:
    """A model.

    Attributes:
        ingredient: name of the one that it differs by from what it is compared with; empty where it is none.
        settings: that it is run with.
        against: settings of what it is compared with: the dressed model for TAKEN and HARMED, the minimal one for all
            others.
    """

    role: Role
    ingredient: str
    settings: Settings
    against: Settings


def single_variants(minimal: Settings, ingredients: Sequence[Ingredient[Any]]) -> tuple[Variant, ...]:
    """The minimal model, and those that differ from it by one ingredient."""
    return (
        Variant(Role.MINIMAL, "", minimal, minimal),
        *(Variant(Role.ADDED, one.name, one.added(minimal), minimal) for one in ingredients if not one.minimal),
        *(Variant(Role.REDUCED, one.name, one.removed(minimal), minimal) for one in ingredients if one.minimal),
    )


def full_variants(
    minimal: Settings, ingredients: Sequence[Ingredient[Any]], harmful: Collection[str]
) -> tuple[Variant, ...]:
    """The dressed model, those that differ from it by one ingredient, and the one with all of them.

    Args:
        harmful: names of ingredients that spoil the minimal model: what others do could not be seen beside them.
    """
    extra = [one for one in ingredients if not one.minimal]
    worn = last_of_groups([one for one in extra if one.name not in harmful])
    every = last_of_groups(extra)
    if not worn:
        return ()
    dressed = with_all(minimal, worn)
    spoiling = [one for one in every if one.name in harmful]
    return (
        Variant(Role.DRESSED, "", dressed, minimal),
        *(Variant(Role.TAKEN, one.name, one.removed(dressed), dressed) for one in worn),
        *(Variant(Role.TAKEN, one.name, one.removed(dressed), dressed) for one in ingredients if one.minimal),
        *(Variant(Role.HARMED, one.name, one.added(dressed), dressed) for one in spoiling),
        *([Variant(Role.ALL, "", with_all(minimal, every), minimal)] if spoiling else []),
    )


def last_of_groups(ingredients: Sequence[Ingredient[Any]]) -> list[Ingredient[Any]]:
    """Ingredients that a model can have together: of each group the last one."""
    last = {one.group: one.name for one in ingredients if one.group}
    return [one for one in ingredients if not one.group or last[one.group] == one.name]


def with_all(minimal: Settings, ingredients: Sequence[Ingredient[Any]]) -> Settings:
    """The minimal model with some ingredients, added in their order."""
    dressed: Settings = reduce(lambda settings, one: one.added(settings), ingredients, minimal)
    return dressed
