"""Findings of `conrod limits`: plain values, from which reports are made."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from conrod.studies.limits.determinism import Determinism
from conrod.studies.limits.follower_float import FollowerFloat
from conrod.studies.limits.maps import LimitMap
from conrod.studies.limits.records import GOOD


@dataclass(frozen=True)
class Probe:
    """One run on an axis.

    Attributes:
        text: the value as people read it.
        level, outcome, undetected: see `conrod.studies.limits.records`.
        reason: details of an outcome other than completed.
        errors: largest of position, velocity and acceleration, normalised; None unless the run completed.
        torque: largest error of the drive torque over its exact peak; None where there is none.
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
        """True within ten per cent."""
        return self.level in GOOD

    @property
    def position(self) -> float | None:
        """Largest position error over L."""
        return None if self.errors is None else self.errors["position"]


@dataclass(frozen=True)
class Boundary:
    """The end of the stretch in which a criterion holds, coming from the safe end.

    Attributes:
        criterion: the worst level that still counts: safe, rough, wrong (in one piece) or broken (bounded).
        last_good: value of the last probe that keeps it; None where not even the first one does.
        first_bad: value of the first one that does not; None where all do.
        outcome, undetected: of that one.
        good_again: values of probes beyond it that keep the criterion nevertheless.
    """

    criterion: str
    last_good: float | None
    first_bad: float | None
    outcome: str | None
    undetected: bool
    good_again: tuple[float, ...]


@dataclass(frozen=True)
class Walk:
    """An axis walked by one preset of one engine on one scene.

    Attributes:
        refusal: why it was not walked; empty where it was.
        probes: from the safe end to the failing one.
        boundaries: one a criterion; none of a list of values.
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
    """All that `conrod limits` finds on one scene; parts that were not asked for are empty.

    Attributes:
        name, kind, title, parameters: of the scene.
        engines: name -> version.
        walks: of all axes, presets and engines, refused ones with their reason.
        lengths: L of each observed point [m]; empty in reports of an earlier conrod.
        distrust: scenes and engines whose figures cannot be trusted, and why, in words; empty if there are none.
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


# Of a study, and what each is made of.
PARTS: dict[str, type[Any]] = {
    "walks": Walk,
    "maps": LimitMap,
    "determinism": Determinism,
    "floats": FollowerFloat,
}
