"""One line of the table: what was measured, and what it must reach."""

from __future__ import annotations

import statistics
from collections.abc import Sequence
from dataclasses import dataclass


@dataclass(frozen=True)
class Row:
    """A figure beside its bar.

    Attributes:
        name: what was measured.
        unit: of the figures and of the bar.
        repeats: the figure of each repeat.
        bar: what the median must reach; None for a figure that has none and is printed beside one that has.
        at_least: the bar is a least value and not a largest one.
    """

    name: str
    unit: str
    repeats: Sequence[float]
    bar: float | None = None
    at_least: bool = False

    @property
    def median(self) -> float:
        """The figure that is judged."""
        return statistics.median(self.repeats)

    @property
    def best(self) -> float:
        """The best repeat: a second opinion where other work disturbs."""
        return max(self.repeats) if self.at_least else min(self.repeats)

    @property
    def reached(self) -> bool | None:
        """Whether the median reaches the bar; None without one."""
        if self.bar is None:
            return None
        return self.median >= self.bar if self.at_least else self.median <= self.bar
