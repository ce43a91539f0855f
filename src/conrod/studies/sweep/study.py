"""Study of speed against accuracy on one scene: its runs, their costs, and what they show together."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from statistics import median
from typing import Any

from conrod.engines import Engine, engine_named
from conrod.engines.capabilities import Lacking, SoftnessLaw, Swept, Timed, Varied, capability, rules_of, variations_of
from conrod.engines.engine import CUSTOM
from conrod.engines.rule import Grid, Rule, step_counts
from conrod.runs.convergence import ObservedOrder, observed_order
from conrod.runs.trajectory import Settings
from conrod.scenes import Scene
from conrod.studies.frame.case import Results, Study
from conrod.studies.frame.measurement import QUANTITIES
from conrod.studies.frame.run import RunCase
from conrod.studies.frame.timing import Timing, fingerprint
from conrod.studies.sweep.error_budget import (
    BudgetPlan,
    ErrorBudget,
    Prediction,
    budget_of,
    budget_plan_of,
    roles_of_law,
)
from conrod.studies.sweep.findings import (
    COMPLETED,
    Agreement,
    SweepStudy,
    SweptPoint,
    SweptRule,
)
from conrod.studies.sweep.grid_convergence import grid_convergence_of
from conrod.studies.sweep.sensitivity import sensitivity_cases, sensitivity_of
from conrod.studies.validation.refinement import PATHS, Family, Path, family_of

BUDGET_STEPS = 1000  # per revolution
NEEDED: tuple[type[Any], ...] = (Swept, Varied, Timed)


# Errors over L of which a first-order statement holds: clear of rounding, and small against the machine.
CLEAR, SMALL = 1e-9, 0.1

Timings = Mapping[str, Timing]
# Timings by key, of those cases that can be timed.
Clock = Callable[[list[RunCase]], Timings]


# -- the plan ---------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class RulePlan:
    """A rule of an engine's grid on one scene, with its cases at increasing numbers of steps."""

    engine: Engine[Any]
    rule: Rule
    cases: tuple[RunCase, ...]

    @property
    def family(self) -> Family:
        """The same cases, as a refinement along the path on which softness goes with the step or stays."""
        path: Path = "step with softness" if self.rule.softness_follows_step else "step alone"
        return Family(self.rule.name, path, self.cases)


@dataclass(frozen=True)
class SweepPlan:
    """All runs that a sweep of one scene needs.

    Attributes:
        budgets: of the presets.
        sensitivities: settings whose sensitivity is measured.
        both_ways: each preset's own settings refined along one path and along the other.
        unsupported: engine -> what a sweep has that it lacks.
    """

    name: str
    scene: Scene
    grid: Grid
    rules: tuple[RulePlan, ...]
    budgets: tuple[BudgetPlan, ...]
    sensitivities: tuple[Settings, ...]
    both_ways: tuple[Family, ...] = ()
    unsupported: Mapping[str, str] = field(default_factory=dict)

    @property
    def grid_cases(self) -> tuple[RunCase, ...]:
        """Cases of the grid, each once: those that are timed."""
        return tuple({case.key: case for rule in self.rules for case in rule.cases}.values())

    @property
    def cases(self) -> tuple[RunCase, ...]:
        """All cases: those of the grid, and what the studies of the presets need besides."""
        of_budgets = [case for budget in self.budgets for case in budget.cases.values()]
        varied = [sensitivity_cases(self.name, self.scene, settings).values() for settings in self.sensitivities]
        refined = [case for family in self.both_ways for case in family.cells]
        every = (*self.grid_cases, *of_budgets, *(case for cases in varied for case in cases), *refined)
        return tuple({case.key: case for case in every}.values())


def plan_sweep(name: str, scene: Scene, engines: Sequence[Engine[Any]], grid: Grid) -> SweepPlan:
    """The plan of a sweep of a scene."""
    steps = step_counts(grid, contact=bool(scene.kinematics.mechanism.cam_contacts))
    rules = [
        RulePlan(engine, rule, tuple(RunCase(name, scene, rule.settings(scene, n)) for n in steps))
        for engine in engines
        for rule in rules_of(engine, scene, grid)
    ]
    presets = _preset_settings(scene, engines)
    varied = [settings for settings in presets if is_varied(settings.engine)]
    budgets = tuple(budget_plan_of(name, scene, settings) for settings in varied)
    both_ways = tuple(family_of(name, scene, settings, path, steps) for settings in varied for path in PATHS)
    lacking = {e.name: [c.reason for kind in NEEDED if isinstance(c := capability(e, kind), Lacking)] for e in engines}
    unsupported = {name: ", ".join(reasons) for name, reasons in lacking.items() if reasons}
    return SweepPlan(name, scene, grid, tuple(rules), budgets, presets, both_ways, unsupported)


def is_varied(engine: str) -> bool:
    """True if an engine's settings can be varied one at a time; its runs alone are swept where they cannot."""
    return not isinstance(capability(engine_named(engine), Varied), Lacking)


def _preset_settings(scene: Scene, engines: Sequence[Engine[Any]]) -> tuple[Settings, ...]:
    """The presets that apply, at the steps of the budgets."""
    made = [(engine, preset(scene, BUDGET_STEPS)) for engine in engines for preset in engine.presets.values()]
    return tuple(settings for engine, settings in made if engine.refusal(scene, settings) is None)


# -- the study ---------------------------------------------------------------------------------------------------------


def sweep_scene(plan: SweepPlan, time: Clock) -> Study[SweepStudy]:
    """The study of a plan.

    Args:
        time: takes costs, after all runs: what runs beside a timing is in it.
    """
    runs = yield plan.cases
    # Those of few steps first. What a step of a failed run costs is of no use.
    timed = [case for case in plan.grid_cases if runs[case.key].outcome == COMPLETED]
    return sweep_study(plan, runs, time(sorted(timed, key=lambda case: case.settings.steps_per_revolution)))


def sweep_study(plan: SweepPlan, measurements: Results, timings: Timings) -> SweepStudy:
    """Findings from the runs of a plan.

    Raises:
        KeyError: a case of the plan has not been measured.
    """
    families = _different([rule.family for rule in plan.rules], measurements)
    engines = {rule.engine.name: rule.engine.version for rule in plan.rules}
    references: dict[str, list[float]] = {engine: [] for engine in engines}
    for rule, case in ((one, case) for one in plan.rules for case in one.cases if case.key in timings):
        references[rule.engine.name].append(timings[case.key].reference_seconds)
    return SweepStudy(
        name=plan.name,
        title=plan.scene.title,
        parameters=dict(plan.scene.parameters),
        one_pass=plan.scene.kinematics.mechanism.driver.span is not None,
        grid=plan.grid,
        engines=engines,
        reference_seconds={engine: median(seconds) for engine, seconds in references.items() if seconds},
        unsupported=dict(plan.unsupported),
        machine=fingerprint(),
        rules=tuple(
            SweptRule(
                engine=rule.engine.name,
                name=rule.rule.name,
                path=rule.family.path,
                knobs=rule.rule.knobs,
                formal_order=formal_order(rule.cases[0].settings),
                orders=orders_along(rule.family, measurements),
            )
            for rule in plan.rules
        ),
        points=tuple(_points(plan, measurements, timings)),
        agreement=_agreement(plan, measurements),
        grid_convergence=tuple(
            grid_convergence_of(family, measurements) for family in families if is_varied(family.engine)
        ),
        both_ways=tuple(grid_convergence_of(family, measurements) for family in plan.both_ways),
        budgets=tuple(_budget(budget, measurements) for budget in plan.budgets),
        sensitivities=tuple(sensitivity_of(plan.name, plan.scene, s, measurements) for s in plan.sensitivities),
        lengths=dict(plan.scene.lengths),
    )


def formal_order(settings: Settings) -> float | None:
    """Order of the integrator by its description; None where the engine states none."""
    engine = engine_named(settings.engine)
    return variations_of(engine).formal_order(settings) if is_varied(engine.name) else None


# -- rules and points --------------------------------------------------------------------------------------------------


def orders_along(family: Family, measurements: Results) -> dict[str, ObservedOrder]:
    """Order, plateau and floor of each quantity along a family; runs that did not complete are left out.

    Raises:
        KeyError: a case of the family has not been measured.
    """
    runs = {case.settings.steps_per_revolution: measurements[case.key] for case in family.cells}
    steps = sorted(n for n, run in runs.items() if run.errors is not None)
    return {q: observed_order(steps, [runs[n].largest(q) or 0.0 for n in steps]) for q in QUANTITIES}


def _points(plan: SweepPlan, measurements: Results, timings: Timings) -> Iterator[SweptPoint]:
    counts = Counter[str]()
    for rule, case in ((one, case) for one in plan.rules for case in one.cases):
        engine, found, timing = rule.engine.name, measurements[case.key], timings.get(case.key)
        counts[engine] += 1
        yield SweptPoint(
            label=f"{engine[0].upper()}{counts[engine]}",
            key=case.key,
            engine=engine,
            rule=rule.rule.name,
            preset=None if case.settings.preset == CUSTOM else case.settings.preset,
            steps_per_revolution=case.settings.steps_per_revolution,
            outcome=found.outcome,
            reason=found.reason,
            errors=None if found.errors is None else {q: found.largest(q) or 0.0 for q in QUANTITIES},
            cost=None if timing is None else timing.seconds_per_revolution,
            ratio=None if timing is None else timing.ratio,
        )


def _agreement(plan: SweepPlan, measurements: Results) -> Agreement | None:
    shares = []
    for run in (measurements[case.key] for rule in plan.rules for case in rule.cases):
        error = run.largest("position")
        if error is not None and run.prediction is not None and CLEAR <= error <= SMALL:
            shares.append(run.prediction["position"]["difference"] / error)
    return Agreement(max(shares), len(shares)) if shares else None


# -- families and budgets ----------------------------------------------------------------------------------------------


def _different(families: Sequence[Family], measurements: Results) -> tuple[Family, ...]:
    """Families without those that come to the same as another one: a knob that changes nothing must not count twice."""
    found: dict[tuple[object, ...], Family] = {}
    for family in families:
        errors = [[measurements[case.key].largest(quantity) for quantity in QUANTITIES] for case in family.cells]
        shown = tuple("" if error is None else f"{error:.2e}" for sizes in errors for error in sizes)
        found.setdefault((family.engine, family.path, shown), family)
    return tuple(found.values())


def _budget(plan: BudgetPlan, measurements: Results) -> ErrorBudget:
    """The budget with what the engine's law gives for the runs that completed: an unknown size needs no law."""
    found: dict[str, Prediction] = {}
    for role in roles_of_law(plan):
        case = plan.cases[role]
        if measurements[case.key].signed is not None:
            law = capability(engine_named(case.settings.engine), SoftnessLaw)
            softness = None if isinstance(law, Lacking) else law.predicted_softness(case.scene, case.settings)
            if softness is not None:
                # A budget is of the last turn.
                found[role] = (softness.last_turn, softness.law)
    return budget_of(plan, measurements, found)
