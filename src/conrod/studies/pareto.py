"""Which points no other one beats in both of two costs."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TypeVar

Item = TypeVar("Item")


def pareto_front(items: Iterable[Item], costs: Callable[[Item], tuple[float, float]]) -> tuple[Item, ...]:
    """The items that no other item beats or equals in both costs, by increasing first cost.

    Of items with the same two costs the first is kept.
    """
    front: list[Item] = []
    least = float("inf")
    for item in sorted(items, key=costs):
        if costs(item)[1] < least:
            least = costs(item)[1]
            front.append(item)
    return tuple(front)
