"""Study of speed against accuracy on one scene: its runs, their costs, and the findings."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from statistics import median
from typing import Any

from conrod.comparison.convergence import ObservedOrder, observed_order
from conrod.comparison.trajectory import Settings
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
from conrod.exact.motion import QUANTITIES
from conrod.execution.case import Results, Study
from conrod.execution.reference_guard import ReferenceGuard
from conrod.execution.run import RunCase
from conrod.execution.timing import Timing, machine_fingerprint
from conrod.scenes import Scene
from conrod.studies.sweep.findings import COMPLETED, SweepStudy, SweptPoint, SweptRule, paste_template

SWEEP_CAPABILITIES: tuple[type[Any], ...] = (SettingsGrid, TimedStepping)

Timings = Mapping[str, Timing]
# Times cases, and returns the timings by key of those that can be timed.
Clock = Callable[[list[RunCase]], Timings]


# -- the plan ---------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class RulePlan:
    """A settings rule of an engine's grid, with its runs on one scene.

    Attributes:
        cases: runs by increasing steps; orders are observed along them.
    """

    engine: Engine[Any]
    rule: SettingsRule
    cases: tuple[RunCase, ...]


@dataclass(frozen=True)
class SweepPlan:
    """All runs that a sweep of one scene needs.

    Attributes:
        unsupported: capabilities that an engine lacks for a sweep, in words, by engine name.
    """

    name: str
    scene: Scene
    grid: Grid
    rules: tuple[RulePlan, ...]
    unsupported: Mapping[str, str] = field(default_factory=dict)

    @property
    def cases(self) -> tuple[RunCase, ...]:
        """All runs, each once."""
        return tuple({case.key: case for rule in self.rules for case in rule.cases}.values())


def plan_sweep(name: str, scene: Scene, engines: Sequence[Engine[Any]], grid: Grid) -> SweepPlan:
    """Return the plan of a sweep of a scene in some engines."""
    steps = step_counts(grid, contact=bool(scene.kinematics.mechanism.cam_contacts))
    rules = [
        RulePlan(engine, rule, tuple(RunCase(name, scene, rule.settings(scene, n)) for n in steps))
        for engine in engines
        for rule in sweep_rules(engine, scene, grid)
    ]
    needed = (TimedStepping,) if grid == PRESETS_GRID else SWEEP_CAPABILITIES
    lacking = {
        e.name: [c.reason for kind in needed if isinstance(c := capability(e, kind), MissingCapability)]
        for e in engines
    }
    unsupported = {name: ", ".join(reasons) for name, reasons in lacking.items() if reasons}
    return SweepPlan(name, scene, grid, tuple(rules), unsupported)


# -- the study ---------------------------------------------------------------------------------------------------------


def sweep_scene(plan: SweepPlan, time: Clock) -> Study[SweepStudy]:
    """Run and time all cases of a plan, and return the findings.

    Args:
        plan: the runs.
        time: measures costs; called after all runs, because runs at the same time would slow the timed ones.
    """
    results, guard = (yield plan.cases), ReferenceGuard()
    # Each is read once, and without its signed errors, nine tenths of it, so that very many fit into memory.
    runs = {case.key: replace(results[case.key], signed=None) for case in plan.cases}
    guard.check(plan.cases, runs)
    # Short runs first. The cost of a failed run is of no use.
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
                orders=observed_orders(rule.cases, runs),
                lines=rule_template(rule),
            )
            for rule in plan.rules
        ),
        points=tuple(_swept_points(plan, runs, timings, medians)),
        lengths=dict(plan.scene.lengths),
        distrust=guard.distrust,
    )


# -- rules and points --------------------------------------------------------------------------------------------------


def observed_orders(cases: Sequence[RunCase], results: Results) -> dict[str, ObservedOrder]:
    """Return the observed order or plateau of each quantity along a refinement.

    Runs that did not complete are left out.

    Raises:
        KeyError: a case has not been measured.
    """
    runs = {case.settings.steps_per_revolution: results[case.key] for case in cases}
    steps = sorted(n for n, run in runs.items() if run.errors is not None)
    return {q: observed_order(steps, [runs[n].largest(q) or 0.0 for n in steps]) for q in QUANTITIES}


def rule_template(rule: RulePlan) -> dict[str, str]:
    """Return the template of lines to paste for a rule, see `paste_template`."""
    settings = [(case.scene, case.settings) for case in rule.cases]
    return paste_template({own.steps_per_revolution: paste_text(rule.engine, scene, own) for scene, own in settings})


def paste_text(engine: Engine[Any], scene: Scene, settings: Settings) -> str:
    """Return settings as lines for a model or a program; the reason if the engine gives none."""
    can = capability(engine, PastableSettings)
    return f"# {can.reason}" if isinstance(can, MissingCapability) else can.paste(scene, settings)


def _engine_prefix(engine: str, engines: Sequence[str]) -> str:
    """Shortest prefix that distinguishes an engine's name from all others, in capitals."""
    others = [other for other in engines if other != engine]
    ends = range(1, len(engine) + 1)
    return next((engine[:k] for k in ends if not any(o.startswith(engine[:k]) for o in others)), engine).upper()


def _swept_points(
    plan: SweepPlan,
    results: Results,
    timings: Timings,
    references: Mapping[str, float],
) -> Iterator[SweptPoint]:
    """Yield the points of all runs.

    The cost of a revolution is its ratio to the reference loop times the median time of that loop [s], so that the
    load of the machine does not matter.
    """
    counts = Counter[str]()
    for rule, case in ((one, case) for one in plan.rules for case in one.cases):
        engine, found, timing = rule.engine.name, results[case.key], timings.get(case.key)
        counts[engine] += 1
        yield SweptPoint(
            label=f"{_engine_prefix(engine, [one.engine.name for one in plan.rules])}{counts[engine]}",
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
