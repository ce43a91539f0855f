"""A quantity that is driven from harmless to hopeless."""

from __future__ import annotations

from abc import ABC, abstractmethod
from enum import Enum
from typing import ClassVar

from conrod.studies.limits.case import Case
from conrod.studies.limits.cell import LimitCell


class Scale(Enum):
    """How values of an axis are spaced, and so how they are halved."""

    LOG = "log"  # by ratios
    COUNT = "count"  # whole numbers, by ratios
    NEARNESS = "nearness"  # by ratios of the distance to one
    LISTED = "listed"  # each value stands alone: there is nothing to halve


class Axis(ABC):
    """One axis.

    Attributes:
        name: on the command line.
        title: in the report.
        label: of a figure's axis, with the unit in which values are given.
        harmless, hopeless: its ends, in that unit.
    """

    name: ClassVar[str]
    title: ClassVar[str]
    label: ClassVar[str]
    scale: ClassVar[Scale]
    harmless: ClassVar[float]
    hopeless: ClassVar[float]

    @abstractmethod
    def refusal(self, case: Case) -> str | None:
        """None, or why this case does not have the axis."""

    @abstractmethod
    def cell(self, case: Case, value: float) -> LimitCell:
        """The run at a value.

        Raises:
            InvalidInput: the machine or the engine cannot be given with this value.
        """

    def values(self, case: Case) -> tuple[float, ...]:
        """All values of a listed axis."""
        raise NotImplementedError(f"{self.name} is not a listed axis")

    def text(self, case: Case, value: float) -> str:
        """A value as people read it."""
        return f"{value:.4g}"
