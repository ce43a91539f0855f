"""The trade of speed for accuracy: which runs a sweep needs, and what they show together."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from conrod.engines import Engine, engine_named
from conrod.engines.capabilities import Lacking, SoftnessLaw, Varied, capability, rules_of
from conrod.engines.rule import Grid, Rule, step_counts
from conrod.runs.trajectory import Settings
from conrod.scenes import Scene
from conrod.studies.frame.measurement import QUANTITIES, Measurement
from conrod.studies.frame.run import RunCase
from conrod.studies.frame.timing import Timing
from conrod.studies.sweep.budget_plan import BudgetPlan, budget_plan_of
from conrod.studies.sweep.error_budget import ErrorBudget, Prediction, budget_of, roles_of_law
from conrod.studies.sweep.grid_convergence import grid_convergence_of
from conrod.studies.sweep.observed_orders import orders_along
from conrod.studies.sweep.results import COMPLETED, SweepStudy, SweptPoint
from conrod.studies.sweep.sensitivity import sensitivity_cells, sensitivity_of
from conrod.studies.validation.refinement import PATHS, Family, Path, family_of

BUDGET_STEPS = 1000  # per revolution


@dataclass(frozen=True)
class SweptRule:
    """A rule of an engine's grid on one scene, with its cells at increasing numbers of steps."""

    engine: Engine[Any]
    rule: Rule
    cells: tuple[RunCase, ...]

    @property
    def path(self) -> Path:
        """What follows the step along the cells."""
        return "step with softness" if self.rule.softness_follows_step else "step alone"

    @property
    def family(self) -> Family:
        """The same cells, as a refinement."""
        return Family(self.rule.name, self.path, self.cells)


@dataclass(frozen=True)
class SweepPlan:
    """All runs that a sweep of one scene needs."""

    name: str
    scene: Scene
    grid: Grid
    rules: tuple[SweptRule, ...]
    budgets: tuple[BudgetPlan, ...]  # of the presets
    sensitivities: tuple[Settings, ...]  # whose sensitivity is measured
    both_ways: tuple[Family, ...] = ()  # each preset's own settings refined along one path and along the other

    @property
    def grid_cells(self) -> tuple[RunCase, ...]:
        """Cells of the grid, each once: those that are timed."""
        return tuple({cell.key: cell for rule in self.rules for cell in rule.cells}.values())

    @property
    def cells(self) -> tuple[RunCase, ...]:
        """All cells: those of the grid, and what the studies of the presets need besides."""
        of_budgets = [cell for budget in self.budgets for cell in budget.cells.values()]
        of_sensitivities = [
            cell
            for settings in self.sensitivities
            for cell in sensitivity_cells(self.name, self.scene, settings).values()
        ]
        refined = [cell for family in self.both_ways for cell in family.cells]
        return tuple({cell.key: cell for cell in (*self.grid_cells, *of_budgets, *of_sensitivities, *refined)}.values())


def plan_sweep(name: str, scene: Scene, engines: Sequence[Engine[Any]], grid: Grid) -> SweepPlan:
    """The plan of a sweep of a scene."""
    steps = step_counts(grid, contact=bool(scene.kinematics.mechanism.cam_contacts))
    rules = [
        SweptRule(engine, rule, tuple(RunCase(name, scene, rule.settings(scene, n)) for n in steps))
        for engine in engines
        for rule in rules_of(engine, scene, grid)
    ]
    presets = _preset_settings(scene, engines)
    varied = [settings for settings in presets if _is_varied(settings.engine)]
    budgets = tuple(budget_plan_of(name, scene, settings) for settings in varied)
    both_ways = tuple(family_of(name, scene, settings, path, steps) for settings in varied for path in PATHS)
    return SweepPlan(name, scene, grid, tuple(rules), budgets, presets, both_ways)


def _is_varied(engine: str) -> bool:
    """Whether an engine's settings can be varied one at a time; its runs alone are swept where they cannot."""
    return not isinstance(capability(engine_named(engine), Varied), Lacking)


def _preset_settings(scene: Scene, engines: Sequence[Engine[Any]]) -> tuple[Settings, ...]:
    """The presets that apply, at the steps of the budgets."""
    made = [(engine, preset(scene, BUDGET_STEPS)) for engine in engines for preset in engine.presets.values()]
    return tuple(settings for engine, settings in made if engine.refusal(scene, settings) is None)


def cells_to_time(plan: SweepPlan, measurements: Mapping[str, Measurement]) -> list[RunCase]:
    """The cells whose cost is measured, those of few steps first: what a step of a failed run costs is of no use."""
    timed = [cell for cell in plan.grid_cells if measurements[cell.key].outcome == COMPLETED]
    return sorted(timed, key=lambda cell: cell.settings.steps_per_revolution)


def sweep_study(
    plan: SweepPlan, measurements: Mapping[str, Measurement], timings: Mapping[str, Timing], machine: str
) -> SweepStudy:
    """What the runs of a plan show.

    Raises:
        KeyError: a cell of the plan has not been measured.
    """
    families = [rule.family for rule in plan.rules]
    return SweepStudy(
        name=plan.name,
        scene=plan.scene,
        grid=plan.grid,
        engines={rule.engine.name: rule.engine.version for rule in plan.rules},
        machine=machine,
        points=_points(plan, measurements, timings),
        orders=tuple(orders_along(family, measurements) for family in families),
        grid_convergence=tuple(
            grid_convergence_of(f, measurements) for f in _different(families, measurements) if _is_varied(f.engine)
        ),
        both_ways=tuple(grid_convergence_of(family, measurements) for family in plan.both_ways),
        budgets=tuple(_budget(budget, measurements) for budget in plan.budgets),
        sensitivities=tuple(
            sensitivity_of(plan.name, plan.scene, settings, measurements) for settings in plan.sensitivities
        ),
    )


def _different(families: Sequence[Family], measurements: Mapping[str, Measurement]) -> tuple[Family, ...]:
    """Families without those that come to the same as another one: a knob that changes nothing must not count twice."""
    found: dict[tuple[object, ...], Family] = {}
    for family in families:
        errors = [[measurements[cell.key].largest(quantity) for quantity in QUANTITIES] for cell in family.cells]
        shown = tuple("" if error is None else f"{error:.2e}" for sizes in errors for error in sizes)
        found.setdefault((family.engine, family.path, shown), family)
    return tuple(found.values())


def _budget(plan: BudgetPlan, measurements: Mapping[str, Measurement]) -> ErrorBudget:
    return budget_of(plan, measurements, _predictions(plan, measurements))


def _predictions(plan: BudgetPlan, measurements: Mapping[str, Measurement]) -> dict[str, Prediction]:
    """What the engine's law gives for the runs that completed, by role; a size that is not known needs no law."""
    found = {}
    for role in roles_of_law(plan):
        cell = plan.cells[role]
        if measurements[cell.key].signed is not None:
            law = capability(engine_named(cell.settings.engine), SoftnessLaw)
            softness = None if isinstance(law, Lacking) else law.predicted_softness(cell.scene, cell.settings)
            if softness is not None:
                # A budget is of the last turn.
                found[role] = (softness.last_turn, softness.law)
    return found


def _points(
    plan: SweepPlan, measurements: Mapping[str, Measurement], timings: Mapping[str, Timing]
) -> tuple[SweptPoint, ...]:
    points = []
    counts = {rule.engine.name: 0 for rule in plan.rules}
    for rule in plan.rules:
        for cell in rule.cells:
            counts[rule.engine.name] += 1
            key, settings = cell.key, cell.settings
            points.append(
                SweptPoint(
                    label=f"{rule.engine.name[0].upper()}{counts[rule.engine.name]}",
                    key=key,
                    engine=rule.engine.name,
                    rule=rule.rule.name,
                    preset=None if settings.preset == "custom" else settings.preset,
                    path=rule.path,
                    knobs=rule.rule.knobs(),
                    settings=settings.as_dict(),
                    steps_per_revolution=settings.steps_per_revolution,
                    measurement=measurements[key],
                    timing=timings.get(key),
                )
            )
    return tuple(points)
