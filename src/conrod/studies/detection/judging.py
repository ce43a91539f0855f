"""The verdict on runs into which defects were planted: whether it notices them, and from what size on."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import replace
from typing import Any

from conrod.engines.engine import PIECE, Engine
from conrod.engines.running import followed
from conrod.engines.tracks import ForceTracks
from conrod.errors import InvalidInput
from conrod.exact.reference import ExactReference
from conrod.runs.outcome import Verdict, judge
from conrod.runs.run_errors import RunErrors
from conrod.runs.trajectory import Outcome, Piece
from conrod.studies.detection.defects import Defect
from conrod.studies.detection.machine_defects import Plant, Recording
from conrod.studies.forces.measuring import Measured, Peaks, likenesses
from conrod.studies.forces.results import ForceResult
from conrod.studies.frame.result import Result
from conrod.studies.validation.results import Noticed, ValidationResult

FINE = 1.1  # a smallest size is found to a tenth
SEEN = 1e-2  # of a tolerance: what changes a judged error by less, at its largest size, cannot be seen in it
LEAST = 1e-15  # and not looked for below this

Judge = Callable[[Recording], Result]


class Replay(Engine[Any]):
    """An engine that gives one recorded run again; how it ended is judged anew."""

    def __init__(self, run: Piece, healthy: ExactReference) -> None:
        self.name, self.version, self.presets = run.trajectory.engine, run.trajectory.engine_version, {}
        self._run, self._healthy = run, healthy

    def refusal(self, machine: Any, settings: Any) -> str | None:
        return None

    def run(
        self, machine: Any, settings: Any, revolutions: float, start_angle: float = 0.0, steps: int = PIECE
    ) -> Iterator[Piece]:
        trajectory = self._run.trajectory
        assert trajectory.bodies is not None
        ended = judge(self._healthy.kinematics, trajectory.bodies, trajectory.speed, Verdict(trajectory.outcome))
        yield replace(self._run, trajectory=replace(trajectory, outcome=ended.outcome, reason=ended.reason))


def motion_judge(result: ValidationResult, healthy: ExactReference, asked: Mapping[str, float] | None) -> Judge:
    """The judge of `conrod validate`, by the tolerances of a result, or by those asked for."""

    def judged(given: Recording) -> ValidationResult:
        errors, run = RunErrors(), given.run.trajectory
        ended = followed(Replay(given.run, healthy), given.reference, run.settings, result.revolutions, 0.0, errors)
        found = errors.found() if ended.outcome is Outcome.COMPLETED else {}
        return replace(result, outcome=ended.outcome.slug, reason=ended.reason, **found).judged(asked)

    return judged


def force_judge(result: ForceResult, tracks: ForceTracks, peaks: Peaks, step: float) -> Judge:
    """The judge of `conrod validate --quantity`, of the forces of a run as they were recorded in steps [s]."""

    def judged(given: Recording) -> ForceResult:
        measured = Measured(given.reference, tracks, peaks, step)
        likeness = likenesses(given.reference, measured, result.names)
        return replace(result, errors=measured.errors(result.names), likeness=likeness).judged()

    return judged


def noticed_by(result: Result) -> tuple[str, ...]:
    """What fails a result; nothing of one that passed."""
    if result.passed is not False:
        return ()
    return (*result.exceeded(), *result.faults()) if result.completed else (result.outcome,)


def examined(defect: Defect, given: Recording, judged: Judge, unseen: Collection[str] = ()) -> Noticed | None:
    """The verdict on one kind of defect in a run; None where the machine has no place for it.

    Args:
        unseen: places that nothing which is judged depends on.
    """
    places = [(where, plant) for where, plant in defect.plants(given) if where not in unseen]
    found = [_examined_at(defect, where, plant, given, judged) for where, plant in places]
    # Where a defect can be seen at all, the place counts at which the verdict sees least.
    return max(found, key=lambda one: (one.visible, not one.by, one.smallest or math.inf), default=None)


def _examined_at(defect: Defect, where: str, plant: Plant, given: Recording, judged: Judge) -> Noticed:
    def notices(size: float) -> tuple[str, ...]:
        try:
            return noticed_by(judged(plant(given, size)))
        except InvalidInput:
            return ("cannot be put together",)

    by = notices(defect.size)
    if not defect.unit:
        return Noticed(defect.name, "", where, defect.size, by, None)
    smallest = smallest_noticed(lambda size: bool(notices(size)), defect.largest)
    if smallest is not None and not notices(-smallest):
        smallest = smallest_noticed(lambda size: bool(notices(-size)), defect.largest)
    visible = smallest is not None or _change(judged(given), judged(plant(given, defect.largest))) > SEEN
    return Noticed(defect.name, defect.unit, where, defect.size, by, smallest, visible)


def _change(healthy: Result, planted: Result) -> float:
    """Largest change of a judged error, over what is allowed."""
    sizes = [
        (healthy.judged_error(q) or 0.0, planted.judged_error(q) or 0.0, limit) for q, limit in healthy.limits.items()
    ]
    return max(abs(after - before) / allowed for before, after, allowed in sizes)


def smallest_noticed(noticed: Callable[[float], bool], largest: float) -> float | None:
    """The smallest size that is noticed, to `FINE`, by bisection of its logarithm; None where none is up to a size."""
    low, high = LEAST, largest
    if not noticed(largest):
        return None
    while high > FINE * low:
        middle = math.sqrt(low * high)
        low, high = (low, middle) if noticed(middle) else (middle, high)
    return high
