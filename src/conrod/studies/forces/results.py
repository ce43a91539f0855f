"""Findings of a validation of forces: plain, frozen data."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, Self

import numpy as np

from conrod.exact.dynamics.inverse import TORQUE
from conrod.studies.frame.result import AS_ASKED, Result, SceneResults, misfit_words

GROUPS = ("torque", "reactions", "contact")
# Of a change that is to be seen: errors that look like half of it look like it.
LOOKS_LIKE = 0.5


def is_moment(name: str) -> bool:
    """True if a quantity is in N m."""
    return name == TORQUE or name.endswith(".moment")


@dataclass(frozen=True)
class ForceErrors:
    """Of one quantity, over the run, against `peak`.

    Attributes:
        between: of machines with a cam, rms of means of 16 steps where no arc joint is near; None of others.
        peak: what the errors are divided by [N] or [N m].
        own_peak: whether that is the quantity's own exact peak; where it has none it is the largest of its unit.
    """

    max: float
    rms: float
    between: float | None
    peak: float
    own_peak: bool


@dataclass(frozen=True)
class ForcePoint:
    """One run of a refinement path: by quantity the error that is judged; none unless completed."""

    steps_per_revolution: int
    outcome: str
    errors: Mapping[str, float]


@dataclass(frozen=True, kw_only=True)
class ForceResult(Result):
    """Errors of forces, by quantity.

    Attributes:
        groups: those asked for that the machine has, by the names of their quantities.
        unsupported: by quantity, why the engine does not report it.
        order: by group and by quantity.
        misfit: of the exact motion and its joints' equations, as of a validation's result.
        tolerance, reason_of_tolerance: by group, what is allowed, and why.
        likeness: by "body.property", how many times the change that is to be seen the errors look like.
    """

    preset: str
    parameters: Mapping[str, float]
    settings: Mapping[str, Any] | None = None
    steps_per_revolution: int
    revolutions: float
    groups: Mapping[str, tuple[str, ...]]
    unsupported: Mapping[str, str] | None = None
    errors: Mapping[str, ForceErrors] | None = None
    refinement: tuple[ForcePoint, ...] = ()
    likeness: Mapping[str, float] | None = None
    misfit: Mapping[str, Mapping[str, float]] | None = None
    tolerance: Mapping[str, float] | None = None
    reason_of_tolerance: str = ""

    @property
    def names(self) -> list[str]:
        """All quantities that were asked for."""
        return [name for names in self.groups.values() for name in names]

    @property
    def distrust(self) -> str:
        return misfit_words(self.misfit or {})

    @property
    def limits(self) -> Mapping[str, float]:
        return self.tolerance or {}

    def faults(self) -> list[str]:
        likely = sorted(self.mistaken().items(), key=lambda pair: -abs(pair[1]))
        looks = ", ".join(
            f"{name.replace('_', ' ').replace('.', ' ')} by {times:+.2g} changes" for name, times in likely
        )
        return [f"looks like a wrong mass: {looks}"] if looks else []

    def largest(self, quantity: str, measure: str = "max") -> float | None:
        """Largest error of a group; None where nothing of it is reported. `measure`: max, rms or between."""
        found = [self.errors[name] for name in self.groups.get(quantity, ()) if self.errors and name in self.errors]
        sizes = [size for one in found if (size := getattr(one, measure)) is not None]
        # `max` would pass over what is no number.
        return float(np.max(sizes)) if sizes else None

    def judged_error(self, name: str) -> float | None:
        """The error that is compared with a tolerance: of contact rms between the cam's arc joints, else the max."""
        between = self.largest(name, "between") if name == "contact" else None
        return self.largest(name, "rms" if name == "contact" else "max") if between is None else between

    def out_of_tolerance(self) -> dict[str, tuple[float | None, float]]:
        # What an engine does not report is no error of its own.
        unreported = self.unsupported or {}
        return {
            g: pair
            for g, pair in super().out_of_tolerance().items()
            if not unreported.keys() >= set(self.groups.get(g, ()))
        }

    def mistaken(self) -> dict[str, float]:
        """Wrong masses that the errors look like, by "body.property", in changes that are to be seen."""
        return {name: times for name, times in (self.likeness or {}).items() if not abs(times) <= LOOKS_LIKE}

    def _with_tolerances(self, asked: Mapping[str, float]) -> Self:
        allowed = {group: value for group, value in asked.items() if group in self.groups}
        return replace(self, tolerance=allowed, reason_of_tolerance=AS_ASKED)


ForceStudy = SceneResults[ForceResult]
