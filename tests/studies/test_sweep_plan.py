"""What a sweep turns: its grids hold every knob once, the presets among them, at steps that share their angles."""

from __future__ import annotations

from typing import Any

import pytest
from measured import FAILED, errors_by_step

from conrod.engines import ENGINES, engine_named
from conrod.engines.pymunk.settings import PymunkSettings
from conrod.engines.variants import GRIDS, Grid, step_counts
from conrod.scenes import SCENES
from conrod.studies.frame.run import SIGNED_ANGLES, RunCase, measure
from conrod.studies.frame.timing import Timing
from conrod.studies.sweep.study import orders_along, plan_sweep, sweep_study

SAW = SCENES["saw-500rpm"]
EVERY = [(scene, engine) for scene in SCENES for engine in ENGINES]


@pytest.mark.parametrize("grid", GRIDS)
@pytest.mark.parametrize(("scene", "engine"), EVERY)
def test_no_two_rules_of_a_grid_have_one_name_or_the_same_settings(scene: str, engine: str, grid: Grid) -> None:
    rules = engine_named(engine).grid(SCENES[scene], grid)
    assert len({rule.name for rule in rules}) == len(rules)
    keys = [
        tuple(RunCase(scene, SCENES[scene], rule.settings(SCENES[scene], n)).key for n in (200, 300)) for rule in rules
    ]
    assert len(set(keys)) == len(rules)


@pytest.mark.parametrize(("scene", "engine"), EVERY)
def test_every_preset_that_applies_is_in_every_grid(scene: str, engine: str) -> None:
    machine, used = SCENES[scene], engine_named(engine)
    applying = {n for n, preset in used.presets.items() if used.refusal(machine, preset(machine, 1000)) is None}
    for grid in GRIDS:
        settings = [rule.settings(machine, 1000) for rule in used.grid(machine, grid)]
        assert {s.preset for s in settings} == applying | ({"custom"} if len(settings) > len(applying) else set())
        for name in applying:
            assert used.presets[name](machine, 1000) in settings


@pytest.mark.parametrize("grid", GRIDS)
@pytest.mark.parametrize("contact", [False, True])
def test_steps_run_from_20_to_20000_and_share_the_angles_of_signed_errors(grid: Grid, contact: bool) -> None:
    steps = step_counts(grid, contact=contact)
    assert steps[0] == 20
    assert 20000 in steps
    assert list(steps) == sorted(set(steps))
    assert all(n % SIGNED_ANGLES == 0 for n in steps)


def test_grids_contain_one_another() -> None:
    for scene in SCENES.values():
        for engine in map(engine_named, ENGINES):
            coarse, default = (set(engine.grid(scene, grid)) for grid in GRIDS)
            assert coarse < default


@pytest.fixture(scope="module")
def small() -> Any:
    """A real sweep of pymunk's presets at two coarse steps, with costs as if a step took a microsecond."""
    scene = SCENES["saw-500rpm"]
    plan = plan_sweep("saw-500rpm", scene, [engine_named("pymunk")], "coarse")
    from dataclasses import replace

    rules = tuple(replace(rule, cases=rule.cases[:2]) for rule in plan.rules)
    plan = replace(plan, rules=rules)
    measurements = {cell.key: measure(cell) for cell in plan.cases}
    timings = {
        cell.key: Timing(1e-6 * cell.settings.steps_per_revolution, 1e-6, cell.settings.steps_per_revolution, 1, 1, "m")
        for cell in plan.cases
        if measurements[cell.key].outcome == "completed"
    }
    return sweep_study(plan, measurements, timings)


def test_a_run_that_does_not_complete_is_a_point_without_errors(small: Any) -> None:
    failed = [point for point in small.points if not point.completed]
    assert [(point.preset, point.steps_per_revolution) for point in failed] == [("stock", 20)]
    assert failed[0].error("position") is None
    assert failed[0] not in small.front("position")


def test_points_are_numbered_by_engine_and_identified(small: Any) -> None:
    assert [point.label for point in small.points] == ["P1", "P2", "P3", "P4"]
    for point in small.points:
        assert point.rule in {rule.name for rule in small.rules}
        assert len(point.key) == 32


def test_stock_and_tuned_pymunk_are_on_the_front_in_their_places(small: Any) -> None:
    front = small.front("position")
    assert [point.cost for point in front] == sorted(point.cost for point in front)
    errors = [point.error("position") for point in front]
    assert errors == sorted(errors, reverse=True)


def test_the_order_is_that_of_the_runs_that_completed() -> None:
    cases = [RunCase("saw", SAW, PymunkSettings.tuned(SAW, steps)) for steps in (20, 40, 100, 200, 400)]
    runs = {c.key: errors_by_step(SAW, lambda h: h**2, c.settings.steps_per_revolution) for c in cases}
    runs[cases[1].key] = FAILED
    found = orders_along(cases, runs)["position"]
    assert found.claimed == pytest.approx(2.0)
    assert len(found.pairs) == len(cases) - 2
