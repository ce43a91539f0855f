"""Sweep of a scene: the runs that the trade of speed for accuracy needs, and what they show together."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from conrod.engines import Engine, engine_named
from conrod.engines.capabilities import Lacking, Swept, Timed, Varied, capability, rules_of
from conrod.engines.rule import Grid, Rule, step_counts
from conrod.runs.trajectory import Settings
from conrod.scenes import Scene
from conrod.studies.frame.run import RunCase
from conrod.studies.sweep.error_budget import BudgetPlan, budget_plan_of
from conrod.studies.sweep.sensitivity import sensitivity_cases
from conrod.studies.validation.refinement import PATHS, Family, Path, family_of

BUDGET_STEPS = 1000  # per revolution
NEEDED: tuple[type[Any], ...] = (Swept, Varied, Timed)


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
