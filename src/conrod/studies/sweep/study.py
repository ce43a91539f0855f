"""Study of speed against accuracy on one scene: its runs, their costs, and what they show together."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from statistics import median
from typing import Any

from conrod.engines import Engine
from conrod.engines.capabilities import (
    MissingCapability,
    PastableSettings,
    SettingsGrid,
    TimedStepping,
    capability,
    sweep_rules,
)
from conrod.engines.engine import CUSTOM
from conrod.engines.variants import PRESETS_GRID, Grid, SettingsRule, step_counts
from conrod.runs.convergence import ObservedOrder, observed_order
from conrod.runs.trajectory import Settings
from conrod.scenes import Scene
from conrod.studies.frame.case import QUANTITIES, Results, Study
from conrod.studies.frame.reference_guard import ReferenceGuard
from conrod.studies.frame.run import RunCase
from conrod.studies.frame.timing import Timing, machine_fingerprint
from conrod.studies.sweep.findings import COMPLETED, SweepStudy, SweptPoint, SweptRule, shared_lines

NEEDED: tuple[type[Any], ...] = (SettingsGrid, TimedStepping)

Timings = Mapping[str, Timing]
# Timings by key, of those cases that can be timed.
Clock = Callable[[list[RunCase]], Timings]


# -- the plan ---------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class RulePlan:
    """A rule of an engine's grid on one scene.

    Attributes:
        cases: at increasing numbers of steps, from which orders are.
    """

    engine: Engine[Any]
    rule: SettingsRule
    cases: tuple[RunCase, ...]


@dataclass(frozen=True)
class SweepPlan:
    """All runs that a sweep of one scene needs.

    Attributes:
        unsupported: engine -> what a sweep has that it lacks.
    """

    name: str
    scene: Scene
    grid: Grid
    rules: tuple[RulePlan, ...]
    unsupported: Mapping[str, str] = field(default_factory=dict)

    @property
    def cases(self) -> tuple[RunCase, ...]:
        """All cases, each once."""
        return tuple({case.key: case for rule in self.rules for case in rule.cases}.values())


def plan_sweep(name: str, scene: Scene, engines: Sequence[Engine[Any]], grid: Grid) -> SweepPlan:
    """The plan of a sweep of a scene."""
    steps = step_counts(grid, contact=bool(scene.kinematics.mechanism.cam_contacts))
    rules = [
        RulePlan(engine, rule, tuple(RunCase(name, scene, rule.settings(scene, n)) for n in steps))
        for engine in engines
        for rule in sweep_rules(engine, scene, grid)
    ]
    needed = (TimedStepping,) if grid == PRESETS_GRID else NEEDED
    lacking = {
        e.name: [c.reason for kind in needed if isinstance(c := capability(e, kind), MissingCapability)]
        for e in engines
    }
    unsupported = {name: ", ".join(reasons) for name, reasons in lacking.items() if reasons}
    return SweepPlan(name, scene, grid, tuple(rules), unsupported)


# -- the study ---------------------------------------------------------------------------------------------------------


def sweep_scene(plan: SweepPlan, time: Clock) -> Study[SweepStudy]:
    """The study of a plan.

    Args:
        time: takes costs, after all runs: what runs beside a timing is in it.
    """
    runs, guard = (yield plan.cases), ReferenceGuard()
    guard.check(plan.cases, runs)
    # Those of few steps first. What a step of a failed run costs is of no use.
    timed = [case for case in plan.cases if runs[case.key].outcome == COMPLETED]
    timings = time(sorted(timed, key=lambda case: case.settings.steps_per_revolution))
    engines = {rule.engine.name: rule.engine.version for rule in plan.rules}
    references: dict[str, list[float]] = {engine: [] for engine in engines}
    for rule, case in ((one, case) for one in plan.rules for case in one.cases if case.key in timings):
        references[rule.engine.name].append(timings[case.key].reference_seconds)
    medians = {engine: median(seconds) for engine, seconds in references.items() if seconds}
    return SweepStudy(
        name=plan.name,
        title=plan.scene.title,
        parameters=dict(plan.scene.parameters),
        one_pass=plan.scene.kinematics.mechanism.driver.span is not None,
        grid=plan.grid,
        engines=engines,
        unsupported=dict(plan.unsupported),
        machine=machine_fingerprint(),
        rules=tuple(
            SweptRule(
                engine=rule.engine.name,
                name=rule.rule.name,
                orders=orders_along(rule.cases, runs),
                lines=lines_of(rule),
            )
            for rule in plan.rules
        ),
        points=tuple(_points(plan, runs, timings, medians)),
        lengths=dict(plan.scene.lengths),
        distrust=guard.distrust,
    )


# -- rules and points --------------------------------------------------------------------------------------------------


def orders_along(cases: Sequence[RunCase], measurements: Results) -> dict[str, ObservedOrder]:
    """Order or plateau of each quantity along a refinement; runs that did not complete are left out.

    Raises:
        KeyError: a case has not been measured.
    """
    runs = {case.settings.steps_per_revolution: measurements[case.key] for case in cases}
    steps = sorted(n for n, run in runs.items() if run.errors is not None)
    return {q: observed_order(steps, [runs[n].largest(q) or 0.0 for n in steps]) for q in QUANTITIES}


def lines_of(rule: RulePlan) -> dict[str, str]:
    """Lines of a rule to paste, at any of its numbers of steps."""
    settings = [(case.scene, case.settings) for case in rule.cases]
    return shared_lines({own.steps_per_revolution: paste_of(rule.engine, scene, own) for scene, own in settings})


def paste_of(engine: Engine[Any], scene: Scene, settings: Settings) -> str:
    """Settings as lines for a model or a program; the reason where the engine gives none."""
    can = capability(engine, PastableSettings)
    return f"# {can.reason}" if isinstance(can, MissingCapability) else can.paste(scene, settings)


def _initial(engine: str, engines: Sequence[str]) -> str:
    """The shortest beginning of an engine's name that no other one has, as capitals."""
    others = [other for other in engines if other != engine]
    ends = range(1, len(engine) + 1)
    return next((engine[:k] for k in ends if not any(o.startswith(engine[:k]) for o in others)), engine).upper()


def _points(
    plan: SweepPlan,
    measurements: Results,
    timings: Timings,
    references: Mapping[str, float],
) -> Iterator[SweptPoint]:
    """All points; a cost is that at the usual speed of the reference loop, whatever else the machine was doing."""
    counts = Counter[str]()
    for rule, case in ((one, case) for one in plan.rules for case in one.cases):
        engine, found, timing = rule.engine.name, measurements[case.key], timings.get(case.key)
        counts[engine] += 1
        yield SweptPoint(
            label=f"{_initial(engine, [one.engine.name for one in plan.rules])}{counts[engine]}",
            key=case.key,
            engine=engine,
            rule=rule.rule.name,
            preset=None if case.settings.preset == CUSTOM else case.settings.preset,
            steps_per_revolution=case.settings.steps_per_revolution,
            outcome=found.outcome,
            reason=found.reason,
            errors=None if found.errors is None else {q: found.largest(q) or 0.0 for q in QUANTITIES},
            cost=None if timing is None else timing.ratio * references[engine],
            ratio=None if timing is None else timing.ratio,
        )
