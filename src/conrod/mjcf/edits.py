"""Edits of a compiled model, which are made, and written as lines of Python, alike."""

from __future__ import annotations

import copy
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import mujoco

from conrod.errors import list_names


@dataclass(frozen=True)
class Edit:
    """An edit of a compiled model: rows of an array, multiplied by or set to a value, or an option.

    Attributes:
        array: name of an array of the model, or of an option where there are no rows.
        value: number or choice of an option; factor or first number of the rows, or all numbers of a row.
        named: the elements that the rows are of.
    """

    array: str
    value: Any
    rows: list[int] = field(default_factory=list)
    named: Sequence[str] = ()

    @property
    def scales(self) -> bool:
        """True if the edit multiplies rows of an array, as for inverse weights."""
        return self.array.endswith("_invweight0")

    def make(self, model: mujoco.MjModel) -> None:
        """Make the edit in place."""
        if not self.rows:
            setattr(model.opt, self.array, self.value)
        elif self.scales:
            getattr(model, self.array)[self.rows] *= self.value
        elif isinstance(self.value, tuple):
            getattr(model, self.array)[self.rows] = self.value
        else:
            getattr(model, self.array)[self.rows, 0] = self.value

    @property
    def line(self) -> str:
        """The edit as a line of Python."""
        if not self.rows:
            value = repr(self.value) if type(self.value) in (int, float) else f"mujoco.{self.value}"
            return f"model.opt.{self.array} = {value}"
        # A line break in a name would end the comment.
        names = " ".join(list_names(self.named).split())
        whole = isinstance(self.value, tuple)
        place, sign = f"{self.rows}" if whole or self.scales else f"{self.rows}, 0", "*=" if self.scales else "="
        return f"model.{self.array}[{place}] {sign} {self.value!r}  # {names}"


Recipe = tuple[Edit, ...]


def apply_recipe(model: mujoco.MjModel, recipe: Recipe) -> mujoco.MjModel:
    """Copy a model, and make a recipe's edits in the copy."""
    changed = copy.copy(model)
    for edit in recipe:
        edit.make(changed)
    return changed
