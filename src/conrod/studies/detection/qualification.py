"""Qualification in place: known defects in the very run that is judged, and which of them its verdict notices."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar

from conrod.engines import Engine
from conrod.engines.capabilities import ForceReport
from conrod.engines.run import feed_recorders
from conrod.engines.tracks import ForceTracks
from conrod.errors import InvalidInput
from conrod.exact import ExactReference
from conrod.runs.outcome import RunVerdict, judge
from conrod.runs.run_errors import RunErrors
from conrod.runs.trajectory import Outcome
from conrod.scenes import Scene
from conrod.studies.detection.defects import MASS, MOTION, Defect, Plant, Recording
from conrod.studies.forces.measuring import LawOfForces, Measured, Peaks, likenesses, peaks_of, seen_in
from conrod.studies.forces.results import ForceResult
from conrod.studies.forces.study import ForcePlan, recorded_forces
from conrod.studies.frame.case import Study
from conrod.studies.frame.result import EngineCase, Result, case_results
from conrod.studies.validation.plan import Plan, begun, started
from conrod.studies.validation.results import Noticed, Qualified, SceneStudy, ValidationResult

FINE = 1.1  # a smallest size is found to a tenth
SEEN = 1e-2  # of a tolerance: what changes a judged error by less, at its largest size, cannot be seen in it
LEAST = 1e-15  # and not looked for below this

Judge = Callable[[Recording], Result]


def motion_judge(
    result: ValidationResult, healthy: ExactReference, asked: Mapping[str, float] | None
) -> Callable[[Recording], ValidationResult]:
    """The judge of `conrod validate`, by the tolerances of a result, or by those asked for."""

    def judged(given: Recording) -> ValidationResult:
        errors, run = RunErrors(), given.run.trajectory
        assert run.bodies is not None
        # How it ended is judged anew.
        ended = judge(healthy.kinematics, run.bodies, run.speed, RunVerdict(run.outcome))
        piece = replace(given.run, trajectory=replace(run, outcome=ended.outcome, reason=ended.reason))
        ended = feed_recorders(
            [piece], round(run.settings.steps_per_revolution * result.revolutions) + 1, given.reference, errors
        )
        found = errors.as_dict() if ended.outcome is Outcome.COMPLETED else {}
        return replace(result, outcome=ended.outcome.slug, reason=ended.reason, **found).with_verdict(asked)

    return judged


def force_judge(result: ForceResult, tracks: ForceTracks, law: LawOfForces | None, peaks: Peaks, step: float) -> Judge:
    """The judge of `conrod forces`, of the forces of a run as they were recorded in steps [s]."""

    def judged(given: Recording) -> ForceResult:
        measured = Measured(given.reference, tracks, peaks, step)
        likeness = likenesses(given.reference, measured, result.names, law)
        return replace(result, errors=measured.errors(result.names), likeness=likeness).with_verdict()

    return judged


def noticed_by(result: Result) -> tuple[str, ...]:
    """Reasons that fail a result; none of one that passed."""
    if result.passed is not False:
        return ()
    return (*result.out_of_tolerance(), *result.faults()) if result.completed else (result.outcome,)


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


@dataclass(frozen=True)
class QualificationCase(EngineCase[ValidationResult]):
    """A run of a scene in an engine with a preset, recorded whole, and judged with each defect planted in it.

    Its tolerances are a part of it, since what is noticed depends on them; nothing is planted in what does not pass.
    """

    study: ClassVar[str] = "qualification"
    kind: ClassVar[type[Any]] = ValidationResult
    quantities: ClassVar[tuple[str, ...]] = ()
    version: ClassVar[int] = 6  # since gravity and what is no number are planted, and other kinds are not
    defects: ClassVar[tuple[Defect, ...]] = (*MOTION, MASS)

    plan: Plan

    def empty_result(self) -> ValidationResult:
        return started(self.name, self.scene, self.loaded_engine, self.preset, self.plan)

    def key_fields(self) -> dict[str, Any]:
        settings = self.loaded_engine.presets[str(self.preset)](self.scene, self.plan.steps(self.scene)).as_dict()
        return {"settings": settings, "revolutions": self.plan.revolutions, "tolerance": self.plan.tolerance}

    def run(self) -> ValidationResult:
        scene, engine, plan = self.scene, self.loaded_engine, self.plan
        result, settings, start = begun(self.name, scene, engine, str(self.preset), plan)
        if not result.completed:
            return result
        given = Recording.of(engine, scene, settings, result.revolutions, start)
        judge = motion_judge(result, scene, plan.tolerance)
        healthy = judge(given)
        if healthy.passed is not True:
            return healthy
        motion = [examined(defect, given, judge) for defect in self.defects]
        return healthy.with_qualified(Qualified(tuple(one for one in motion if one), self._forces(given)))

    def _forces(self, given: Recording) -> tuple[Noticed, ...]:
        """Wrong masses that the verdict on the forces notices; none where they are not judged."""
        if not isinstance(self.loaded_engine, ForceReport):
            return ()
        plan = ForcePlan(self.plan.steps_per_revolution, self.plan.revolutions, refined=False)
        result, tracks, law = recorded_forces(self.name, self.scene, self.loaded_engine, str(self.preset), plan)
        if not result.completed or not result.limits:
            return ()
        peaks = peaks_of(self.scene)
        judge = force_judge(result, tracks, law, peaks, self.scene.period / result.steps_per_revolution)
        if judge(given).passed is not True:
            return ()
        # What no force depends on at constant speed shows by the drive's ripple at most.
        names = [name for name in result.names if name not in (result.unsupported or {})]
        seen = {body for body, quality in seen_in(self.scene, names, peaks) if quality == MASS.name}
        unseen = {body.name for body in self.scene.mechanism().bodies} - seen
        found = examined(MASS, given, judge, unseen)
        return () if found is None else (found,)


def qualified(
    studies: Sequence[SceneStudy], scenes: Mapping[str, Scene], engines: Sequence[Engine[Any]], plan: Plan
) -> Study[list[SceneStudy]]:
    """The study that gives each judged result of a validation what its verdict notices."""
    judged = {(s.name, r.engine, r.preset) for s in studies for r in s.results if r.mode == "dynamic" and r.passed}
    found = yield from case_results(
        QualificationCase(name, scene, engine.name, preset, plan)
        for name, scene in scenes.items()
        for engine in engines
        for preset in engine.presets
        if (name, engine.name, preset) in judged
    )
    known = {(one.scene, one.engine, one.preset): one.qualified for some in found.values() for one in some}
    return [
        replace(
            study,
            results=tuple(
                replace(r) if r.mode != "dynamic" else r.with_qualified(known.get((study.name, r.engine, r.preset)))
                for r in study.results
            ),
        )
        for study in studies
    ]
