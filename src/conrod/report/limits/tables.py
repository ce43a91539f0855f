"""Tables of a report of limits, and what they say of walks, of single runs and of neighbours that ended alike."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from typing import Any

from conrod.report import numbers
from conrod.report.charts.styles import engine_title, preset_title
from conrod.report.table import Cell, Table, Toned, table
from conrod.report.template import listed
from conrod.studies.limits.axes import AXES
from conrod.studies.limits.determinism import RUNS, Determinism
from conrod.studies.limits.maps import LimitMap, standing
from conrod.studies.limits.records import LEVELS, ROUGH_ERROR, SAFE_ERROR, Mark
from conrod.studies.limits.results import LimitStudy, LongRun, Probe, Walk, stretches

WHO = ("engine", "preset")
# Criterion -> the heading of its column.
BOUNDARIES = {
    "safe": f"within {100 * SAFE_ERROR:g} %",
    "rough": f"within {100 * ROUGH_ERROR:g} %",
    "wrong": "in one piece",
    "broken": "bounded",
}
BEYOND = "beyond 10 %"
BOUNDED = (*BOUNDARIES.values(), BEYOND)
EVERYWHERE, NOWHERE, NOT_AT_FIRST, NONE = "all of it", "none of it", "not at first", "-"
AGAIN = " *"  # after a value: there are runs further on that keep the criterion
LARGEST = "largest position error / L"
MOST_NAMED = 4  # values of a list that are given one by one
SHOWN = 12  # hexadecimal digits of a fingerprint


# -- words -----------------------------------------------------------------------------------------------------------


def who(finding: Any) -> tuple[str, str]:
    """Return engine and preset, for the first cells of a row."""
    return engine_title(finding.engine), finding.preset


def by_axis(walks: Iterable[Walk]) -> dict[str, list[Walk]]:
    """Return walks by the names of their axes, in their order."""
    found: dict[str, list[Walk]] = {}
    for walk in walks:
        found.setdefault(walk.axis, []).append(walk)
    return found


def up_to(walk: Walk, criterion: str) -> str:
    """Return the last value at which a criterion holds, coming from the safe end."""
    boundary = walk.boundary(criterion)
    if boundary.first_bad is None:
        return EVERYWHERE
    again = AGAIN if boundary.good_again else ""
    if boundary.last_good is None:
        return (NOT_AT_FIRST if again else NOWHERE) + again
    return walk.text_at(boundary.last_good) + again


def bounded(walk: Walk) -> tuple[str, ...]:
    """Return how far each criterion holds, and how the runs beyond ten per cent ended, from the safe end on."""
    ends = dict.fromkeys(how(alike[0]) for alike in stretches(walk) if not alike[0].good)
    return (*(up_to(walk, criterion) for criterion in BOUNDARIES), ", ".join(ends) or NONE)


def how(probe: Probe) -> str:
    """Return how a run ended, and whether undetected."""
    name = "wrong" if probe.outcome == "completed" else probe.outcome
    return f"{name} (undetected)" if probe.undetected else name


def span_text(probes: Sequence[Probe]) -> str:
    """Return the first and the last value of some runs, as `199 .. 31 steps`, or the only one."""
    first, last = probes[0].text, probes[-1].text
    if first == last:
        return first
    unit = last.partition(" ")[2]
    bare = unit[:1].isalpha() and first.endswith(f" {unit}")
    return f"{first.removesuffix(f' {unit}') if bare else first} .. {last}"


def undetected_words(walks: Iterable[Walk]) -> str:
    """Return how many runs are wrong and undetected, and on how many walks."""
    walked = [walk for walk in walks if walk.probes]
    runs = [probe for walk in walked for probe in walk.probes]
    affected = sum(any(probe.undetected for probe in walk.probes) for walk in walked)
    return f"{sum(probe.undetected for probe in runs)} of {len(runs)} runs, on {affected} of {len(walked)} walks"


def refusals(walks: Iterable[Walk]) -> list[str]:
    """Return why an axis was not walked, each reason once, with those that it is for."""
    refused: dict[str, dict[str, list[str]]] = {}
    for walk in walks:
        if walk.refusal:
            refused.setdefault(walk.refusal, {}).setdefault(engine_title(walk.engine), []).append(f"`{walk.preset}`")
    return [
        f"Not walked with {'; '.join(f'{engine} {listed(presets)}' for engine, presets in of.items())}: {reason}."
        for reason, of in refused.items()
    ]


def largest_error(probes: Iterable[Probe]) -> float | None:
    """Return the largest position error of the runs that completed; None where none did."""
    return max((probe.position for probe in probes if probe.position is not None), default=None)


# -- walks -----------------------------------------------------------------------------------------------------------


def reach_table(walks: Iterable[Walk]) -> Table:
    """Return a row for each axis and direction that has boundaries: how far the error stays within 10 %, by preset."""
    ways: dict[tuple[str, bool], dict[str, str]] = {}
    ends: dict[tuple[str, bool], str] = {}
    for walk in (walk for walk in walks if walk.boundaries):
        way, undetected = (walk.axis, walk.falling), walk.boundary("rough").undetected
        reached = up_to(walk, "rough") + (", then undetected" if undetected else "")
        ways.setdefault(way, {})[preset_title(walk.engine, walk.preset)] = reached
        ends.setdefault(way, walk.probes[-1].text)
    presets = dict.fromkeys(preset for found in ways.values() for preset in found)
    rows = [
        (AXES[way[0]].title, ends[way], *(found.get(preset, NONE) for preset in presets)) for way, found in ways.items()
    ]
    return table(("within 10 % along", "towards", *presets), rows)


def limits_table(study: LimitStudy) -> Table:
    """Return the boundaries of all walks of a scene, for a terminal."""
    rows = [(walk.axis, *who(walk), *bounded(walk)) for walk in study.walks if walk.boundaries]
    title = f"{study.name}: holds up to (undetected: finite numbers, no warning, wrong motion)"
    return table(("axis", *WHO, *BOUNDED), rows, title=title, names=3)


def boundaries_table(walks: Sequence[Walk]) -> Table:
    """Return the boundaries of all walks of an axis; of a list of values how many ended how."""
    found = [walk for walk in walks if walk.boundaries]
    if not found:
        return listed_table(walks)
    rows = [(*who(walk), span_text(walk.probes), *bounded(walk), _fails_from(walk)) for walk in found]
    return table((*WHO, "from .. to", *BOUNDED, "fails from"), rows)


def _fails_from(walk: Walk) -> str:
    """Return the first value of each ending beyond ten per cent, in the order of `bounded`."""
    first: dict[str, str] = {}
    for alike in stretches(walk):
        if not alike[0].good:
            first.setdefault(how(alike[0]), alike[0].text)
    return ", ".join(first.values()) or NONE


def listed_table(walks: Sequence[Walk], title: str = "") -> Table:
    """Return, for each walk over a list of values, how many runs ended well, and how the others did."""
    rows, found = [], [walk for walk in walks if walk.probes and not walk.boundaries]
    for walk in found:
        ends = Counter(probe.outcome for probe in walk.probes if probe.outcome != "completed")
        counts = str(len(walk.probes)), str(sum(probe.good for probe in walk.probes))
        error = numbers.measured(largest_error(walk.probes))
        ended = ", ".join(f"{n} {outcome}" for outcome, n in ends.items()) or NONE
        rows.append((walk.axis, *who(walk), *counts, error, ended))
    return table(("axis", *WHO, "runs", "within 10 %", LARGEST, "ended otherwise"), rows, title=title)


def undetected_table(walks: Iterable[Walk]) -> Table:
    """Return a row for each axis and way of being wrong and undetected, with who is so and where.

    A motion in one piece comes first: it is the hardest to distinguish from a right one.
    """
    groups: dict[tuple[str, str, str], list[tuple[Walk, tuple[Probe, ...]]]] = {}
    for walk in walks:
        for alike in _undetected(walk):
            groups.setdefault((alike[0].level, walk.axis, alike[0].outcome), []).append((walk, alike))
    rows = []
    for (level, axis, outcome), found in sorted(groups.items(), key=lambda group: LEVELS.index(group[0][0])):
        ended = "ran to its end" if outcome == "completed" else f"`{outcome}`"
        places: dict[str, list[str]] = {}
        for walk, alike in found:
            places.setdefault(" ".join(who(walk)), []).append(_where(walk, alike))
        shown = "; ".join(f"{name}: {', '.join(where)}" for name, where in places.items())
        largest = largest_error(probe for _, alike in found for probe in alike)
        rows.append((AXES[axis].title, f"{level}, {ended}", shown, numbers.measured(largest)))
    return table(("axis", "result", "engines and presets, and where", LARGEST), rows)


def _undetected(walk: Walk) -> list[tuple[Probe, ...]]:
    if walk.boundaries:
        return [alike for alike in stretches(walk) if alike[0].undetected]
    # Values of a list are no neighbours: those that ended alike are taken together, wherever they stand.
    found: dict[tuple[str, str], tuple[Probe, ...]] = {}
    for probe in (probe for probe in walk.probes if probe.undetected):
        end = probe.level, probe.outcome
        found[end] = (*found.get(end, ()), probe)
    return list(found.values())


def _where(walk: Walk, alike: Sequence[Probe]) -> str:
    if walk.boundaries or len(alike) == 1:
        return span_text(alike)
    more = len(alike) - MOST_NAMED
    named = ", ".join(probe.text for probe in alike[:MOST_NAMED]) + (f" and {more} more" if more > 0 else "")
    return f"{len(alike)} of {len(walk.probes)}: {named}"


# -- steps, maps, iterations, repeated and long runs -----------------------------------------------------------------


def steps_table(walks: Iterable[Walk]) -> Table:
    """Return a row for each scene, engine and preset whose steps were walked."""
    walked = [walk for walk in walks if walk.axis == "steps" and walk.boundaries]
    return table(("machine", *WHO, *BOUNDED), [(walk.scene, *who(walk), *bounded(walk)) for walk in walked])


def maps_table(maps: Iterable[LimitMap]) -> Table:
    """Return a row for each map: how many of its nodes were run, and of what its areas are."""
    standings = list(dict.fromkeys(map(standing, LEVELS)))
    rows = []
    for found in maps:
        counted = Counter(standing(run.level) for run in found.shown.values())
        axes = (AXES[found.x_axis].title, AXES[found.y_axis].title)
        shares = (numbers.percent(counted[name] / found.nodes) for name in standings)
        run = (str(found.nodes), str(len(found.runs)), numbers.percent(found.share))
        rows.append((*who(found), *axes, *run, *shares))
    return table((*WHO, "across", "upwards", "nodes", "runs", "share", *(f"{name} nodes" for name in standings)), rows)


def determinism_table(found: Iterable[Determinism]) -> Table:
    """Return a row for each engine and preset."""
    rows = []
    for one in found:
        first = one.fingerprints.get(RUNS[0])
        fingerprint = numbers.MISSING if first is None else f"`{first[:SHOWN]}`"
        rows.append((*who(one), *(_same(one.identical.get(run)) for run in RUNS[1:]), one.outcome, fingerprint))
    return table((*WHO, "again in one process", *RUNS[2:], "ended", "fingerprint"), rows)


def _same(identical: bool | None) -> Cell:
    return numbers.MISSING if identical is None else "identical" if identical else Toned("different", "bad")


def long_run_table(runs: Iterable[LongRun]) -> Table:
    """Return a row for each run: the first mark beside the last one."""
    head = (*WHO, "steps per revolution", "revolutions", "ended", "loop error / L, first revolution", "at the end")
    rows = []
    for run in runs:
        last: Mark | None = run.marks[-1] if run.marks else None
        failed = last is not None and run.outcome != "completed"
        ended = f"{run.outcome} after {numbers.quantity(last.revolution)}" if failed and last else run.outcome
        gaps, phases = ([], []) if last is None else ([run.marks[0].closure, last.closure], [last.phase, last.clock])
        steps = str(run.steps_per_revolution), numbers.quantity(run.revolutions)
        sizes = [*map(numbers.measured, gaps), *map(numbers.in_degrees, phases)] or [numbers.MISSING] * 4
        rows.append((*who(run), *steps, ended, *sizes))
    return table((*head, "phase at the end [deg]", "of a clock that sums its steps [deg]"), rows)
