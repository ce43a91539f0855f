"""How an ingredient comes into settings, and out of them again."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

from conrod.engines.ingredient import Ingredient, Quantity
from conrod.engines.mujoco.settings import MuJoCoSettings

Way = Callable[[MuJoCoSettings], MuJoCoSettings]


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


def extra(name: str, title: str, meaning: str, *needed_by: Quantity, group: str = "") -> Ingredient[MuJoCoSettings]:
    """An ingredient that is a name in the dressing."""
    return Ingredient(name, title, meaning, dressed(name), undressed(name), group=group, needed_by=needed_by)


def by_default(name: str, title: str, meaning: str, absence: str) -> Ingredient[MuJoCoSettings]:
    """An ingredient that MuJoCo has by itself, whose absence is a name in the dressing."""
    return Ingredient(name, title, meaning, undressed(absence), dressed(absence))


def of_fields(
    name: str, title: str, meaning: str, minimal: MuJoCoSettings, values: dict[str, Any], *needed_by: Quantity
) -> Ingredient[MuJoCoSettings]:
    """An ingredient that is values of the settings' fields."""
    return Ingredient(
        name, title, meaning, with_fields(**values), with_fields(**fields_of(minimal, *values)), needed_by=needed_by
    )


def fields_of(settings: MuJoCoSettings, *names: str) -> dict[str, Any]:
    """Values of some fields of the settings, to be put back."""
    return {name: getattr(settings, name) for name in names}
