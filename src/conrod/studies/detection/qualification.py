"""Qualification in place: known defects in the very run that is judged, and which of them its verdict notices."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar, Self

from conrod.engines import Engine
from conrod.engines.capabilities import ReportsForces
from conrod.runs.trajectory import Outcome
from conrod.scenes import Scene
from conrod.studies.detection.defects import MASS, MOTION
from conrod.studies.detection.judging import examined, force_judge, motion_judge
from conrod.studies.detection.machine_defects import Recording
from conrod.studies.forces.measuring import peaks_of, seen_in
from conrod.studies.forces.study import ForcePlan, recorded_forces
from conrod.studies.frame.case import Study
from conrod.studies.frame.result import EngineCase, Result, results_of
from conrod.studies.validation.plan import Plan, begun
from conrod.studies.validation.results import Noticed, Qualified, SceneStudy


@dataclass(frozen=True, kw_only=True)
class Qualification(Result):
    """What the verdicts on one run notice; of a run that did not pass there is nothing to be said.

    Attributes:
        tightness: by judged quantity the error of the run, and what is allowed.
    """

    found: Qualified | None = None
    tightness: Mapping[str, tuple[float, float]] = field(default_factory=dict)

    @property
    def limits(self) -> Mapping[str, float]:
        return {}

    def largest(self, quantity: str, measure: str = "max") -> float | None:
        return None

    def judged(self, asked: Mapping[str, float] | None = None) -> Self:
        return self

    def _held_to(self, asked: Mapping[str, float]) -> Self:
        return self


@dataclass(frozen=True)
class QualificationCase(EngineCase[Qualification]):
    """A run of a scene in an engine with a preset, recorded whole, and judged with each defect planted in it."""

    study: ClassVar[str] = "qualification"
    kind: ClassVar[type[Any]] = Qualification
    quantities: ClassVar[tuple[str, ...]] = ()
    version: ClassVar[int] = 5  # since fewer kinds of defects are planted

    plan: Plan

    @property
    def effort(self) -> float:
        return self.plan.steps(self.scene)

    @property
    def tolerance(self) -> Mapping[str, float] | None:
        return None  # they are a part of the case: what is noticed depends on them

    def ended(self, outcome: Outcome, reason: str) -> Qualification:
        made_by = self.made_by
        return Qualification(
            scene=self.name, engine=self.engine, engine_version=made_by.version, preset=self.preset,
            outcome=outcome.slug, reason=reason,
        )  # fmt: skip

    def facts(self) -> dict[str, Any]:
        return {"scene": self.name}

    def determined_by(self) -> dict[str, Any]:
        settings = self.made_by.presets[str(self.preset)](self.scene, self.plan.steps(self.scene)).as_dict()
        return {"settings": settings, "revolutions": self.plan.revolutions, "tolerance": self.plan.tolerance}

    def run(self) -> Qualification:
        scene, engine, preset, plan = self.scene, self.made_by, str(self.preset), self.plan
        result, settings, start = begun(self.name, scene, engine, preset, plan)
        if not result.completed:
            return self.ended(Outcome.of(result.outcome), result.reason)
        given = Recording.of(engine, scene, settings, result.revolutions, start)
        judge = motion_judge(result, scene, plan.tolerance)
        healthy = judge(given)
        if healthy.passed is not True:
            return self.ended(Outcome.of(healthy.outcome), healthy.reason)
        motion = [examined(defect, given, judge) for defect in (*MOTION, MASS)]
        found = Qualified(tuple(one for one in motion if one), self._forces(given))
        tightness = {q: (healthy.judged_error(q) or 0.0, allowed) for q, allowed in healthy.limits.items()}
        return replace(self.ended(Outcome.COMPLETED, ""), found=found, tightness=tightness)

    def _forces(self, given: Recording) -> tuple[Noticed, ...]:
        """What the verdict on the forces notices of wrong masses; nothing where they are not judged."""
        if not isinstance(self.made_by, ReportsForces):
            return ()
        plan = ForcePlan(run=replace(self.plan, tolerance=None), refined=False)
        result, tracks = recorded_forces(self.name, self.scene, self.made_by, str(self.preset), plan)
        if not result.completed or not result.limits:
            return ()
        peaks = peaks_of(self.scene)
        judge = force_judge(result, tracks, peaks, self.scene.period / result.steps_per_revolution)
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
    found = yield from results_of(
        QualificationCase(name, scene, engine.name, preset, plan)
        for name, scene in scenes.items()
        for engine in engines
        for preset in engine.presets
        if (name, engine.name, preset) in judged
    )
    known = {(one.scene, one.engine, one.preset): one.found for some in found.values() for one in some}
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
