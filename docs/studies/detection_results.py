"""Findings of `make detection`, as they are saved: what verdicts notice, how tight they are, false alarms."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from conrod.studies.validation.results import DefectVerdict, Qualification


@dataclass(frozen=True)
class FalseAlarm:
    """A healthy run that is said to be out of tolerance.

    Attributes:
        speed: crank speed [rad/s].
        reason: why the run failed otherwise.
        over: error (None: none) and tolerance, by quantity out of tolerance.
    """

    steps_per_revolution: int | None
    speed: float
    reason: str
    over: Mapping[str, tuple[float | None, float]]


@dataclass(frozen=True)
class PresetDetection:
    """What the verdict on a machine in a preset notices.

    Attributes:
        reason: why it is not judged; empty if it is.
        qualified: smallest defects that are noticed; None if none was planted.
        tightness: error and tolerance of the machine itself, by judged quantity.
        healthy: number of judged runs with other parameters.
        alarms: those of them that were out of tolerance.
    """

    engine: str
    preset: str
    reason: str
    qualified: Qualification | None
    tightness: Mapping[str, tuple[float, float]]
    healthy: int
    alarms: tuple[FalseAlarm, ...]

    def defects(self) -> dict[str, tuple[DefectVerdict, ...]]:
        """Verdicts on planted defects, by what they were judged by: motion or forces."""
        return {} if self.qualified is None else vars(self.qualified)


@dataclass(frozen=True)
class MachineDetection:
    """Findings on a machine, a preset at a time."""

    name: str
    presets: tuple[PresetDetection, ...]


@dataclass(frozen=True)
class Detection:
    """Findings on all machines."""

    machines: tuple[MachineDetection, ...]

    def presets(self) -> list[PresetDetection]:
        """The findings on all machines in all presets."""
        return [preset for machine in self.machines for preset in machine.presets]
