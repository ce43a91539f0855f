"""Forces in a scene by an engine's account, at constant crank speed, against the exact ones."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, ClassVar

from conrod.engines import Engine
from conrod.engines.capabilities import ExpectedForces, ForceLaw, ForceReport, MissingCapability, capability
from conrod.engines.tracks import ForceTracks, unreported_forces
from conrod.runs.convergence import claimed_order
from conrod.runs.trajectory import Outcome
from conrod.scenes import Scene
from conrod.studies.forces.measuring import LawOfForces, Measured, likenesses, peaks_of, quantities_of, tolerance_of
from conrod.studies.forces.results import GROUPS, ForceErrors, ForcePoint, ForceResult
from conrod.studies.frame.prediction import reference_misfit
from conrod.studies.frame.result import EngineCase, run_refinement_path
from conrod.studies.validation.plan import Plan

NO_CONTACT = "no joint of the machine acts by contact"


@dataclass(frozen=True)
class ForcePlan(Plan):
    """Plan of the runs; its tolerances are by group.

    Attributes:
        quantities: groups of quantities asked for.
        refined: whether errors are followed over a refinement path.
    """

    quantities: tuple[str, ...] = GROUPS
    refined: bool = True


def validate_forces(name: str, scene: Scene, engine: Engine[Any], preset: str, plan: ForcePlan) -> ForceResult:
    """Measure the engine: one run, its refinement path, and the verdict."""
    result, tracks, law = recorded_forces(name, scene, engine, preset, plan)
    steps = result.steps_per_revolution
    if not result.completed:
        return result.with_verdict()
    peaks = peaks_of(scene)
    measured = Measured(scene, tracks, peaks, scene.period / steps)
    errors = measured.errors(result.names)
    likeness = likenesses(scene, measured, result.names, law)
    result = replace(result, errors=errors, likeness=likeness, misfit=reference_misfit(scene))

    def point(n: int, turns: float, start: float) -> ForcePoint:
        tracks = _forces(engine, scene, engine.presets[preset](scene, n), turns, start)
        if tracks.outcome is not Outcome.COMPLETED or not len(tracks.instants.times):
            return ForcePoint(n, tracks.outcome.slug, {})
        found = Measured(scene, tracks, peaks, scene.period / n).errors(result.names)
        return ForcePoint(n, tracks.outcome.slug, judged_sizes(found))

    if plan.refined:
        finest = ForcePoint(steps, result.outcome, judged_sizes(errors))
        points = run_refinement_path(scene, steps, plan.revolutions, finest, point)
        result = replace(result, refinement=points, order=_orders(result, points))
    return result.with_verdict()


def recorded_forces(
    name: str, scene: Scene, engine: Engine[Any], preset: str, plan: ForcePlan
) -> tuple[ForceResult, ForceTracks, LawOfForces | None]:
    """A result of which nothing is measured yet, the forces of a run, and the law of their errors if there is one."""
    result, mechanism = started(name, scene, engine, preset, plan), scene.kinematics.mechanism
    steps = result.steps_per_revolution
    settings = engine.presets[preset](scene, steps)
    refusal = engine.refusal(scene, settings) if result.groups else NO_CONTACT
    if refusal:
        return (
            replace(result, outcome=Outcome.UNSUPPORTED.slug, reason=refusal),
            unreported_forces(mechanism, refusal),
            None,
        )
    start, revolutions = plan.extent(scene)
    expected = _expected(engine, scene, settings, revolutions, start) if result.limits else None
    law = None
    if expected is not None and expected.tracks is None:
        result = replace(result, tolerance={}, reason_of_tolerance=expected.law)
    elif expected is not None:
        law = LawOfForces(scene, expected, peaks_of(scene), scene.period / steps)
        tolerance, reason = tolerance_of(mechanism, engine.presets[preset], steps, result.groups, law)
        result = replace(result, tolerance=tolerance, reason_of_tolerance=reason)
    tracks = _forces(engine, scene, settings, revolutions, start)
    ended = _outcome_fields(result, tracks)
    return replace(result, settings=settings.as_dict(), revolutions=revolutions, **ended), tracks, law


def started(name: str, scene: Scene, engine: Engine[Any], preset: str, plan: ForcePlan) -> ForceResult:
    """A result without what is measured."""
    mechanism, steps = scene.kinematics.mechanism, plan.steps(scene)
    groups = {group: names for group in plan.quantities if (names := quantities_of(mechanism, group))}
    tolerance, reason = tolerance_of(mechanism, engine.presets[preset], steps, groups)
    return ForceResult(
        scene=name, parameters=scene.parameters, engine=engine.name, engine_version=engine.version, preset=preset,
        steps_per_revolution=steps, revolutions=plan.revolutions, groups=groups, tolerance=tolerance,
        reason_of_tolerance=reason,
    )  # fmt: skip


def _forces(engine: Engine[Any], scene: Scene, settings: Any, revolutions: float, start: float) -> ForceTracks:
    """The forces of a run; an engine that reports none says so."""
    reports = capability(engine, ForceReport)
    if isinstance(reports, MissingCapability):
        return unreported_forces(scene.kinematics.mechanism, reports.reason)
    return reports.forces(scene, settings, revolutions, start)


def judged_sizes(errors: Mapping[str, ForceErrors]) -> dict[str, float]:
    """Errors that a refinement path follows: the max; with a cam the rms between arc joints, where all forces jump."""
    return {name: one.max if one.between is None else one.between for name, one in errors.items()}


def _expected(
    engine: Engine[Any], scene: Scene, settings: Any, revolutions: float, start: float
) -> ExpectedForces | None:
    """Forces that the engine's scheme takes by its law; None where it has no law of them."""
    law = capability(engine, ForceLaw)
    return None if isinstance(law, MissingCapability) else law.expected_forces(scene, settings, revolutions, start)


def _outcome_fields(result: ForceResult, tracks: ForceTracks) -> dict[str, Any]:
    """Outcome, and by quantity asked for why it is not reported."""
    reasons = {name: tracks.unsupported.get(name.rpartition(".")[0] or name) for name in result.names}
    unsupported = {name: reason for name, reason in reasons.items() if reason is not None}
    if tracks.outcome is Outcome.COMPLETED and len(unsupported) < len(reasons):
        return {"unsupported": unsupported}
    outcome = tracks.outcome if tracks.outcome is not Outcome.COMPLETED else Outcome.UNSUPPORTED
    reason = next(iter(unsupported.values()), outcome.meaning)
    return {"unsupported": unsupported, "outcome": outcome.slug, "reason": reason}


def _orders(result: ForceResult, points: tuple[ForcePoint, ...]) -> dict[str, float | None]:
    """Observed order of each group, by its largest error, and of each quantity."""
    orders: dict[str, float | None] = {}
    every = {**result.groups, **{name: (name,) for name in result.names}}
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
    version: ClassVar[int] = 2  # since errors of the engine's law are allowed, and MuJoCo's solver goes on

    plan: ForcePlan

    def empty_result(self) -> ForceResult:
        return started(self.name, self.scene, self.loaded_engine, str(self.preset), self.plan)

    def run(self) -> ForceResult:
        return validate_forces(self.name, self.scene, self.loaded_engine, str(self.preset), self.plan)

    def key_fields(self) -> dict[str, Any]:
        preset, plan = self.loaded_engine.presets[str(self.preset)], self.plan
        return plan.key_fields(self.scene, preset, plan.refined) | {"quantities": plan.quantities}
