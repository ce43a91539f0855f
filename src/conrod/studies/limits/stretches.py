"""Neighbouring probes of a walk that ended alike, taken together: what a reader wants to know of an axis."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import groupby

from conrod.studies.limits.results import Probe, Walk


@dataclass(frozen=True)
class Stretch:
    """From one probe to another; both ended alike, as did all between."""

    level: str
    outcome: str
    quiet: bool
    probes: tuple[Probe, ...]

    @property
    def first(self) -> Probe:
        """The one nearer to the harmless end."""
        return self.probes[0]

    @property
    def last(self) -> Probe:
        """The one nearer to the hopeless end."""
        return self.probes[-1]


def stretches(walk: Walk) -> tuple[Stretch, ...]:
    """All stretches of a walk, from harmless to hopeless."""
    return tuple(
        Stretch(level, outcome, quiet, tuple(probes))
        for (level, outcome, quiet), probes in groupby(walk.probes, lambda p: (p.level, p.outcome, p.quiet))
    )
