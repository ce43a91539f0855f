"""Forces in a scene by an engine's account, at constant crank speed, against the exact ones.

One result that a validation of forces asks for, to be had in any process.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from conrod.engines import Engine, engine_named
from conrod.engines.capabilities import Lacking, ReportsForces, capability
from conrod.engines.engine import run_of
from conrod.engines.forces import ForceTracks, nothing_told
from conrod.runs.convergence import observed_order
from conrod.runs.trajectory import Outcome
from conrod.scenes import Scene
from conrod.studies.forces.exact import GROUPS, groups_of, peaks_of, quantities_of, tolerance_of
from conrod.studies.forces.measuring import Measured, likenesses, stamps_of
from conrod.studies.forces.results import ForceErrors, ForcePoint, ForceResult
from conrod.studies.validation.plan import Plan, refinement_path

NO_CONTACT = "no joint of the machine acts by contact"


@dataclass(frozen=True)
class ForcePlan:
    """What to run.

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
    result = replace(result, settings=settings.as_dict(), revolutions=revolutions, **_told(result, tracks))
    if result.outcome != Outcome.COMPLETED.slug:
        failed = result.outcome != Outcome.UNSUPPORTED.slug and bool(result.tolerance)
        return replace(result, passed=False if failed else None)
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
    # Whoever gives tolerances is judged by these alone.
    mistaken = not plan.run.tolerance and bool(result.mistaken())
    return replace(result, passed=not (result.exceeded() or mistaken) if result.tolerance else None)


def started(name: str, scene: Scene, engine: Engine[Any], preset: str, plan: ForcePlan) -> ForceResult:
    """A result without what is measured."""
    mechanism, steps = scene.kinematics.mechanism, plan.run.steps(scene)
    groups = {group: quantities_of(mechanism, group) for group in groups_of(mechanism, plan.quantities)}
    tolerance, reason = tolerance_of(mechanism, engine.presets[preset], steps, groups, plan.run.tolerance or {})
    return ForceResult(
        scene=name, parameters=scene.parameters, engine=engine.name, engine_version=engine.version, preset=preset,
        settings=None, steps_per_revolution=steps, revolutions=plan.run.revolutions, groups=groups,
        outcome=Outcome.COMPLETED.slug, reason="", tolerance=tolerance, reason_of_tolerance=reason,
    )  # fmt: skip


def _forces(engine: Engine[Any], scene: Scene, settings: Any, revolutions: float, start: float) -> ForceTracks:
    """The forces of a run; an engine that reports none says so."""
    reports = capability(engine, ReportsForces)
    if isinstance(reports, Lacking):
        return nothing_told(scene.kinematics.mechanism, reports.reason)
    return reports.forces(scene, settings, revolutions, start)


def judged_sizes(errors: Mapping[str, ForceErrors]) -> dict[str, float]:
    """What a refinement path follows: the max, with a cam the rms between its arc joints, for all forces jump there."""
    return {name: one.max if one.between is None else one.between for name, one in errors.items()}


def _told(result: ForceResult, tracks: ForceTracks) -> dict[str, Any]:
    """Outcome, and by quantity asked for why it is not told."""
    untold = {}
    for names in result.groups.values():
        for name in names:
            joint = name.rpartition(".")[0] or name
            if joint in tracks.unsupported:
                untold[name] = tracks.unsupported[joint]
    asked = [name for names in result.groups.values() for name in names]
    if tracks.outcome is Outcome.COMPLETED and len(untold) < len(asked):
        return {"unsupported": untold}
    outcome = tracks.outcome if tracks.outcome is not Outcome.COMPLETED else Outcome.UNSUPPORTED
    reason = next(iter(untold.values()), outcome.meaning)
    return {"unsupported": untold, "outcome": outcome.slug, "reason": reason}


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
        told = tracks.outcome is Outcome.COMPLETED and len(tracks.instants.times) > 0
        stamps = stamps_of(scene, tracks, n, start) if told else None
        errors = judged_sizes(Measured(scene, tracks, peaks, stamps).errors(names)) if stamps else {}
        points.append(ForcePoint(n, tracks.outcome.slug, errors))
    return tuple(points)


def _orders(result: ForceResult, points: tuple[ForcePoint, ...]) -> dict[str, float | None]:
    """Observed order of each group, by its largest error, and of each quantity."""
    orders: dict[str, float | None] = {}
    every = {**result.groups, **{name: (name,) for names in result.groups.values() for name in names}}
    for key, names in every.items():
        found = [(p.steps_per_revolution, [p.errors[n] for n in names if n in p.errors]) for p in points]
        stable = [(n, max(sizes)) for n, sizes in found if sizes]
        orders[key] = observed_order([n for n, _ in stable], [e for _, e in stable]).claimed if stable else None
    return orders


@dataclass(frozen=True)
class ForceJob:
    """A scene in an engine with a preset.

    Attributes:
        name: of the scene, for people.
    """

    name: str
    scene: Scene = field(repr=False)
    engine: str
    preset: str
    plan: ForcePlan

    @property
    def label(self) -> str:
        """What is under way, for people."""
        return f"{self.name} {self.engine} {self.preset}"

    @property
    def steps(self) -> int:
        """Steps per revolution, which say about how long it takes."""
        return self.plan.run.steps(self.scene)

    def run(self) -> ForceResult:
        """The result."""
        return validate_forces(self.name, self.scene, engine_named(self.engine), self.preset, self.plan)

    def ended(self, outcome: Outcome, reason: str) -> ForceResult:
        """The result where the process that ran it did not live to give one."""
        result = started(self.name, self.scene, engine_named(self.engine), self.preset, self.plan)
        return replace(result, outcome=outcome.slug, reason=reason, passed=False if result.tolerance else None)


def force_jobs(
    scenes: Mapping[str, Scene], engines: Sequence[Engine[Any]], presets: Mapping[str, tuple[str, ...]], plan: ForcePlan
) -> list[ForceJob]:
    """All jobs: scene by scene, engine by engine, each preset."""
    return [
        ForceJob(name, scene, engine.name, preset, plan)
        for name, scene in scenes.items()
        for engine in engines
        for preset in presets[engine.name]
    ]
