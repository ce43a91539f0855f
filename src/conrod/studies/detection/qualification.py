"""Qualification of a verdict: which known defects it notices when they are planted."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar

from conrod.comparison.outcome import RunVerdict, judge_outcome
from conrod.comparison.run_errors import LinkSizes, RunErrors
from conrod.comparison.trajectory import Outcome
from conrod.engines import Engine
from conrod.engines.capabilities import ForceReport
from conrod.engines.run import feed_recorders
from conrod.engines.tracks import ForceTracks
from conrod.errors import InvalidInput
from conrod.exact.kinematics import ExactReference
from conrod.execution.case import Study
from conrod.execution.result import JudgedCase, JudgedResult, Plan, case_results
from conrod.execution.tolerances import Limit, scene_scales
from conrod.scenes import Scene
from conrod.studies.detection.defects import MASS_DEFECT, MOTION_DEFECTS, Defect, DefectFunction, Recording
from conrod.studies.forces.force_errors import ExpectedForceErrors, ForceComparison, Peaks, force_peaks
from conrod.studies.forces.mass_likeness import mass_likenesses, visible_properties
from conrod.studies.forces.results import ForceResult
from conrod.studies.forces.study import ForcePlan, record_forces
from conrod.studies.validation.dynamic_mode import prepare_run
from conrod.studies.validation.results import (
    DefectVerdict,
    Qualification,
    SceneStudy,
    ValidationResult,
    empty_result,
)

SIZE_RATIO = 1.1  # resolution of the smallest noticed size
# A defect that at its largest size changes no judged error by this share of its tolerance is invisible.
MIN_VISIBLE_CHANGE = 1e-2
MIN_DEFECT_SIZE = 1e-15  # lower end of the search for the smallest noticed size

Judge = Callable[[Recording], JudgedResult]


def motion_judge(
    result: ValidationResult, healthy: ExactReference, asked: Mapping[str, Limit] | None
) -> Callable[[Recording], ValidationResult]:
    """Return the judge of `conrod validate`, which compares a recording with its reference.

    Args:
        result: result of the run, whose tolerances judge.
        healthy: reference without a defect, whose branch the run has to keep.
        asked: tolerances that replace those of the result; None to keep them.
    """

    scales = scene_scales(healthy) if asked else {}

    def judge_recording(given: Recording) -> ValidationResult:
        errors, links, run = RunErrors(), LinkSizes(), given.run.trajectory
        assert run.bodies is not None
        # The outcome is judged again, since a defect may change it.
        ended = judge_outcome(healthy.kinematics, run.bodies, run.speed, RunVerdict(run.outcome))
        piece = replace(given.run, trajectory=replace(run, outcome=ended.outcome, reason=ended.reason))
        ended = feed_recorders(
            [piece], round(run.settings.steps_per_revolution * result.revolutions) + 1, given.reference, errors, links
        )
        found = {"links": links.errors, **errors.as_dict()} if ended.outcome is Outcome.COMPLETED else {}
        return replace(result, outcome=ended.outcome.slug, reason=ended.reason, **found).with_verdict(asked, scales)

    return judge_recording


def force_judge(
    result: ForceResult, tracks: ForceTracks, law: ExpectedForceErrors | None, peaks: Peaks, step: float
) -> Judge:
    """Return the judge of `conrod forces`, which compares recorded forces with exact forces.

    Args:
        tracks: recorded forces of the run.
        law: expected errors of the forces; None if the engine has no law.
        peaks: peaks that normalise the errors.
        step: step size of the run [s].
    """

    def judge_recording(given: Recording) -> ForceResult:
        measured = ForceComparison(given.reference, tracks, peaks, step)
        likeness = mass_likenesses(given.reference, measured, result.names, law)
        return replace(result, errors=measured.errors(result.names), likeness=likeness).with_verdict()

    return judge_recording


def failure_reasons(result: JudgedResult) -> tuple[str, ...]:
    """Return why a result fails: quantities and other failures, or its outcome; empty if it passed."""
    if result.passed is not False:
        return ()
    return (*result.out_of_tolerance(), *result.other_failures()) if result.completed else (result.outcome,)


def examine_defect(
    defect: Defect, recording: Recording, judge: Judge, unseen: Collection[str] = ()
) -> DefectVerdict | None:
    """Plant a kind of defect at each of its places; return the verdict on the least noticed one.

    Args:
        unseen: places that no judged quantity depends on, which are left out.

    Returns:
        None if the machine has no place for the defect.
    """
    places = [(where, plant) for where, plant in defect.places(recording) if where not in unseen]
    found = [_examine_place(defect, where, plant, recording, judge) for where, plant in places]
    # Among places where the defect is visible, the place counts at which the verdict notices least.
    return max(found, key=lambda one: (one.visible, not one.by, one.smallest or math.inf), default=None)


def _examine_place(
    defect: Defect, where: str, plant: DefectFunction, recording: Recording, judge: Judge
) -> DefectVerdict:
    """Plant a defect at one place, and search for the smallest size that is noticed."""

    def failures(size: float) -> tuple[str, ...]:
        try:
            return failure_reasons(judge(plant(recording, size)))
        except InvalidInput:
            return ("cannot be put together",)

    by = failures(defect.size)
    if not defect.unit:
        return DefectVerdict(defect.name, "", where, defect.size, by, None)
    smallest = smallest_noticed_size(lambda size: bool(failures(size)), defect.largest)
    if smallest is not None and not failures(-smallest):
        smallest = smallest_noticed_size(lambda size: bool(failures(-size)), defect.largest)
    visible = smallest is not None or (
        _largest_change(judge(recording), judge(plant(recording, defect.largest))) > MIN_VISIBLE_CHANGE
    )
    return DefectVerdict(defect.name, defect.unit, where, defect.size, by, smallest, visible)


def _largest_change(healthy: JudgedResult, planted: JudgedResult) -> float:
    """Largest change of a judged error by a planted defect, divided by its tolerance."""
    sizes = [
        (healthy.judged_error(q) or 0.0, planted.judged_error(q) or 0.0, limit) for q, limit in healthy.limits.items()
    ]
    return max(abs(after - before) / allowed for before, after, allowed in sizes)


def smallest_noticed_size(is_noticed: Callable[[float], bool], largest: float) -> float | None:
    """Bisect the logarithm of a size for the smallest noticed size, to a ratio of `SIZE_RATIO`.

    Returns:
        None if the largest size is not noticed.
    """
    low, high = MIN_DEFECT_SIZE, largest
    if not is_noticed(largest):
        return None
    while high > SIZE_RATIO * low:
        middle = math.sqrt(low * high)
        low, high = (low, middle) if is_noticed(middle) else (middle, high)
    return high


@dataclass(frozen=True)
class QualificationCase(JudgedCase[ValidationResult]):
    """A recorded run of a scene in an engine with a preset, judged with each defect planted.

    Its tolerances are part of its key, since noticed sizes depend on them. No defect is planted in a run that fails.
    """

    study: ClassVar[str] = "qualification"
    result_type: ClassVar[type[Any]] = ValidationResult
    defects: ClassVar[tuple[Defect, ...]] = (*MOTION_DEFECTS, MASS_DEFECT)

    plan: Plan

    def empty_result(self) -> ValidationResult:
        return empty_result(self.name, self.scene, self.loaded_engine, self.preset, self.plan)

    def run_fields(self) -> dict[str, Any]:
        """Plain values of the key: settings, revolutions, and tolerances asked for, on which noticing depends."""
        settings = self.loaded_engine.presets[str(self.preset)](self.scene, self.plan.steps(self.scene)).as_dict()
        return {"settings": settings, "revolutions": self.plan.revolutions, "tolerance": self.plan.tolerance}

    def perform(self) -> ValidationResult:
        scene, engine, plan = self.scene, self.loaded_engine, self.plan
        result, settings, start = prepare_run(self.name, scene, engine, str(self.preset), plan)
        if not result.completed:
            return result
        given = Recording.from_engine(engine, scene, settings, result.revolutions, start)
        judge = motion_judge(result, scene, plan.tolerance)
        healthy = judge(given)
        if healthy.passed is not True:
            return healthy
        motion = [examine_defect(defect, given, judge) for defect in self.defects]
        return healthy.with_qualification(Qualification(tuple(one for one in motion if one), self._examine_mass(given)))

    def _examine_mass(self, recording: Recording) -> tuple[DefectVerdict, ...]:
        """Return the verdict on wrong masses by the engine's forces; empty if these are not judged."""
        if not isinstance(self.loaded_engine, ForceReport):
            return ()
        plan = ForcePlan(self.plan.steps_per_revolution, self.plan.revolutions, refined=False)
        result, tracks, law = record_forces(self.name, self.scene, self.loaded_engine, str(self.preset), plan)
        if not result.completed or not result.limits:
            return ()
        peaks = force_peaks(self.scene)
        judge = force_judge(result, tracks, law, peaks, self.scene.period / result.steps_per_revolution)
        if judge(recording).passed is not True:
            return ()
        # A mass that no force depends on at constant speed shows by the drive's ripple at most.
        names = [name for name in result.names if name not in (result.unsupported or {})]
        seen = {body for body, quality in visible_properties(self.scene, names, peaks) if quality == MASS_DEFECT.name}
        unseen = {body.name for body in self.scene.mechanism().bodies} - seen
        found = examine_defect(MASS_DEFECT, recording, judge, unseen)
        return () if found is None else (found,)


def qualification_study(
    studies: Sequence[SceneStudy], scenes: Mapping[str, Scene], engines: Sequence[Engine[Any]], plan: Plan
) -> Study[list[SceneStudy]]:
    """Study that adds a qualification to each passed result of dynamic mode in a validation."""
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
                replace(r) if r.mode != "dynamic" else r.with_qualification(known.get((study.name, r.engine, r.preset)))
                for r in study.results
            ),
        )
        for study in studies
    ]
