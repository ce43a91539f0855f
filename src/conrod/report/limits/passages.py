"""A walk as a reader passes along it: neighbouring runs of one level together, whatever each outcome was called."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import groupby

from conrod.studies.limits.results import Probe, Walk

# A walk with more passages than this comes and goes, and is not told value by value.
MOST_TOLD = 5


@dataclass(frozen=True)
class Passage:
    """Runs of one level, all of them quiet or none; nothing lies between."""

    level: str
    quiet: bool
    probes: tuple[Probe, ...]

    @property
    def outcomes(self) -> tuple[str, ...]:
        """How they ended, in the order in which that was met."""
        return tuple(dict.fromkeys(probe.outcome for probe in self.probes))

    @property
    def kind(self) -> tuple[str, bool, tuple[str, ...]]:
        """What two passages have in common that are told with the same words."""
        return self.level, self.quiet, self.outcomes

    @property
    def good(self) -> bool:
        """Whether the motion is within ten per cent."""
        return self.level in ("safe", "rough")


def passages(walk: Walk) -> tuple[Passage, ...]:
    """All passages of a walk, from harmless to hopeless."""
    return tuple(
        Passage(level, quiet, tuple(probes))
        for (level, quiet), probes in groupby(walk.probes, lambda p: (p.level, p.quiet))
    )


def falling(walk: Walk) -> bool:
    """Whether values fall from the harmless end to the hopeless one."""
    return walk.probes[-1].value < walk.probes[0].value


def largest_error(probes: Sequence[Probe]) -> float | None:
    """Largest position error of the runs that completed; None where none did."""
    return max((probe.errors["position"] for probe in probes if probe.errors is not None), default=None)
