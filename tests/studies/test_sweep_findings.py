"""What a sweep finds: fronts of what nothing beats, orders, and where an error has stopped falling."""

from __future__ import annotations

from dataclasses import replace

import pytest
from handmade import handmade_sweep
from synthetic import completed_result

from conrod.comparison.convergence import observed_order
from conrod.engines import ENGINES, engine_named
from conrod.engines.pymunk import PymunkSettings
from conrod.engines.variants import ENGINE_GRIDS, Grid, step_counts
from conrod.execution.run import SIGNED_ANGLES, RunCase, RunResult
from conrod.scenes import SCENES
from conrod.studies.sweep.findings import SweptRule, fill_paste_template, pareto_front, paste_template
from conrod.studies.sweep.study import observed_orders

STEPS = (100, 200, 400, 800)


def test_front_has_unbeaten_points_that_completed_and_are_timed() -> None:
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


def test_front_has_the_first_of_points_with_equal_cost_and_error() -> None:
    costs = [(3.0, 1.0), (1.0, 4.0), (2.0, 2.0), (2.0, 3.0), (2.0, 2.0), (4.0, 1.0), (1.0, 5.0), (5.0, 0.5)]
    front = pareto_front(enumerate(costs), lambda item: item[1])
    assert front == ((1, (1.0, 4.0)), (2, (2.0, 2.0)), (0, (3.0, 1.0)), (7, (5.0, 0.5)))


def test_failed_point_has_no_error_and_rule_points_go_by_steps() -> None:
    study = handmade_sweep()
    same_name = tuple(replace(p, engine="newcomer") for p in study.points)
    study = replace(study, points=(*reversed(study.points), *same_name))
    for rule in study.rules:
        points = study.points_of(rule)
        assert [p.steps_per_revolution for p in points] == [20, 100, 500, 2500]
        assert {(p.engine, p.rule) for p in points} == {(rule.engine, rule.name)}
    assert {p.error("position") is None for p in study.points if p.outcome == "opened"} == {True}


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
def test_error_is_a_plateau_when_last_two_pairs_have_no_order(
    errors: list[float], claimed: float | None, plateau: float | None
) -> None:
    found = observed_order(STEPS[: len(errors)], errors)
    assert found.claimed == (None if claimed is None else pytest.approx(claimed))
    assert found.plateau == plateau


# -- what is swept -----------------------------------------------------------------------------------------------------

SAW = SCENES["saw-500rpm"]
EVERY = [(scene, engine) for scene in SCENES for engine in ENGINES]


@pytest.mark.parametrize(("scene", "engine"), EVERY)
def test_grid_has_every_fit_preset_and_no_duplicate(scene: str, engine: str) -> None:
    machine, used = SCENES[scene], engine_named(engine)
    applying = {n for n, preset in used.presets.items() if used.refusal(machine, preset(machine, 1000)) is None}
    for grid in ENGINE_GRIDS:
        rules = used.grid(machine, grid)
        settings = [rule.settings(machine, 1000) for rule in rules]
        keys = {RunCase(scene, machine, one).key for one in settings}
        assert len({rule.name for rule in rules}) == len(keys) == len(rules)
        assert {s.preset for s in settings} == applying | ({"custom"} if len(settings) > len(applying) else set())
        assert all(used.presets[name](machine, 1000) in settings for name in applying)


@pytest.mark.parametrize("grid", ENGINE_GRIDS)
@pytest.mark.parametrize("contact", [False, True])
def test_steps_go_from_20_to_20000_and_share_signed_error_angles(grid: Grid, contact: bool) -> None:
    steps = step_counts(grid, contact=contact)
    assert steps[0] == 20
    assert 20000 in steps
    assert list(steps) == sorted(set(steps))
    assert all(n % SIGNED_ANGLES == 0 for n in steps)


def test_the_order_is_that_of_the_runs_that_completed() -> None:
    cases = [RunCase("saw", SAW, PymunkSettings.tuned(SAW, steps)) for steps in (20, 40, 100, 200, 400)]
    runs = {case.key: completed_result(case.settings.steps_per_revolution**-2.0) for case in cases}
    runs[cases[1].key] = RunResult("exploded")
    found = observed_orders(cases, runs)["position"]
    assert found.claimed == pytest.approx(2.0)


# -- lines to paste ----------------------------------------------------------------------------------------------------


def lines(steps: int) -> str:
    """Lines with a number that goes with the step, two with its square, and some that stay."""
    return (
        f'site1 v2.5 solimp="0.9 {0.12 / steps:.15g}" '
        f"bias = -{3.0 / steps**2:.15g}, {50.0 / steps**2:.15g}\ntolerance = 0"
    )


def test_lines_share_a_text_when_numbers_scale_with_the_step() -> None:
    shared = paste_template({n: lines(n) for n in (500, 20, 2500)})
    text = 'site1 v2.5 solimp="0.9 {0.12/n1}" bias = {-3/n2}, {50/n2}\ntolerance = 0'
    assert shared == {"n": text}
    for steps in (20, 100, 640, 20000):
        assert fill_paste_template(shared, steps) == lines(steps)


@pytest.mark.parametrize(
    ("few", "many"),
    [
        ("dt = 0.3 at", "dt = 0.05 at"),  # as no power of the step
        ("dt = 1", "dt = 10"),  # more with more steps
        ("dt = 0", "dt = 0.1"), ("dt = 1", "dt = 0"), ("dt = -1", "dt = 0.1"),
        ("on = 1", "off = 1"), ("dt = 1", "dt = 0.1 0.2"), ("dt = 1", "dt = 0.10000000001"),
        ("dt = 1 2", "dt = 0.1 0.20000000001"),
    ],
)  # fmt: skip
def test_lines_that_differ_in_another_way_are_kept_for_each_step(few: str, many: str) -> None:
    kept = paste_template({20: few, 200: many})
    assert kept == {"20": few, "200": many}
    assert [fill_paste_template(kept, steps) for steps in (20, 40, 200)] == [few, "", many]


def test_lines_that_differ_by_rounding_alone_are_one_text() -> None:
    assert paste_template({20: "dt = 1", 200: "dt = 0.10000000000001"}) == {"n": "dt = {20/n1}"}


@pytest.mark.parametrize("engine", ["mujoco", "pymunk"])
def test_grid_rule_has_one_text_and_point_the_lines_at_its_steps(engine: str) -> None:
    used, study = engine_named(engine), handmade_sweep()
    known = {rule.name: {n: used.paste(SAW, rule.settings(SAW, n)) for n in STEPS} for rule in used.grid(SAW, "coarse")}
    assert {tuple(paste_template(pastes)) for pastes in known.values()} == {("n",)}
    rules = tuple(SweptRule(engine, name, {}, paste_template(pastes)) for name, pastes in known.items())
    others = tuple(SweptRule("another", name, {}, {"n": "# of another"}) for name in known)
    point = next(p for p in study.points if p.engine == engine)
    swept = replace(study, rules=(*others, *rules))
    for name, pastes in known.items():
        own = replace(point, rule=name, steps_per_revolution=200)
        assert paste_template({1: pastes[200], 2: swept.settings_lines(own), 3: pastes[200]}).keys() == {"n"}
    assert swept.settings_lines(replace(point, rule="no such rule")) == ""
