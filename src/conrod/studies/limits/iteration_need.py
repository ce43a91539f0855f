"""The mass ratio that an engine still holds together, against the iterations it may take."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from typing import Any, Self

from conrod.studies.frame.study import Study
from conrod.studies.limits.axes import AXES
from conrod.studies.limits.axes.machine import MassRatio
from conrod.studies.limits.case import Case
from conrod.studies.limits.cell import LimitCell
from conrod.studies.limits.results import Walk
from conrod.studies.limits.walk import most_runs, walk_search

ITERATIONS = (1, 3, 10, 30, 100, 300, 1000)


class MassRatioAtIterations(MassRatio):
    """The mass ratio, with the preset's rule for the iterations replaced by a number that stays."""

    def __init__(self, iterations: int) -> None:
        self.iterations = iterations

    def cell(self, case: Case, value: float) -> LimitCell:
        cell = super().cell(case, value)
        return replace(cell, settings=case.variations.iterated(cell.settings, self.iterations))


@dataclass(frozen=True)
class IterationNeed:
    """Walks of the mass ratio, upwards and downwards, with a number of iterations that stays."""

    scene: str
    engine: str
    preset: str
    iterations: int
    walks: tuple[Walk, ...]

    def as_dict(self) -> dict[str, Any]:
        """All fields as plain values."""
        return asdict(self)

    @classmethod
    def of(cls, values: Mapping[str, Any]) -> Self:
        """The inverse of `as_dict`."""
        return cls(**{**values, "walks": tuple(Walk.of(walk) for walk in values["walks"])})


def need_search(case: Case, iterations: int) -> Study[IterationNeed]:
    """Walk the mass ratio both ways."""
    axis = MassRatioAtIterations(iterations)
    walks = []
    for first, last in axis.spans(case):
        walks.append((yield from walk_search(axis, case, first, last, lambda _: None)))
    return IterationNeed(case.name, case.engine, case.preset, iterations, tuple(walks))


def most_need_runs(case: Case) -> int:
    """The largest number of runs that one search can ask for."""
    axis = AXES[MassRatio.name]
    return sum(most_runs(axis, case, first, last) for first, last in axis.spans(case))
