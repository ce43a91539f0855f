"""Wrong, and nothing says so: the dangerous runs, which come first in every report."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from conrod.report import numbers
from conrod.report.charts.styles import engine_title
from conrod.report.limits.words import largest_error, span_text
from conrod.report.markdown import listed
from conrod.report.tables import table
from conrod.studies.limits.axes import AXES
from conrod.studies.limits.grade import Level
from conrod.studies.limits.results import LimitStudy, Probe, Walk, stretches

LEVELS = [level.slug for level in Level]
HEAD = ["axis", "engine", "preset", "where", "what it is", "how it ended", "largest position error / L"]
MOST_NAMED = 4  # values of a list that are given one by one
NO_ERROR = "none kept"


@dataclass(frozen=True)
class QuietRange:
    """Runs of one walk that are wrong in the same way and that nothing gives away.

    Attributes:
        of: how many runs the walk has.
    """

    walk: Walk
    level: str
    outcome: str
    probes: tuple[Probe, ...]
    of: int

    @property
    def where(self) -> str:
        """The values, as people read them."""
        if self.walk.boundaries:
            return span_text(self.probes)
        if len(self.probes) == 1:
            return self.probes[0].text
        named = ", ".join(probe.text for probe in self.probes[:MOST_NAMED])
        more = len(self.probes) - MOST_NAMED
        return f"{len(self.probes)} of {self.of}: {named}" + (f" and {more} more" if more > 0 else "")

    @property
    def row(self) -> list[str]:
        """The cells of its row."""
        ended = "ran to its end" if self.outcome == "completed" else f"`{self.outcome}`"
        error = largest_error(self.probes)
        return [
            AXES[self.walk.axis].title,
            engine_title(self.walk.engine),
            self.walk.preset,
            self.where,
            self.level,
            ended,
            NO_ERROR if error is None else numbers.measured(error),
        ]


def quiet_ranges(walks: Sequence[Walk]) -> list[QuietRange]:
    """All of them; a motion in one piece first, since it is the hardest to tell from a right one."""
    found = [one for walk in walks for one in _of_walk(walk)]
    return sorted(found, key=lambda one: LEVELS.index(one.level))


def _of_walk(walk: Walk) -> list[QuietRange]:
    if walk.boundaries:
        quiet = [stretch for stretch in stretches(walk) if stretch.undetected]
        return [QuietRange(walk, s.level, s.outcome, s.probes, len(walk.probes)) for s in quiet]
    # Values of a list are no neighbours: those that ended alike are taken together, wherever they stand.
    alike: dict[tuple[str, str], list[Probe]] = {}
    for probe in walk.probes:
        if probe.undetected:
            alike.setdefault((probe.level, probe.outcome), []).append(probe)
    return [QuietRange(walk, *kind, tuple(probes), len(walk.probes)) for kind, probes in alike.items()]


def quiet_table(walks: Sequence[Walk]) -> str:
    """A row for each range; nothing where there is none."""
    return table(HEAD, [one.row for one in quiet_ranges(walks)])


def quiet_summary(walks: Sequence[Walk]) -> str:
    """A row for each machine, axis and way of being wrong, with who is so and where."""
    groups: dict[tuple[str, ...], list[QuietRange]] = {}
    for one in quiet_ranges(walks):
        groups.setdefault((one.level, one.walk.scene, one.walk.axis, one.outcome), []).append(one)
    rows = []
    for (level, scene, axis, outcome), found in groups.items():
        ended = "ran to its end" if outcome == "completed" else f"`{outcome}`"
        places: dict[str, list[str]] = {}
        for one in found:
            places.setdefault(f"{engine_title(one.walk.engine)} {one.walk.preset}", []).append(one.where)
        who = "; ".join(f"{name}: {', '.join(where)}" for name, where in places.items())
        largest = largest_error([probe for one in found for probe in one.probes])
        error = NO_ERROR if largest is None else numbers.measured(largest)
        rows.append([f"[{scene}]({scene}.md)", AXES[axis].title, f"{level}, {ended}", who, error])
    return table(["machine", "axis", "what it is", "who, and where", HEAD[-1]], rows)


def quiet_elsewhere(study: LimitStudy) -> str:
    """How many runs are quiet that are on no walk of an axis alone: of maps, and with iterations that stay."""
    on_maps = [run.undetected for found in study.maps for run in found.runs]
    iterated = [probe.undetected for need in study.needs for walk in need.walks for probe in walk.probes]
    counted = {"of the maps": on_maps, "with iterations that stay": iterated}
    said = [f"{sum(runs)} of {len(runs)} runs {which}" for which, runs in counted.items() if any(runs)]
    return f"Quiet are also {listed(said)}." if said else ""
