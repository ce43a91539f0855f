"""Findings of a validation of forces: plain, frozen data."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from conrod.exact.motion import Array
from conrod.scenes import Scene
from conrod.studies.forces.seen import Seen

# Of a change that is to be seen: errors that look like half of it look like it.
LOOKS_LIKE = 0.5


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
class Stamps:
    """Instants that values belong to, in steps of the run: `count` of them, `spacing` apart, from `first` on."""

    first: float
    spacing: float
    count: int
    left_out: int  # of these, at change points, where joint forces are not determined


@dataclass(frozen=True)
class TorqueCurve:
    """Drive torque of the last turn, thinned, and its error over the run; angles [rad], torques [N m]."""

    angle: Array
    reported: Array
    exact: Array
    error_angle: Array
    error: Array


@dataclass(frozen=True)
class ForcePoint:
    """One run of a refinement path: by quantity the error that is judged; none unless completed."""

    steps_per_revolution: int
    outcome: str
    errors: Mapping[str, float]


@dataclass(frozen=True)
class ForceResult:
    """One scene, engine and preset.

    Attributes:
        groups: those asked for that the machine has, by the names of their quantities.
        unsupported: by quantity, why the engine does not report it.
        order: by group and by quantity.
        tolerance, reason_of_tolerance: by group, what is allowed, and why.
        likeness: by "body.property", how many times the change that is to be seen the errors look like.
    """

    scene: str
    parameters: Mapping[str, float]
    engine: str
    engine_version: str
    preset: str
    settings: Mapping[str, Any] | None
    steps_per_revolution: int
    revolutions: float
    groups: Mapping[str, tuple[str, ...]]
    outcome: str
    reason: str
    stamps: Stamps | None = None
    errors: Mapping[str, ForceErrors] | None = None
    unsupported: Mapping[str, str] | None = None
    order: Mapping[str, float | None] | None = None
    refinement: tuple[ForcePoint, ...] = ()
    tolerance: Mapping[str, float] | None = None
    reason_of_tolerance: str = ""
    likeness: Mapping[str, float] | None = None
    passed: bool | None = None
    curve: TorqueCurve | None = None

    def largest(self, group: str, measure: str = "max") -> float | None:
        """Largest error of a group's quantities; None where there is none."""
        found = [self.errors[name] for name in self.groups.get(group, ()) if self.errors and name in self.errors]
        sizes = [size for one in found if (size := getattr(one, measure)) is not None]
        return max(sizes) if sizes else None

    def judged(self, group: str) -> float | None:
        """The error that is compared with a tolerance: of contact rms between the cam's arc joints, else the max."""
        between = self.largest(group, "between") if group == "contact" else None
        return self.largest(group, "rms" if group == "contact" else "max") if between is None else between

    def exceeded(self) -> dict[str, tuple[float | None, float]]:
        """Judged groups out of tolerance: what was found (None: nothing) and what is allowed.

        What an engine does not report is no error of its own.
        """
        pairs = {
            g: (self.judged(g), allowed) for g, allowed in (self.tolerance or {}).items() if not self._unreported(g)
        }
        return {group: pair for group, pair in pairs.items() if pair[0] is None or not pair[0] <= pair[1]}

    def mistaken(self) -> dict[str, float]:
        """Wrong masses that the errors look like, by "body.property", in changes that are to be seen."""
        return {name: times for name, times in (self.likeness or {}).items() if not abs(times) <= LOOKS_LIKE}

    def _unreported(self, group: str) -> bool:
        return all(name in (self.unsupported or {}) for name in self.groups.get(group, ()))


@dataclass(frozen=True)
class ForceStudy:
    """All results of one scene, and what they can see of a wrong mass."""

    name: str
    scene: Scene
    results: tuple[ForceResult, ...]
    seen: Seen

    @property
    def passed(self) -> bool:
        """No judged result is out of tolerance."""
        return all(result.passed is not False for result in self.results)
