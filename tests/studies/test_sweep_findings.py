"""What a sweep finds: fronts of what nothing beats, orders, and where an error has stopped falling."""

from __future__ import annotations

from dataclasses import replace

import pytest
from handmade import handmade_sweep

from conrod.engines import ENGINES, engine_named
from conrod.engines.pymunk import PymunkSettings
from conrod.engines.variants import GRIDS, Grid, step_counts
from conrod.runs.convergence import observed_order
from conrod.scenes import SCENES
from conrod.studies.frame.case import QUANTITIES, Measurement
from conrod.studies.frame.run import SIGNED_ANGLES, RunCase
from conrod.studies.sweep.study import orders_along

STEPS = (100, 200, 400, 800)


def test_a_front_has_the_completed_and_timed_points_of_an_engine_that_nothing_beats() -> None:
    study = handmade_sweep()
    assert {p.outcome for p in study.points} == {"completed", "opened"}
    for engine in (None, "mujoco", "pymunk"):
        candidates = [p for p in study.points if p.completed and engine in (None, p.engine)]
        costs = {p.label: (p.cost or 0.0, p.error("velocity") or 0.0) for p in candidates}
        front = study.front("velocity", engine)
        assert front
        for point in candidates:
            cost, error = costs[point.label]
            beaten = any(c <= cost and e < error for c, e in costs.values())
            assert (point in front) is not beaten
        assert [p.cost for p in front] == sorted(p.cost or 0.0 for p in front)
    best = study.front("position", "pymunk")[-1]
    assert (best.errors or {})["position"] == best.error("position") == 1.6e-6
    untimed = replace(study, points=tuple(replace(p, cost=None) if p is best else p for p in study.points))
    assert best.label not in {p.label for p in untimed.front("position")}
    # Nothing beats what costs nothing, or has no error at all.
    perfect = replace(best, errors=dict.fromkeys(best.errors or {}, 0.0))
    for made in (perfect, replace(best, cost=0.0)):
        others = tuple(made if p is best else p for p in study.points)
        assert made in replace(study, points=others).front("position")


@pytest.mark.parametrize(
    ("errors", "claimed", "plateau"),
    [
        ([64e-4, 16e-4, 4e-4, 1e-4], 2.0, None),
        ([1e-2, 1.02e-4, 1.01e-4, 1e-4], None, 1e-4),
        ([1e-2, 1e-3, 1e-4, 1e-4], None, None),  # still for one pair alone
        ([1e-2, 1e-4, 1e-4, 1e-5], None, None),
        ([1e-4, 1e-4, 2e-4, 4e-4], None, None),  # grows
        ([1e-4, 0.0, 1e-4, 1e-4], None, None),
        ([0.0, 1e-4, 1e-4, 1e-4], None, 1e-4),
        ([1e-4, 1e-4, 1e-4], None, 1e-4),
        ([1e-4, 1e-4], None, None),
        ([1e-2, 1e-4, 1e-4 * 2.0**0.099, 1e-4], None, 1e-4),  # up to a tenth of an order
    ],
)
def test_an_error_whose_last_two_pairs_have_no_order_is_a_plateau(
    errors: list[float], claimed: float | None, plateau: float | None
) -> None:
    found = observed_order(STEPS[: len(errors)], errors)
    assert found.claimed == (None if claimed is None else pytest.approx(claimed))
    assert found.plateau == plateau


# -- what is swept -----------------------------------------------------------------------------------------------------

SAW = SCENES["saw-500rpm"]
EVERY = [(scene, engine) for scene in SCENES for engine in ENGINES]


@pytest.mark.parametrize(("scene", "engine"), EVERY)
def test_a_grid_has_every_preset_that_applies_and_no_settings_or_names_twice(scene: str, engine: str) -> None:
    machine, used = SCENES[scene], engine_named(engine)
    applying = {n for n, preset in used.presets.items() if used.refusal(machine, preset(machine, 1000)) is None}
    for grid in GRIDS:
        rules = used.grid(machine, grid)
        settings = [rule.settings(machine, 1000) for rule in rules]
        keys = {RunCase(scene, machine, one).key for one in settings}
        assert len({rule.name for rule in rules}) == len(keys) == len(rules)
        assert {s.preset for s in settings} == applying | ({"custom"} if len(settings) > len(applying) else set())
        assert all(used.presets[name](machine, 1000) in settings for name in applying)


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
