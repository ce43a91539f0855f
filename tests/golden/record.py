"""One golden value, and how exactly it can be known."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

Value = bool | int | float | str


@dataclass(frozen=True)
class Record:
    """A value or a column of values, with their unit.

    Attributes:
        unit: the size of the numbers whose rounding is in it: 1 for what is normalised by the size of the machine (an
            error of 1e-15 is a difference of two numbers near 1, so that its own digits are noise), the largest value
            of a column, 0 for what is no difference of larger numbers.
    """

    value: Value | Sequence[float]
    unit: float = 0.0


def leaves(name: str, tree: Any) -> Iterator[tuple[str, Value]]:
    """The values in nested mappings and lists, by the way to them; what is None is not there."""
    if isinstance(tree, dict):
        for key, branch in tree.items():
            yield from leaves(f"{name}/{key}", branch)
    elif isinstance(tree, list):
        for index, branch in enumerate(tree):
            yield from leaves(f"{name}/{index}", branch)
    elif tree is not None:
        yield name, tree
