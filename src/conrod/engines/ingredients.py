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
        meaning: what is added to the model, or taken from it, in a sentence.
        added, removed: settings with it, and without it.
        needed_by: quantities that need it although the motion does not.
        minimal: whether the minimal model has it; it is then only taken away.
        group: ingredients of one group are amounts or ways of the same thing, of which a model has one; the last of a
            group is the one that the fully dressed model has. Empty for an ingredient on its own.
    """

    name: str
    meaning: str
    added: Change[AnyFields]
    removed: Change[AnyFields]
    needed_by: tuple[Quantity, ...] = ()
    minimal: bool = False
    group: str = ""

    @property
    def title(self) -> str:
        """Its name in words."""
        return self.name.replace("-", " ")


def edited(*names: str) -> Change[Any]:
    """Settings with these edits of the model."""
    return lambda settings: with_fields(settings, dressing=(*settings.dressing, *names))


def unedited(*names: str) -> Change[Any]:
    """Settings without these edits of the model."""
    return lambda settings: with_fields(settings, dressing=tuple(one for one in settings.dressing if one not in names))


def valued(**values: Any) -> Change[Any]:
    """Settings with these values of their fields."""
    return lambda settings: with_fields(settings, **values)


def edit(name: str, meaning: str, *needed_by: Quantity, group: str = "") -> Ingredient[Any]:
    """An optional ingredient that is an edit of the model, of the same name."""
    return Ingredient(name, meaning, edited(name), unedited(name), needed_by, group=group)


def without_edit(absence: str, name: str, meaning: str, *needed_by: Quantity, minimal: bool = False) -> Ingredient[Any]:
    """An ingredient that the engine, or the minimal model, has by itself, and whose absence is an edit."""
    return Ingredient(name, meaning, unedited(absence), edited(absence), needed_by, minimal)


def fields(model: Any, name: str, meaning: str, *needed_by: Quantity, **values: Any) -> Ingredient[Any]:
    """An optional ingredient that is values of the settings' fields, instead of those of the minimal model."""
    return Ingredient(name, meaning, valued(**values), _kept(model, values), needed_by)


def needed_fields(model: Any, name: str, meaning: str, *needed_by: Quantity, **without: Any) -> Ingredient[Any]:
    """A part of the minimal model without which the settings' fields have other values."""
    return Ingredient(name, meaning, _kept(model, without), valued(**without), needed_by, minimal=True)


def _kept(model: Any, values: dict[str, Any]) -> Change[Any]:
    return valued(**{name: getattr(model, name) for name in values})
