"""What walking an axis shows; plain values and their `as_dict`, from which reports are made."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

from conrod.studies.limits.extremes import Mark


@dataclass(frozen=True)
class Probe:
    """One run on an axis.

    Attributes:
        text: the value as people read it.
        level, outcome, quiet: see `conrod.studies.limits.grade`.
        reason: details of an outcome other than completed.
        errors: largest of position, velocity and acceleration, normalised; None unless the run completed.
        torque: largest error of the drive torque over its exact peak; None where there is none.
        solver: what is to be said of the engine's solver, empty where nothing is.
        ruler: how far the reference itself may be off here, normalised; None where it is at its usual rounding.
    """

    value: float
    text: str
    level: str
    outcome: str
    quiet: bool
    reason: str
    errors: Mapping[str, float] | None
    torque: float | None
    solver: str
    ruler: float | None
    key: str


@dataclass(frozen=True)
class Boundary:
    """Up to where a criterion holds, coming from the harmless end.

    Attributes:
        criterion: the worst level that still counts: safe, rough, wrong (in one piece) or broken (bounded).
        last_good: value of the last probe that keeps it; None where not even the first one does.
        first_bad: value of the first one that does not; None where all do.
        outcome, quiet: of that one.
        good_again: values of probes beyond it that keep the criterion nevertheless.
    """

    criterion: str
    last_good: float | None
    first_bad: float | None
    outcome: str | None
    quiet: bool
    good_again: tuple[float, ...]


@dataclass(frozen=True)
class Walk:
    """An axis walked by one preset of one engine on one scene.

    Attributes:
        refusal: why it was not walked; empty where it was.
        probes: in the order from harmless to hopeless.
    """

    axis: str
    scene: str
    engine: str
    preset: str
    refusal: str
    probes: tuple[Probe, ...]
    boundaries: tuple[Boundary, ...]

    def as_dict(self) -> dict[str, Any]:
        """All fields as plain values."""
        return asdict(self)

    @classmethod
    def of(cls, values: Mapping[str, Any]) -> Walk:
        """The inverse of `as_dict`."""
        return cls(
            **{
                **values,
                "probes": tuple(Probe(**probe) for probe in values["probes"]),
                "boundaries": tuple(
                    Boundary(**{**b, "good_again": tuple(b["good_again"])}) for b in values["boundaries"]
                ),
            }
        )


@dataclass(frozen=True)
class LongRun:
    """One run over many revolutions, with marks on the way; see `Mark`."""

    scene: str
    engine: str
    preset: str
    steps_per_revolution: int
    revolutions: float
    outcome: str
    reason: str
    marks: tuple[Mark, ...]

    def as_dict(self) -> dict[str, Any]:
        """All fields as plain values."""
        return asdict(self)

    @classmethod
    def of(cls, values: Mapping[str, Any]) -> LongRun:
        """The inverse of `as_dict`."""
        return cls(**{**values, "marks": tuple(Mark(**mark) for mark in values["marks"])})
