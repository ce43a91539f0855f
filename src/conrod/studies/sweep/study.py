"""Study of speed against accuracy on one scene: its runs, their costs, and what they show together."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from statistics import median

from conrod.engines import engine_named
from conrod.engines.capabilities import Lacking, SoftnessLaw, capability, variations_of
from conrod.engines.engine import CUSTOM
from conrod.studies.frame.measurement import QUANTITIES, Measurement
from conrod.studies.frame.run import RunCase
from conrod.studies.frame.study import Study
from conrod.studies.frame.timing import Timing, fingerprint
from conrod.studies.sweep.error_budget import BudgetPlan, ErrorBudget, Prediction, budget_of, roles_of_law
from conrod.studies.sweep.findings import (
    COMPLETED,
    Agreement,
    QuantityOrder,
    SweepStudy,
    SweptPoint,
    SweptRule,
    order_of,
)
from conrod.studies.sweep.grid_convergence import grid_convergence_of
from conrod.studies.sweep.plan import RulePlan, SweepPlan, is_varied
from conrod.studies.sweep.sensitivity import sensitivity_of
from conrod.studies.validation.refinement import Family

# Errors over L of which a first-order statement holds: clear of rounding, and small against the machine.
CLEAR, SMALL = 1e-9, 0.1

Measurements = Mapping[str, Measurement]
Timings = Mapping[str, Timing]
# Timings by key, of those cases that can be timed.
Clock = Callable[[list[RunCase]], Timings]


def sweep_scene(plan: SweepPlan, time: Clock) -> Study[SweepStudy]:
    """The study of a plan.

    Args:
        time: takes costs, after all runs: what runs beside a timing is in it.
    """
    runs = yield plan.cases
    return sweep_study(plan, runs, time(cases_to_time(plan, runs)))


def cases_to_time(plan: SweepPlan, measurements: Measurements) -> list[RunCase]:
    """The cases whose cost is measured, those of few steps first: what a step of a failed run costs is of no use."""
    timed = [case for case in plan.grid_cases if measurements[case.key].outcome == COMPLETED]
    return sorted(timed, key=lambda case: case.settings.steps_per_revolution)


def sweep_study(plan: SweepPlan, measurements: Measurements, timings: Timings) -> SweepStudy:
    """Findings from the runs of a plan.

    Raises:
        KeyError: a case of the plan has not been measured.
    """
    families = [rule.family for rule in plan.rules]
    engines = {rule.engine.name: rule.engine for rule in plan.rules}
    return SweepStudy(
        name=plan.name,
        title=plan.scene.title,
        parameters=dict(plan.scene.parameters),
        one_pass=plan.scene.kinematics.mechanism.driver.span is not None,
        grid=plan.grid,
        engines={name: engine.version for name, engine in engines.items()},
        reference_seconds=_reference_seconds(plan, timings),
        unsupported=dict(plan.unsupported),
        machine=fingerprint(),
        rules=tuple(_rule(rule, measurements) for rule in plan.rules),
        points=_points(plan, measurements, timings),
        agreement=_agreement(plan, measurements),
        grid_convergence=tuple(
            grid_convergence_of(f, measurements) for f in _different(families, measurements) if is_varied(f.engine)
        ),
        both_ways=tuple(grid_convergence_of(family, measurements) for family in plan.both_ways),
        budgets=tuple(_budget(budget, measurements) for budget in plan.budgets),
        sensitivities=tuple(sensitivity_of(plan.name, plan.scene, s, measurements) for s in plan.sensitivities),
    )


# -- rules and points --------------------------------------------------------------------------------------------------


def _rule(plan: RulePlan, measurements: Measurements) -> SweptRule:
    engine = plan.engine.name
    return SweptRule(
        engine=engine,
        name=plan.rule.name,
        path=plan.family.path,
        knobs=plan.rule.knobs,
        formal_order=variations_of(plan.engine).formal_order(plan.cases[0].settings) if is_varied(engine) else None,
        orders=orders_along(plan.family, measurements),
    )


def orders_along(family: Family, measurements: Measurements) -> dict[str, QuantityOrder]:
    """Order, plateau and floor of each quantity along a family; runs that did not complete are left out.

    Raises:
        KeyError: a case of the family has not been measured.
    """
    runs = {case.settings.steps_per_revolution: measurements[case.key] for case in family.cells}
    steps = sorted(n for n, run in runs.items() if run.errors is not None)
    return {q: order_of(steps, [runs[n].largest(q) or 0.0 for n in steps]) for q in QUANTITIES}


def _points(plan: SweepPlan, measurements: Measurements, timings: Timings) -> tuple[SweptPoint, ...]:
    points = list[SweptPoint]()
    for rule in plan.rules:
        for case in rule.cases:
            number = 1 + sum(point.engine == rule.engine.name for point in points)
            label = f"{rule.engine.name[0].upper()}{number}"
            points.append(_point(label, rule, case, measurements[case.key], timings.get(case.key)))
    return tuple(points)


def _point(label: str, rule: RulePlan, case: RunCase, found: Measurement, timing: Timing | None) -> SweptPoint:
    preset = None if case.settings.preset == CUSTOM else case.settings.preset
    return SweptPoint(
        label=label,
        key=case.key,
        engine=rule.engine.name,
        rule=rule.rule.name,
        preset=preset,
        steps_per_revolution=case.settings.steps_per_revolution,
        outcome=found.outcome,
        reason=found.reason,
        errors=None if found.errors is None else {q: found.largest(q) or 0.0 for q in QUANTITIES},
        cost=None if timing is None else timing.seconds_per_revolution,
        ratio=None if timing is None else timing.ratio,
    )


def _reference_seconds(plan: SweepPlan, timings: Timings) -> dict[str, float]:
    found: dict[str, list[float]] = {}
    for rule in plan.rules:
        for case in rule.cases:
            if case.key in timings:
                found.setdefault(rule.engine.name, []).append(timings[case.key].reference_seconds)
    return {engine: median(seconds) for engine, seconds in found.items()}


def _agreement(plan: SweepPlan, measurements: Measurements) -> Agreement | None:
    shares = []
    for case in (case for rule in plan.rules for case in rule.cases):
        run = measurements[case.key]
        error = run.largest("position")
        if error is not None and run.prediction is not None and CLEAR <= error <= SMALL:
            shares.append(run.prediction["position"]["difference"] / error)
    return Agreement(max(shares), len(shares)) if shares else None


# -- families and budgets ----------------------------------------------------------------------------------------------


def _different(families: Sequence[Family], measurements: Measurements) -> tuple[Family, ...]:
    """Families without those that come to the same as another one: a knob that changes nothing must not count twice."""
    found: dict[tuple[object, ...], Family] = {}
    for family in families:
        errors = [[measurements[case.key].largest(quantity) for quantity in QUANTITIES] for case in family.cells]
        shown = tuple("" if error is None else f"{error:.2e}" for sizes in errors for error in sizes)
        found.setdefault((family.engine, family.path, shown), family)
    return tuple(found.values())


def _budget(plan: BudgetPlan, measurements: Measurements) -> ErrorBudget:
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
