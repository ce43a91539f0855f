"""Results of a validation of forces, as frozen data."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, ClassVar, Self

import numpy as np

from conrod.exact.dynamics.inverse import TORQUE
from conrod.execution.result import AS_ASKED, JudgedResult, SceneResults, misfit_words
from conrod.execution.tolerances import Scales

GROUPS = ("torque", "reactions", "contact")
# A wrong mass is claimed from errors that look like more than half of a detectable change of it.
MIN_LIKENESS = 0.5


def is_moment(name: str) -> bool:
    """True if a quantity is a torque or moment [N m], False if it is a force [N]."""
    return name == TORQUE or name.endswith(".moment")


@dataclass(frozen=True)
class ForceErrors:
    """Errors of a quantity over a run, divided by a peak.

    Attributes:
        between: in machines with a cam, rms of means over 16 steps away from arc joints; None in others.
        peak: the peak that errors are divided by [N] or [N m].
        own_peak: whether that is the exact peak of the quantity; if the quantity is zero, it is the largest peak of
            the same unit.
    """

    max: float
    rms: float
    between: float | None
    peak: float
    own_peak: bool


@dataclass(frozen=True)
class ForcePoint:
    """A run of a refinement path: the judged error by quantity; empty unless it completed."""

    steps_per_revolution: int
    outcome: str
    errors: Mapping[str, float]


@dataclass(frozen=True, kw_only=True)
class ForceResult(JudgedResult):
    """Errors of the forces that an engine reports in a scene, by quantity.

    Attributes:
        groups: names of the quantities of each requested group that the machine has.
        unsupported: reasons why the engine does not report a quantity.
        order: observed order by group and by quantity.
        misfit: misfit of the exact motion in the joint equations, as in `ValidationResult`.
        tolerance, reason_of_tolerance: allowed error by group, and its reason.
        likeness: by "body.property", how many detectable changes of it the errors look like.
    """

    quantities: ClassVar[tuple[str, ...]] = GROUPS
    measures: ClassVar[tuple[str, ...]] = ("max", "rms", "between")

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
        """Names of all requested quantities that the machine has."""
        return [name for names in self.groups.values() for name in names]

    @property
    def distrust(self) -> str:
        return misfit_words(self.misfit or {})

    @property
    def limits(self) -> Mapping[str, float]:
        return self.tolerance or {}

    def other_failures(self) -> list[str]:
        likely = sorted(self.apparent_wrong_masses().items(), key=lambda pair: -abs(pair[1]))
        looks = ", ".join(
            f"{name.replace('_', ' ').replace('.', ' ')} by {times:+.2g} changes" for name, times in likely
        )
        return [f"looks like a wrong mass: {looks}"] if looks else []

    def largest(self, quantity: str, measure: str = "max") -> float | None:
        """Largest error of a group by a measure (max, rms, between); None if nothing is reported."""
        errors = self.errors or {}
        found = {name: errors[name] for name in self.groups.get(quantity, ()) if name in errors}
        known = {name: size for name, one in found.items() if (size := getattr(one, measure)) is not None}
        sizes = list(self.weigh(quantity, known).values())
        # NumPy's max, since Python's would skip a NaN.
        return float(np.max(sizes)) if sizes else None

    def judged_error(self, name: str) -> float | None:
        """Error that is compared with a tolerance: the max, or for contact rms between arc joints."""
        between = self.largest(name, "between") if name == "contact" else None
        return self.largest(name, "rms" if name == "contact" else "max") if between is None else between

    def out_of_tolerance(self) -> dict[str, tuple[float | None, float]]:
        # A group of which the engine reports nothing is not judged.
        unreported = self.unsupported or {}
        return {
            g: pair
            for g, pair in super().out_of_tolerance().items()
            if not unreported.keys() >= set(self.groups.get(g, ()))
        }

    def judged_points(self, name: str) -> Mapping[str, float]:
        """Judged errors of a group's quantities by name, weighed."""
        known = {one: size.max for one in self.groups.get(name, ()) if (size := (self.errors or {}).get(one))}
        return self.weigh(name, known)

    def own_scales(self) -> Scales:
        """Exact peaks [N m or N] by group and quantity."""
        known = self.errors or {}
        return {g: {name: known[name].peak for name in names if name in known} for g, names in self.groups.items()}

    def apparent_wrong_masses(self) -> dict[str, float]:
        """Return the wrong masses that the errors look like, each with its likeness, by "body.property"."""
        return {name: times for name, times in (self.likeness or {}).items() if not abs(times) <= MIN_LIKENESS}

    def _with_tolerances(self, tolerances: Mapping[str, float]) -> Self:
        allowed = {group: value for group, value in tolerances.items() if group in self.groups}
        return replace(self, tolerance=allowed, reason_of_tolerance=AS_ASKED)


ForceStudy = SceneResults[ForceResult]
