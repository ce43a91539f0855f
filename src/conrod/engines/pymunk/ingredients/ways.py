"""How an ingredient comes into settings, and out of them again."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

from conrod.engines.ingredient import Ingredient, Quantity
from conrod.engines.pymunk.settings import PymunkSettings

Way = Callable[[PymunkSettings], PymunkSettings]


def dressed(*names: str) -> Way:
    """With these in the dressing."""
    return lambda settings: replace(settings, preset="custom", dressing=(*settings.dressing, *names))


def undressed(*names: str) -> Way:
    """Without these in the dressing."""
    return lambda settings: replace(
        settings, preset="custom", dressing=tuple(name for name in settings.dressing if name not in names)
    )


def with_fields(**fields: Any) -> Way:
    """With these values of the settings' fields."""
    return lambda settings: replace(settings, preset="custom", **fields)


def fields_of(settings: PymunkSettings, *names: str) -> dict[str, Any]:
    """Values of some fields of the settings, to be put back."""
    return {name: getattr(settings, name) for name in names}


def extra(name: str, title: str, meaning: str, *needed_by: Quantity, group: str = "") -> Ingredient[PymunkSettings]:
    """An ingredient that is a name in the dressing."""
    return Ingredient(name, title, meaning, dressed(name), undressed(name), group=group, needed_by=needed_by)


def part(
    name: str, title: str, meaning: str, added: Way, removed: Way, *needed_by: Quantity
) -> Ingredient[PymunkSettings]:
    """What the minimal model consists of."""
    return Ingredient(name, title, meaning, added, removed, minimal=True, needed_by=needed_by)
