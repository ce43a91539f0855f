"""A long run at the end of some of its revolutions.

How a machine fares over very many revolutions: one run, marked as it goes.
"""

from __future__ import annotations

from conrod.exact.motion import Array
from conrod.studies.frame.measurement import Measurement
from conrod.studies.frame.study import Study
from conrod.studies.limits.axis import Axis
from conrod.studies.limits.case import Case
from conrod.studies.limits.cell import LimitCell
from conrod.studies.limits.extremes import Extremes, Mark
from conrod.studies.limits.grade import ROUGH_ERROR, SAFE_ERROR, Level, grade_of
from conrod.studies.limits.results import LongRun, Probe, Walk
from conrod.studies.limits.walk import CRITERIA, boundary_of, most_runs, probe_of, walk_search

SHORT = 2.0  # revolutions of a run that needs no history
DECADE = (1, 2, 5)


def marked(revolutions: float) -> tuple[int, ...]:
    """1, 2, 5, 10, 20, .. and the last revolution that is completed; none of a short run."""
    if revolutions <= SHORT:
        return ()
    last = int(revolutions)
    series = (digit * 10**power for power in range(len(str(last))) for digit in DECADE)
    return (*(mark for mark in series if mark < last), last)


class History:
    """Marks of a run of which samples come in order, however many at a time."""

    def __init__(self, revolutions: float, steps_per_revolution: int) -> None:
        self.marks: list[Mark] = []
        self._steps = steps_per_revolution
        self._due = list(marked(revolutions))
        self._position = self._closure = 0.0

    @property
    def goes_on(self) -> bool:
        """Whether a mark is still to come."""
        return bool(self._due)

    def add(self, first: int, position: Array, closure: Array, phase: Array, clock: Array) -> None:
        """Take in the samples from the one of an index on; each argument (T,), as `Mark` has them."""
        begin, end = 0, len(position)
        while self._due and begin < end:
            at = self._due[0] * self._steps - first  # place of the mark's sample
            rows = slice(begin, min(at + 1, end))
            self._position = max(self._position, float(position[rows].max()))
            self._closure = max(self._closure, float(closure[rows].max()))
            if at < end:
                mark = Mark(self._due.pop(0), self._position, self._closure, float(phase[at]), float(clock[at]))
                self.marks.append(mark)
                self._position = self._closure = 0.0
            begin = rows.stop


def length_search(axis: Axis, case: Case, revolutions: float) -> Study[tuple[Walk, LongRun]]:
    """The longest run: its marks show all shorter ones. Where something changes on the way, shorter runs find where.

    Raises:
        InvalidInput: the number of revolutions is out of range.
    """
    cell = axis.cell(case, revolutions)
    measurement = (yield (cell,))[cell.key]
    watched = Extremes.of(measurement)
    marks = () if watched is None else watched.history
    probes = [_marked(axis, case, mark, cell.key) for mark in marks]
    last = probe_of(axis, case, _reached(cell, watched), cell, measurement, lambda _: None)
    if not probes or probes[-1].value < last.value:
        probes.append(last)
    if len({probe.level for probe in probes}) == 1 and measurement.errors is not None:
        boundaries = tuple(boundary_of(probes, level) for level in CRITERIA)
        walk = Walk(axis.name, case.name, case.engine, case.preset, "", tuple(probes), boundaries)
    else:
        walk = yield from walk_search(axis, case, axis.harmless, revolutions, lambda _: None)
    return walk, _long_run(case, cell, measurement, marks)


def most_length_runs(axis: Axis, case: Case, revolutions: float) -> int:
    """The largest number of runs that the search can ask for; the longest one is shared with the walk."""
    return most_runs(axis, case, axis.harmless, revolutions)


def _reached(cell: LimitCell, watched: Extremes | None) -> float:
    """Revolutions of which there are samples."""
    if watched is None:
        return cell.revolutions
    return min(cell.revolutions, watched.samples / cell.settings.steps_per_revolution)


def _marked(axis: Axis, case: Case, mark: Mark, key: str) -> Probe:
    level = Level.SAFE if mark.position <= SAFE_ERROR else Level.ROUGH if mark.position <= ROUGH_ERROR else Level.WRONG
    value = float(mark.revolution)
    errors = {"position": mark.position}
    quiet = level is Level.WRONG
    return Probe(value, axis.text(case, value), level.slug, "completed", quiet, "", errors, None, "", None, key)


def _long_run(case: Case, cell: LimitCell, measurement: Measurement, marks: tuple[Mark, ...]) -> LongRun:
    return LongRun(
        scene=case.name,
        engine=case.engine,
        preset=case.preset,
        steps_per_revolution=cell.settings.steps_per_revolution,
        revolutions=cell.revolutions,
        outcome=grade_of(measurement).outcome,
        reason=measurement.reason,
        marks=marks,
    )
