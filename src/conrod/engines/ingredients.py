"""Ingredients of a model: one thing each, added to settings or taken away from them.

An ingredient is values of the settings' fields, or the name of an edit of the model in their field `dressing`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum
from typing import Any, Generic, TypeAlias

from conrod.engines.engine import AnyFields, with_fields

Change: TypeAlias = Callable[[AnyFields], AnyFields]


class Quantity(Enum):
    """Quantities beside the observed motion that studies look at; the members' texts are for people."""

    DRIVE_TORQUE = "drive torque"
    REACTIONS = "joint reactions"
    IMPACT = "impact"
    WEAR = "wear"


@dataclass(frozen=True)
class Ingredient(Generic[AnyFields]):
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
    added: Change[AnyFields]
    removed: Change[AnyFields]
    minimal: bool = False
    group: str = ""
    needed_by: tuple[Quantity, ...] = ()


def edited(*names: str) -> Change[Any]:
    """Settings with these edits of the model."""
    return lambda settings: with_fields(settings, dressing=(*settings.dressing, *names))


def unedited(*names: str) -> Change[Any]:
    """Settings without these edits of the model."""
    return lambda settings: with_fields(settings, dressing=tuple(one for one in settings.dressing if one not in names))


def valued(**values: Any) -> Change[Any]:
    """Settings with these values of their fields."""
    return lambda settings: with_fields(settings, **values)


@dataclass(frozen=True)
class Ingredients(Generic[AnyFields]):
    """Maker of the ingredients of one minimal model; each method takes name, title, meaning and what else needs it."""

    model: AnyFields

    def edit(self, name: str, title: str, meaning: str, *needed_by: Quantity, group: str = "") -> Ingredient[AnyFields]:
        """An optional one that is an edit of the model, of the same name."""
        return Ingredient(name, title, meaning, edited(name), unedited(name), group=group, needed_by=needed_by)

    def default(self, name: str, title: str, meaning: str, absence: str) -> Ingredient[AnyFields]:
        """An optional one that the engine has by itself, whose absence is an edit."""
        return Ingredient(name, title, meaning, unedited(absence), edited(absence))

    def fields(self, name: str, title: str, meaning: str, *needed_by: Quantity, **values: Any) -> Ingredient[AnyFields]:
        """An optional one that is values of the settings' fields."""
        return Ingredient(name, title, meaning, valued(**values), self._kept(values), needed_by=needed_by)

    def needed_edit(
        self, name: str, title: str, meaning: str, *needed_by: Quantity, absence: str
    ) -> Ingredient[AnyFields]:
        """A part of the minimal model whose absence is an edit."""
        return Ingredient(name, title, meaning, unedited(absence), edited(absence), minimal=True, needed_by=needed_by)

    def needed_fields(
        self, name: str, title: str, meaning: str, *needed_by: Quantity, **without: Any
    ) -> Ingredient[AnyFields]:
        """A part of the minimal model without which the settings' fields have other values."""
        return Ingredient(
            name, title, meaning, self._kept(without), valued(**without), minimal=True, needed_by=needed_by
        )

    def _kept(self, values: dict[str, Any]) -> Change[Any]:
        return valued(**{name: getattr(self.model, name) for name in values})
