"""`conrod forces`: forces that engines report at constant crank speed against exact forces."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, ClassVar

from conrod.comparison.convergence import claimed_order
from conrod.comparison.trajectory import Outcome
from conrod.engines import Engine
from conrod.engines.capabilities import ExpectedForces, ForceLaw, ForceReport, MissingCapability, capability
from conrod.engines.tracks import ForceTracks, unreported_forces
from conrod.execution.prediction import reference_misfit
from conrod.execution.result import JudgedCase, Plan, run_refinement_path
from conrod.scenes import Scene
from conrod.studies.forces.force_errors import (
    ExpectedForceErrors,
    ForceComparison,
    derive_tolerance,
    force_peaks,
    group_quantities,
)
from conrod.studies.forces.mass_likeness import mass_likenesses
from conrod.studies.forces.results import GROUPS, ForceErrors, ForcePoint, ForceResult

NO_CONTACT_REASON = "no joint of the machine acts by contact"


@dataclass(frozen=True)
class ForcePlan(Plan):
    """Plan of the runs of a study of forces; tolerances are by group of quantities.

    Attributes:
        quantities: requested groups of quantities, of `GROUPS`.
        refined: whether errors are observed along a refinement path.
    """

    quantities: tuple[str, ...] = GROUPS
    refined: bool = True


def validate_forces(name: str, scene: Scene, engine: Engine[Any], preset: str, plan: ForcePlan) -> ForceResult:
    """Measure the forces of an engine by a run and its refinement path, and judge their errors."""
    result, tracks, law = record_forces(name, scene, engine, preset, plan)
    steps = result.steps_per_revolution
    if not result.completed:
        return result.with_verdict()
    peaks = force_peaks(scene)
    measured = ForceComparison(scene, tracks, peaks, scene.period / steps)
    errors = measured.errors(result.names)
    likeness = mass_likenesses(scene, measured, result.names, law)
    result = replace(result, errors=errors, likeness=likeness, misfit=reference_misfit(scene))

    def run_with_steps(n: int, turns: float, start: float) -> ForcePoint:
        tracks = _run_forces(engine, scene, engine.presets[preset](scene, n), turns, start)
        if tracks.outcome is not Outcome.COMPLETED or not len(tracks.instants.times):
            return ForcePoint(n, tracks.outcome.slug, {})
        found = ForceComparison(scene, tracks, peaks, scene.period / n).errors(result.names)
        return ForcePoint(n, tracks.outcome.slug, refinement_errors(found))

    if plan.refined:
        finest = ForcePoint(steps, result.outcome, refinement_errors(errors))
        points = run_refinement_path(scene, steps, plan.revolutions, finest, run_with_steps)
        result = replace(result, refinement=points, order=_observed_orders(result, points))
    return result.with_verdict()


def record_forces(
    name: str, scene: Scene, engine: Engine[Any], preset: str, plan: ForcePlan
) -> tuple[ForceResult, ForceTracks, ExpectedForceErrors | None]:
    """Run a scene; return its result with no errors computed yet, reported forces, and their expected errors."""
    result, mechanism = empty_result(name, scene, engine, preset, plan), scene.kinematics.mechanism
    steps = result.steps_per_revolution
    settings = engine.presets[preset](scene, steps)
    refusal = engine.refusal(scene, settings) if result.groups else NO_CONTACT_REASON
    if refusal:
        return (
            replace(result, outcome=Outcome.UNSUPPORTED.slug, reason=refusal),
            unreported_forces(mechanism, refusal),
            None,
        )
    start, revolutions = plan.extent(scene)
    expected = _expected_forces(engine, scene, settings, revolutions, start) if result.limits else None
    law = None
    if expected is not None and expected.tracks is None:
        result = replace(result, tolerance={}, reason_of_tolerance=expected.law)
    elif expected is not None:
        law = ExpectedForceErrors(scene, expected, force_peaks(scene), scene.period / steps)
        tolerance, reason = derive_tolerance(mechanism, engine.presets[preset], steps, result.groups, law)
        result = replace(result, tolerance=tolerance, reason_of_tolerance=reason)
    tracks = _run_forces(engine, scene, settings, revolutions, start)
    ended = _outcome_fields(result, tracks)
    return replace(result, settings=settings.as_dict(), revolutions=revolutions, **ended), tracks, law


def empty_result(name: str, scene: Scene, engine: Engine[Any], preset: str, plan: ForcePlan) -> ForceResult:
    """Return a result with its known facts and tolerance, and without measurements."""
    mechanism, steps = scene.kinematics.mechanism, plan.steps(scene)
    groups = {group: names for group in plan.quantities if (names := group_quantities(mechanism, group))}
    tolerance, reason = derive_tolerance(mechanism, engine.presets[preset], steps, groups)
    return ForceResult(
        scene=name, parameters=scene.parameters, engine=engine.name, engine_version=engine.version, preset=preset,
        steps_per_revolution=steps, revolutions=plan.revolutions, groups=groups, tolerance=tolerance,
        reason_of_tolerance=reason,
    )  # fmt: skip


def _run_forces(engine: Engine[Any], scene: Scene, settings: Any, revolutions: float, start: float) -> ForceTracks:
    """Run a scene and return its reported forces; each is unreported if the engine reports none."""
    reports = capability(engine, ForceReport)
    if isinstance(reports, MissingCapability):
        return unreported_forces(scene.kinematics.mechanism, reports.reason)
    return reports.forces(scene, settings, revolutions, start)


def refinement_errors(errors: Mapping[str, ForceErrors]) -> dict[str, float]:
    """Errors that a refinement path observes: the max, or with a cam the rms between arc joints."""
    return {name: one.max if one.between is None else one.between for name, one in errors.items()}


def _expected_forces(
    engine: Engine[Any], scene: Scene, settings: Any, revolutions: float, start: float
) -> ExpectedForces | None:
    """Return the forces that the engine's law expects of its scheme; None if it has no such law."""
    law = capability(engine, ForceLaw)
    return None if isinstance(law, MissingCapability) else law.expected_forces(scene, settings, revolutions, start)


def _outcome_fields(result: ForceResult, tracks: ForceTracks) -> dict[str, Any]:
    """Return a result's fields on the outcome of the run and on unreported quantities."""
    reasons = {name: tracks.unsupported.get(name.rpartition(".")[0] or name) for name in result.names}
    unsupported = {name: reason for name, reason in reasons.items() if reason is not None}
    if tracks.outcome is Outcome.COMPLETED and len(unsupported) < len(reasons):
        return {"unsupported": unsupported}
    outcome = tracks.outcome if tracks.outcome is not Outcome.COMPLETED else Outcome.UNSUPPORTED
    reason = next(iter(unsupported.values()), outcome.meaning)
    return {"unsupported": unsupported, "outcome": outcome.slug, "reason": reason}


def _observed_orders(result: ForceResult, points: tuple[ForcePoint, ...]) -> dict[str, float | None]:
    """Return the observed order of each group, by its largest error, and of each quantity."""
    orders: dict[str, float | None] = {}
    groups = {**result.groups, **{name: (name,) for name in result.names}}
    for key, names in groups.items():
        found = [(p.steps_per_revolution, [p.errors[n] for n in names if n in p.errors]) for p in points]
        orders[key] = claimed_order((n, max(sizes, default=None)) for n, sizes in found)
    return orders


@dataclass(frozen=True)
class ForceCase(JudgedCase[ForceResult]):
    """Forces that an engine reports in a scene with a preset, along its refinement path."""

    study: ClassVar[str] = "forces"
    result_type: ClassVar[type[Any]] = ForceResult

    plan: ForcePlan

    def empty_result(self) -> ForceResult:
        return empty_result(self.name, self.scene, self.loaded_engine, str(self.preset), self.plan)

    def perform(self) -> ForceResult:
        return validate_forces(self.name, self.scene, self.loaded_engine, str(self.preset), self.plan)

    def run_fields(self) -> dict[str, Any]:
        """Plain values of the key: settings and revolutions of all runs, and the groups of quantities."""
        preset, plan = self.loaded_engine.presets[str(self.preset)], self.plan
        return plan.run_fields(self.scene, preset, plan.refined) | {"quantities": plan.quantities}
