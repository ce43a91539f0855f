"""What a sweep turns: its grids hold every knob once, the presets among them, at steps that share their angles."""

from __future__ import annotations

import pytest

from conrod.engines import ENGINES, engine_named
from conrod.engines.pymunk import PymunkSettings
from conrod.engines.variants import GRIDS, Grid, step_counts
from conrod.scenes import SCENES
from conrod.studies.frame.case import QUANTITIES, Measurement
from conrod.studies.frame.run import SIGNED_ANGLES, RunCase
from conrod.studies.sweep.study import orders_along

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


def second_order(case: RunCase) -> Measurement:
    sizes = dict.fromkeys(("max", "rms", "final"), case.settings.steps_per_revolution**-2.0)
    return Measurement("completed", errors={"C": dict.fromkeys(QUANTITIES, sizes)})


def test_the_order_is_that_of_the_runs_that_completed() -> None:
    cases = [RunCase("saw", SAW, PymunkSettings.tuned(SAW, steps)) for steps in (20, 40, 100, 200, 400)]
    runs = {case.key: second_order(case) for case in cases} | {cases[1].key: Measurement("exploded")}
    found = orders_along(cases, runs)["position"]
    assert found.claimed == pytest.approx(2.0)
