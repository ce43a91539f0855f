"""An axis walked from harmless to hopeless, and the boundaries on the way found by halving."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from itertools import pairwise

from conrod.studies.frame.measurement import QUANTITIES, Measurement
from conrod.studies.frame.study import Results, Study
from conrod.studies.limits.axis import Axis, Scale, between, spaced
from conrod.studies.limits.case import Case
from conrod.studies.limits.cell import LimitCell
from conrod.studies.limits.extremes import Extremes
from conrod.studies.limits.grade import Level, grade_of
from conrod.studies.limits.results import Boundary, Probe, Walk
from conrod.studies.limits.solver_notes import solver_note

# Three looks in each of four decades: what fails and holds again between two of them is missed.
SCANNED = 13
LEVELS = tuple(Level)
# The worst level that still counts, for each boundary that is looked for.
CRITERIA = (Level.SAFE, Level.ROUGH, Level.WRONG, Level.BROKEN)

Ruler = Callable[[LimitCell], float | None]


def walk_search(axis: Axis, case: Case, first: float, last: float, ruler: Ruler) -> Study[Walk]:
    """Walk an axis between two values, the harmless one first.

    Args:
        ruler: own error of the reference in a cell, normalised; None where it is at its usual rounding.

    Raises:
        InvalidInput: the machine cannot be given with a value of the range.
    """
    listed = axis.scale is Scale.LISTED
    cells: dict[float, LimitCell] = {}
    answers: dict[str, Measurement] = {}
    wanted = list(axis.values(case)) if listed else _scanned(axis, first, last)
    while wanted:
        new = {value: axis.cell(case, value) for value in wanted}
        cells |= new
        answers |= yield tuple(new.values())
        wanted = [] if listed else _halved(axis, _in_order(cells, first, last), cells, answers)
    ordered = list(cells) if listed else _in_order(cells, first, last)
    probes = tuple(probe_of(axis, case, value, cells[value], answers[cells[value].key], ruler) for value in ordered)
    boundaries = () if listed else tuple(boundary_of(probes, level) for level in CRITERIA)
    return Walk(axis.name, case.name, case.engine, case.preset, "", probes, boundaries)


def most_runs(axis: Axis, case: Case, first: float, last: float) -> int:
    """The largest number of runs that a walk can ask for."""
    if axis.scale is Scale.LISTED:
        return len(axis.values(case))
    scanned = _scanned(axis, first, last)
    if len(scanned) < 2:
        return len(scanned)
    # In every round each criterion halves a gap. Where values are whole numbers, gaps are not all as wide.
    halvings = max(_halvings(axis, good, bad) for good, bad in pairwise(scanned))
    return len(scanned) + len(CRITERIA) * (halvings + 1)


def _halvings(axis: Axis, good: float, bad: float) -> int:
    found = 0
    while (middle := _middle(axis, good, bad)) is not None:
        found, good = found + 1, middle
    return found


def _scanned(axis: Axis, first: float, last: float) -> list[float]:
    return list(dict.fromkeys(axis.nearest(value) for value in spaced(axis.scale, first, last, SCANNED)))


def _middle(axis: Axis, good: float, bad: float) -> float | None:
    """The value that exists half-way between two; None where they are near enough, or none does."""
    found = between(axis.scale, good, bad)
    nearest = None if found is None else axis.nearest(found)
    return None if nearest in (good, bad) else nearest


def _in_order(cells: Mapping[float, LimitCell], first: float, last: float) -> list[float]:
    return sorted(cells, reverse=last < first)


def _halved(axis: Axis, ordered: Sequence[float], cells: Mapping[float, LimitCell], answers: Results) -> list[float]:
    """The value to look at next for every boundary that is not yet narrow enough."""
    levels = [LEVELS.index(grade_of(answers[cells[value].key]).level) for value in ordered]
    found = []
    for criterion in CRITERIA:
        k = _first_worse(levels, LEVELS.index(criterion))
        if k is None or k == 0:
            continue
        middle = _middle(axis, ordered[k - 1], ordered[k])
        if middle is not None:
            found.append(middle)
    return list(dict.fromkeys(found))


def _first_worse(levels: Sequence[int], worst: int) -> int | None:
    return next((k for k, level in enumerate(levels) if level > worst), None)


def probe_of(axis: Axis, case: Case, value: float, cell: LimitCell, measurement: Measurement, ruler: Ruler) -> Probe:
    """What a run on an axis showed."""
    grade, watched = grade_of(measurement), Extremes.of(measurement)
    errors = {q: measurement.largest(q) for q in QUANTITIES}
    return Probe(
        value=value,
        text=axis.text(case, value),
        level=grade.level.slug,
        outcome=grade.outcome,
        quiet=grade.quiet,
        reason=measurement.reason,
        errors=None if measurement.errors is None else {q: e for q, e in errors.items() if e is not None},
        torque=None if watched is None else watched.torque,
        solver="" if watched is None else solver_note(watched.solver),
        ruler=ruler(cell),
        key=cell.key,
    )


def boundary_of(probes: Sequence[Probe], criterion: Level) -> Boundary:
    """Up to where a criterion holds, among probes in the order from harmless to hopeless."""
    slugs = [level.slug for level in LEVELS]
    worst = slugs.index(criterion.slug)
    k = _first_worse([slugs.index(probe.level) for probe in probes], worst)
    if k is None:
        return Boundary(criterion.slug, probes[-1].value, None, None, False, ())
    again = tuple(probe.value for probe in probes[k:] if slugs.index(probe.level) <= worst)
    last_good = probes[k - 1].value if k else None
    return Boundary(criterion.slug, last_good, probes[k].value, probes[k].outcome, probes[k].quiet, again)
