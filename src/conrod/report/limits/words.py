"""A walk as a reader passes along it: neighbouring runs of one level together, whatever each outcome was called.

Boundaries and stretches in words.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import groupby

from conrod.studies.limits.grade import ROUGH_ERROR, SAFE_ERROR
from conrod.studies.limits.results import Boundary, Probe, Stretch, Walk, stretches

# A walk with more passages than this comes and goes, and is not told value by value.
MOST_TOLD = 5


@dataclass(frozen=True)
class Passage:
    """Runs of one level, all of them quiet or none; nothing lies between."""

    level: str
    undetected: bool
    probes: tuple[Probe, ...]

    @property
    def outcomes(self) -> tuple[str, ...]:
        """How they ended, in the order in which that was met."""
        return tuple(dict.fromkeys(probe.outcome for probe in self.probes))

    @property
    def kind(self) -> tuple[str, bool, tuple[str, ...]]:
        """What two passages have in common that are told with the same words."""
        return self.level, self.undetected, self.outcomes

    @property
    def good(self) -> bool:
        """Whether the motion is within ten per cent."""
        return self.level in ("safe", "rough")


def passages(walk: Walk) -> tuple[Passage, ...]:
    """All passages of a walk, from harmless to hopeless."""
    return tuple(
        Passage(level, undetected, tuple(probes))
        for (level, undetected), probes in groupby(walk.probes, lambda p: (p.level, p.undetected))
    )


def falling(walk: Walk) -> bool:
    """Whether values fall from the harmless end to the hopeless one."""
    return walk.probes[-1].value < walk.probes[0].value


def largest_error(probes: Sequence[Probe]) -> float | None:
    """Largest position error of the runs that completed; None where none did."""
    return max((probe.errors["position"] for probe in probes if probe.errors is not None), default=None)


# Criterion -> the heading of its column.
BOUNDARIES = {
    "safe": f"within {100 * SAFE_ERROR:g} %",
    "rough": f"within {100 * ROUGH_ERROR:g} %",
    "wrong": "in one piece",
    "broken": "bounded",
}
EXPONENT = re.compile(r"(?<=\d)e(?:\+|(-))0*(\d)")
EVERYWHERE, NOWHERE, NOT_AT_FIRST = "all of it", "none of it", "not at first"
AGAIN = " *"  # after a value: there are runs further on that keep the criterion


def readable(walk: Walk) -> Walk:
    """The same with powers of ten in its texts as figures have them: 1e6 for 1e+06."""
    probes = (replace(p, text=_plain_powers(p.text), solver=_plain_powers(p.solver)) for p in walk.probes)
    return replace(walk, probes=tuple(probes))


def _plain_powers(text: str) -> str:
    return EXPONENT.sub(r"e\1\2", text)


def up_to(walk: Walk, criterion: str) -> str:
    """The last value at which a criterion holds, coming from the harmless end."""
    boundary = boundary_of(walk, criterion)
    if boundary.first_bad is None:
        return EVERYWHERE
    held = not_held(boundary) if boundary.last_good is None else text_at(walk, boundary.last_good)
    return held + (AGAIN if boundary.good_again else "")


def not_held(boundary: Boundary) -> str:
    """Of a criterion that not even the harmless end keeps: whether any run does."""
    return NOT_AT_FIRST if boundary.good_again else NOWHERE


def boundary_of(walk: Walk, criterion: str) -> Boundary:
    """The boundary of a criterion; StopIteration where the walk has none."""
    return next(boundary for boundary in walk.boundaries if boundary.criterion == criterion)


def text_at(walk: Walk, value: float) -> str:
    """A value of a walk as people read it."""
    return next(probe.text for probe in walk.probes if probe.value == value)


def beyond(walk: Walk) -> str:
    """How the runs beyond ten per cent ended, from harmless to hopeless."""
    bad = [stretch for stretch in stretches(walk) if stretch.level not in ("safe", "rough")]
    return ", ".join(dict.fromkeys(how(stretch) for stretch in bad))


def how(ended: Stretch | Probe) -> str:
    """How a run ended, and whether it did so quietly."""
    name = "wrong" if ended.outcome == "completed" else ended.outcome
    return f"{name} (undetected)" if ended.undetected else name


def span_text(probes: Sequence[Probe], between: str = " .. ") -> str:
    """The first and the last value of some runs, as `199 .. 31 steps`, or the only one."""
    first, last = probes[0].text, probes[-1].text
    if first == last:
        return first
    unit = last.partition(" ")[2]
    bare = unit[:1].isalpha() and first.endswith(f" {unit}")
    return f"{first.removesuffix(f' {unit}') if bare else first}{between}{last}"
