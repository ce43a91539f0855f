"""Forces in a scene by an engine's account, at constant crank speed, against the exact ones."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar

from conrod.engines import Engine
from conrod.engines.capabilities import Lacking, ReportsForces, capability
from conrod.engines.engine import run_of
from conrod.engines.forces import ForceTracks, no_forces
from conrod.runs.convergence import claimed_order
from conrod.runs.trajectory import Outcome
from conrod.scenes import Scene
from conrod.studies.forces.exact import GROUPS, groups_of, peaks_of, quantities_of, tolerance_of
from conrod.studies.forces.measuring import Measured, likenesses, stamps_of
from conrod.studies.forces.results import ForceErrors, ForcePoint, ForceResult, ForceStudy
from conrod.studies.forces.seen import seen_of
from conrod.studies.frame.case import EngineCase
from conrod.studies.frame.study import Study, results_of
from conrod.studies.validation.plan import Plan, refinement_path

AS_ASKED = "as asked for"
NO_CONTACT = "no joint of the machine acts by contact"


@dataclass(frozen=True)
class ForcePlan:
    """Plan of the runs.

    Attributes:
        run: steps, revolutions; its tolerances are by group.
        quantities: groups of quantities asked for.
        refined: whether errors are followed over a refinement path.
    """

    run: Plan = field(default_factory=Plan)
    quantities: tuple[str, ...] = GROUPS
    refined: bool = True


def validate_forces(name: str, scene: Scene, engine: Engine[Any], preset: str, plan: ForcePlan) -> ForceResult:
    """Measure the engine: one run, its refinement path, and the verdict."""
    result = started(name, scene, engine, preset, plan)
    if not result.groups:
        return replace(result, outcome=Outcome.UNSUPPORTED.slug, reason=NO_CONTACT)
    steps = result.steps_per_revolution
    settings = engine.presets[preset](scene, steps)
    refusal = engine.refusal(scene, settings)
    if refusal:
        return replace(result, outcome=Outcome.UNSUPPORTED.slug, reason=refusal)
    start, revolutions = run_of(scene, steps, plan.run.revolutions)
    tracks = _forces(engine, scene, settings, revolutions, start)
    result = replace(result, settings=settings.as_dict(), revolutions=revolutions, **_outcome_fields(result, tracks))
    if result.outcome != Outcome.COMPLETED.slug:
        return judged(result, plan.run.tolerance)
    peaks = peaks_of(scene)
    stamps = stamps_of(scene, tracks, steps, start)
    measured = Measured(scene, tracks, peaks, stamps)
    names = [name for some in result.groups.values() for name in some]
    errors = measured.errors(names)
    result = replace(
        result,
        stamps=stamps,
        errors=errors,
        curve=measured.torque_curve(),
        likeness=likenesses(scene, measured, names),
    )
    if plan.refined:
        finest = ForcePoint(steps, result.outcome, judged_sizes(errors))
        points = _refine(scene, engine, result, plan, finest, peaks)
        result = replace(result, refinement=points, order=_orders(result, points))
    return judged(result, plan.run.tolerance)


def judged(result: ForceResult, asked: Mapping[str, float] | None = None) -> ForceResult:
    """The result with the verdict by its tolerances.

    Args:
        asked: tolerances by group that take the place of its own. Whoever gives them is judged by these alone, not by
            the wrong masses that the errors look like.
    """
    if result.outcome == Outcome.UNSUPPORTED.slug:
        return result
    if asked:
        allowed = {group: value for group, value in asked.items() if group in result.groups}
        result = replace(result, tolerance=allowed, reason_of_tolerance=AS_ASKED)
    passed = result.outcome == Outcome.COMPLETED.slug and not result.exceeded() and bool(asked or not result.mistaken())
    return replace(result, passed=passed if result.tolerance else None)


def started(name: str, scene: Scene, engine: Engine[Any], preset: str, plan: ForcePlan) -> ForceResult:
    """A result without what is measured."""
    mechanism, steps = scene.kinematics.mechanism, plan.run.steps(scene)
    groups = {group: quantities_of(mechanism, group) for group in groups_of(mechanism, plan.quantities)}
    tolerance, reason = tolerance_of(mechanism, engine.presets[preset], steps, groups)
    return ForceResult(
        scene=name, parameters=scene.parameters, engine=engine.name, engine_version=engine.version, preset=preset,
        settings=None, steps_per_revolution=steps, revolutions=plan.run.revolutions, groups=groups,
        outcome=Outcome.COMPLETED.slug, reason="", tolerance=tolerance, reason_of_tolerance=reason,
    )  # fmt: skip


def _forces(engine: Engine[Any], scene: Scene, settings: Any, revolutions: float, start: float) -> ForceTracks:
    """The forces of a run; an engine that reports none says so."""
    reports = capability(engine, ReportsForces)
    if isinstance(reports, Lacking):
        return no_forces(scene.kinematics.mechanism, reports.reason)
    return reports.forces(scene, settings, revolutions, start)


def judged_sizes(errors: Mapping[str, ForceErrors]) -> dict[str, float]:
    """Errors that a refinement path follows: the max; with a cam the rms between arc joints, where all forces jump."""
    return {name: one.max if one.between is None else one.between for name, one in errors.items()}


def _outcome_fields(result: ForceResult, tracks: ForceTracks) -> dict[str, Any]:
    """Outcome, and by quantity asked for why it is not reported."""
    unreported = {}
    for names in result.groups.values():
        for name in names:
            joint = name.rpartition(".")[0] or name
            if joint in tracks.unsupported:
                unreported[name] = tracks.unsupported[joint]
    asked = [name for names in result.groups.values() for name in names]
    if tracks.outcome is Outcome.COMPLETED and len(unreported) < len(asked):
        return {"unsupported": unreported}
    outcome = tracks.outcome if tracks.outcome is not Outcome.COMPLETED else Outcome.UNSUPPORTED
    reason = next(iter(unreported.values()), outcome.meaning)
    return {"unsupported": unreported, "outcome": outcome.slug, "reason": reason}


def _refine(
    scene: Scene,
    engine: Engine[Any],
    result: ForceResult,
    plan: ForcePlan,
    finest: ForcePoint,
    peaks: Mapping[str, tuple[float, bool]],
) -> tuple[ForcePoint, ...]:
    """The refinement path; `finest` is the run that is judged."""
    points, path = [], refinement_path(scene, finest.steps_per_revolution)
    # Of one pass all take the part that the longest steps have room for.
    start, revolutions = run_of(scene, min(path), plan.run.revolutions)
    whole = run_of(scene, finest.steps_per_revolution, plan.run.revolutions)
    names = [name for some in result.groups.values() for name in some]
    for n in path:
        if n == finest.steps_per_revolution and (start, revolutions) == whole:
            points.append(finest)
            continue
        tracks = _forces(engine, scene, engine.presets[result.preset](scene, n), revolutions, start)
        complete = tracks.outcome is Outcome.COMPLETED and len(tracks.instants.times) > 0
        stamps = stamps_of(scene, tracks, n, start) if complete else None
        errors = judged_sizes(Measured(scene, tracks, peaks, stamps).errors(names)) if stamps else {}
        points.append(ForcePoint(n, tracks.outcome.slug, errors))
    return tuple(points)


def _orders(result: ForceResult, points: tuple[ForcePoint, ...]) -> dict[str, float | None]:
    """Observed order of each group, by its largest error, and of each quantity."""
    orders: dict[str, float | None] = {}
    every = {**result.groups, **{name: (name,) for names in result.groups.values() for name in names}}
    for key, names in every.items():
        found = [(p.steps_per_revolution, [p.errors[n] for n in names if n in p.errors]) for p in points]
        orders[key] = claimed_order((n, max(sizes, default=None)) for n, sizes in found)
    return orders


@dataclass(frozen=True)
class ForceCase(EngineCase[ForceResult]):
    """Forces in a scene by an engine's account with a preset, along its refinement path."""

    study: ClassVar[str] = "forces"
    kind: ClassVar[type[Any]] = ForceResult
    quantities: ClassVar[tuple[str, ...]] = GROUPS
    measures: ClassVar[tuple[str, ...]] = ("max", "rms", "between")

    plan: ForcePlan

    @property
    def effort(self) -> float:
        return self.plan.run.steps(self.scene)

    def run(self) -> ForceResult:
        assert self.preset is not None
        by_rule = replace(self.plan, run=replace(self.plan.run, tolerance=None))
        return validate_forces(self.name, self.scene, self.made_by, self.preset, by_rule)

    def ended(self, outcome: Outcome, reason: str) -> ForceResult:
        assert self.preset is not None
        result = started(self.name, self.scene, self.made_by, self.preset, self.plan)
        return judged(replace(result, outcome=outcome.slug, reason=reason), self.plan.run.tolerance)

    def judged(self, found: ForceResult) -> ForceResult:
        return judged(found, self.plan.run.tolerance) if self.plan.run.tolerance else found

    def determined_by(self) -> dict[str, Any]:
        steps = self.plan.run.steps(self.scene)
        path = refinement_path(self.scene, steps) if self.plan.refined else ()
        settings = [self.made_by.presets[str(self.preset)](self.scene, n).as_dict() for n in (steps, *path)]
        return {
            "settings": settings[0],
            "refined": settings[1:],
            "revolutions": self.plan.run.revolutions,
            "start_angle": 0.0,
            "quantities": self.plan.quantities,
        }


def force_study(
    scenes: Mapping[str, Scene], engines: Sequence[Engine[Any]], presets: Mapping[str, tuple[str, ...]], plan: ForcePlan
) -> Study[list[ForceStudy]]:
    """The study of some scenes: one round of cases, scene by scene, engine by engine, each preset.

    Args:
        presets: to run, by engine name.
    """
    found = yield from results_of(
        ForceCase(name, scene, engine.name, preset, plan)
        for name, scene in scenes.items()
        for engine in engines
        for preset in presets[engine.name]
    )
    return [ForceStudy(name, scene, found[name], seen_of(scene, plan.quantities)) for name, scene in scenes.items()]
