"""What a model may carry, or do without: one thing each, added to settings or taken away from them.

An ingredient comes into settings, and out of them again, by a name in their dressing or by values of fields.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import Field, dataclass, replace
from enum import Enum
from typing import Any, ClassVar, Generic, Protocol, TypeVar

from conrod.engines.presets import AnySettings
from conrod.runs.trajectory import Settings


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


class Dressable(Settings, Protocol):
    """Settings as a dataclass, with names of what the model carries beside what it needs."""

    __dataclass_fields__: ClassVar[dict[str, Field[Any]]]

    @property
    def dressing(self) -> tuple[str, ...]:
        """The names."""
        ...


AnyDressable = TypeVar("AnyDressable", bound=Dressable)
Way = Callable[[AnyDressable], AnyDressable]


def dressed(*names: str) -> Way[AnyDressable]:
    """With these in the dressing."""
    return lambda settings: replace(settings, preset="custom", dressing=(*settings.dressing, *names))


def undressed(*names: str) -> Way[AnyDressable]:
    """Without these in the dressing."""
    return lambda settings: replace(
        settings, preset="custom", dressing=tuple(name for name in settings.dressing if name not in names)
    )


def with_fields(**fields: Any) -> Way[AnyDressable]:
    """With these values of the settings' fields."""
    return lambda settings: replace(settings, preset="custom", **fields)


def fields_of(settings: Dressable, *names: str) -> dict[str, Any]:
    """Values of some fields of the settings, to be put back."""
    return {name: getattr(settings, name) for name in names}


def extra(name: str, title: str, meaning: str, *needed_by: Quantity, group: str = "") -> Ingredient[AnyDressable]:
    """An ingredient that is a name in the dressing."""
    return Ingredient(name, title, meaning, dressed(name), undressed(name), group=group, needed_by=needed_by)


def by_default(name: str, title: str, meaning: str, absence: str) -> Ingredient[AnyDressable]:
    """An ingredient that the engine has by itself, whose absence is a name in the dressing."""
    return Ingredient(name, title, meaning, undressed(absence), dressed(absence))


def of_fields(
    name: str, title: str, meaning: str, minimal: AnyDressable, values: dict[str, Any], *needed_by: Quantity
) -> Ingredient[AnyDressable]:
    """An ingredient that is values of the settings' fields."""
    return Ingredient(
        name, title, meaning, with_fields(**values), with_fields(**fields_of(minimal, *values)), needed_by=needed_by
    )


def part(
    name: str,
    title: str,
    meaning: str,
    added: Way[AnyDressable],
    removed: Way[AnyDressable],
    *needed_by: Quantity,
) -> Ingredient[AnyDressable]:
    """What the minimal model consists of."""
    return Ingredient(name, title, meaning, added, removed, minimal=True, needed_by=needed_by)
