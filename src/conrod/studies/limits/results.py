"""Findings of `conrod limits`: plain values, from which reports are made."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from conrod.studies.limits.determinism import Determinism
from conrod.studies.limits.follower_float import FollowerFloat
from conrod.studies.limits.maps import LimitMap
from conrod.studies.limits.records import GOOD_LEVELS


@dataclass(frozen=True)
class Probe:
    """A run at one value of an axis.

    Attributes:
        value: value of the axis.
        text: the value as text for people.
        level, outcome, undetected: see `conrod.studies.limits.records`.
        reason: details of an outcome other than completed.
        errors: largest of position, velocity and acceleration, normalised; None unless the run completed.
        torque: largest error of the drive torque over its exact peak; None if unknown.
    """

    value: float
    text: str
    level: str
    outcome: str
    undetected: bool
    reason: str
    errors: Mapping[str, float] | None
    torque: float | None

    @property
    def good(self) -> bool:
        """True if the level is safe or rough: position within 10 % of the travel."""
        return self.level in GOOD_LEVELS

    @property
    def position(self) -> float | None:
        """Largest position error over the travel L; None unless the run completed."""
        return None if self.errors is None else self.errors["position"]


@dataclass(frozen=True)
class Boundary:
    """Boundary of the values that satisfy a criterion, seen from the safe end of an axis.

    Attributes:
        criterion: worst level that satisfies it: safe, rough, wrong (in one piece) or broken (bounded).
        last_good: value of the last probe before the first failure; None if the first probe fails.
        first_bad: value of the first probe that fails; None if none fails.
        outcome, undetected: outcome of that probe, and True if its failure is undetected.
        good_again: values of later probes that satisfy the criterion again.
    """

    criterion: str
    last_good: float | None
    first_bad: float | None
    outcome: str | None
    undetected: bool
    good_again: tuple[float, ...]


@dataclass(frozen=True)
class Walk:
    """Runs along an axis, and their boundaries, with one preset of one engine on one scene.

    Attributes:
        refusal: why the axis was not walked; empty if it was.
        probes: runs from the safe end to the failing end.
        boundaries: one for each criterion; empty for a list of values.
    """

    axis: str
    scene: str
    engine: str
    preset: str
    refusal: str
    probes: tuple[Probe, ...]
    boundaries: tuple[Boundary, ...]


@dataclass(frozen=True)
class LimitStudy:
    """Findings of `conrod limits` on one scene; parts that were not asked for are empty.

    Attributes:
        name, kind, title, parameters: identification of the scene.
        engines: versions by engine name.
        walks: walks of all axes, presets and engines; refused ones have a reason.
        lengths: length L of each observed point [m]; empty in reports of an earlier conrod.
        distrust: scenes and engines whose figures cannot be trusted, and why, in words; empty if all can.
    """

    name: str
    kind: str
    title: str
    parameters: Mapping[str, float]
    engines: Mapping[str, str]
    walks: tuple[Walk, ...]
    maps: tuple[LimitMap, ...]
    determinism: tuple[Determinism, ...]
    floats: tuple[FollowerFloat, ...]
    lengths: Mapping[str, float] = field(default_factory=dict)
    distrust: str = ""


# Fields of a study with parts, and the class of each part.
STUDY_PARTS: dict[str, type[Any]] = {
    "walks": Walk,
    "maps": LimitMap,
    "determinism": Determinism,
    "floats": FollowerFloat,
}
