"""Results of machines in space in engines, as frozen data for report and command line."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import ClassVar, Self

from conrod.comparison.convergence import PAIR_TOLERANCE
from conrod.exact.motion import QUANTITIES
from conrod.execution.result import JudgedResult
from conrod.execution.tolerances import SIZE_UNITS

UNITS = {name: SIZE_UNITS[name] for name in QUANTITIES}  # of tolerances that are given as sizes
LOOPS = "closure"  # the opening of the loops, which the tolerance of the position bounds, too
MIN_ORDER_ERROR = 1e-9  # over L, of the coarser run: less is what iterations and rounding leave, at any step


@dataclass(frozen=True)
class StepRun:
    """A run of a machine in space with a number of steps a revolution.

    Attributes:
        outcome: slug of an `Outcome`; errors are those of a completed run alone.
        errors: largest of all observed points, by quantity, over L, the largest speed and the largest acceleration.
        gap: largest distance between the ends of a closure, over L; NaN if nothing was recorded.
        cost: CPU time of a step with nothing recorded [µs]; NaN if not timed.
    """

    steps_per_rev: int
    outcome: str
    reason: str = ""
    errors: Mapping[str, float] | None = None
    gap: float = math.nan
    cost: float = math.nan

    @property
    def revolution_cost(self) -> float:
        """CPU time of a revolution of the slowest drive [µs]."""
        return self.steps_per_rev * self.cost

    def worst(self, *quantities: str) -> float:
        """Largest error of some quantities; infinite where the run has none."""
        return math.inf if self.errors is None else max(self.errors[name] for name in quantities)


@dataclass(frozen=True, kw_only=True)
class SpatialResult(JudgedResult):
    """A machine in space in an engine with a preset, compared with its exact motion at the same times.

    Attributes:
        steps_per_rev: steps in a revolution of the slowest drive, or in its law; `revolutions` of them are run.
        runs: with growing numbers of steps; the last is the judged one.
        order: observed, from the last two runs.
        tolerance: allowed errors by quantity; empty if the run is measured and not judged.
    """

    quantities: ClassVar[tuple[str, ...]] = (*QUANTITIES, LOOPS)
    measures: ClassVar[tuple[str, ...]] = ("max",)

    preset: str
    steps_per_rev: int
    revolutions: int
    runs: tuple[StepRun, ...] = ()
    tolerance: Mapping[str, float] | None = None

    @property
    def judged_run(self) -> StepRun | None:
        """The run with most steps; None where none was made."""
        return self.runs[-1] if self.runs else None

    @property
    def limits(self) -> Mapping[str, float]:
        allowed = dict(self.tolerance or {})
        return {**allowed, **({LOOPS: allowed["position"]} if "position" in allowed else {})}

    def largest(self, quantity: str, measure: str = "max") -> float | None:
        run = self.judged_run
        if run is None or run.errors is None:
            return None
        return run.gap if quantity == LOOPS else run.errors[quantity]

    @property
    def cost(self) -> float:
        """CPU time of a step [µs]; NaN if not timed."""
        return math.nan if self.judged_run is None else self.judged_run.cost

    def _with_tolerances(self, tolerances: Mapping[str, float]) -> Self:
        return replace(self, tolerance=dict(tolerances))


def observed_orders(runs: tuple[StepRun, ...]) -> dict[str, float | None]:
    """Orders of the errors by quantity, from the last two runs of which the first is off by more than rounding.

    None where there are not two, or the error does not fall from the one to the other.
    """
    return {name: _observed_order(runs, name) for name in QUANTITIES} if len(runs) > 1 else {}


def _observed_order(runs: tuple[StepRun, ...], quantity: str) -> float | None:
    for coarse, fine in reversed([*pairwise(runs)]):
        if coarse.errors is None or fine.errors is None:
            return None
        if coarse.errors[quantity] > MIN_ORDER_ERROR:
            falls = math.log(coarse.errors[quantity] / max(fine.errors[quantity], MIN_ORDER_ERROR**2))
            order = falls / math.log(fine.steps_per_rev / coarse.steps_per_rev)
            return order if order > PAIR_TOLERANCE else None
    return None


@dataclass(frozen=True)
class SpatialStudy:
    """All results of one machine in space.

    Attributes:
        drives: law of each driven joint, as text.
        scales: L [m], the largest speed [m/s] and the largest acceleration [m/s^2], which errors are divided by.
        file: the user's model that it is, whose exact motion is that of its own tree; empty for a machine with a closed
            form.
        remarks: what of the file engines are not given, and what was found as it was read.
    """

    name: str
    title: str
    drives: Mapping[str, str]
    scales: Mapping[str, float]
    results: tuple[SpatialResult, ...]
    file: str = ""
    remarks: tuple[str, ...] = ()

    @property
    def passed(self) -> bool:
        """True if no judged result failed."""
        return all(result.passed is not False for result in self.results)
