"""A recommendation is the cheapest setting within all tolerances that runs outside the grid confirm."""

from __future__ import annotations

import copy
import json
import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import cache
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from planted_engine import ENGINE as PLANTED

from benchmarks.prior import table_of
from conrod.engines import engine_named
from conrod.engines.engine import round_settings
from conrod.errors import InvalidInput
from conrod.exact.motion import QUANTITIES
from conrod.execution.case import pursue
from conrod.execution.run import RunCase, RunResult
from conrod.execution.timing import Timing
from conrod.scenes import SCENES, scene_named
from conrod.studies.sweep.prior import shipped_sweeps
from conrod.studies.sweep.recommend import NoRecommendation, check_tolerances, confirming_cases, recommendation_studies
from conrod.studies.sweep.step_search import Candidate, StepSearch, TriedRun, find_finer_candidate, run_searches
from conrod.studies.sweep.study import SweepPlan, plan_sweep

SAW, PYMUNK = SCENES["saw-500rpm"], engine_named("pymunk")


class PretendedRuns:
    """Runs whose errors and costs are given by formulas of the cell."""

    def __init__(self, error: Callable[[RunCase], float], cost: Callable[[RunCase], float]) -> None:
        self.error, self.cost, self.ran = error, cost, list[RunCase]()

    def run(self, cells: list[RunCase]) -> dict[str, RunResult]:
        self.ran += cells
        return {cell.key: measured(self.error(cell)) for cell in cells}

    def time(self, cells: list[RunCase]) -> dict[str, Timing]:
        costs = {cell.key: self.cost(cell) for cell in cells}
        return {key: Timing(1e-6 * cost, 1e-6, cost, 1, 1, "m") for key, cost in costs.items()}


def measured(error: float | None) -> RunResult:
    """A run with an error in all quantities, or one that did not complete."""
    if error is None or math.isnan(error):
        return RunResult("exploded", "the loop is open")
    return RunResult("completed", errors={"C": {quantity: {"max": error} for quantity in QUANTITIES}})


def per_step(cell: RunCase) -> float:
    return float(cell.settings.steps_per_revolution)


def per_iteration(cell: RunCase) -> float:
    return per_step(cell) * float(cell.settings.as_dict()["iterations"])


def second_order(cell: RunCase) -> float:
    """Tuned settings of order 2, and stock ones of order 1 and ten times the error."""
    steps = cell.settings.steps_per_revolution
    return 40.0 / steps**2 if cell.settings.as_dict()["error_bias"] == 0.0 else 2.0 / steps


def elsewhere(cell: RunCase) -> bool:
    """True for a run that the grid does not contain."""
    return cell.start_angle != 0.0 or cell.revolutions != 2.0 or cell.scene.speed != SAW.speed


@cache
def grid_of_saw() -> SweepPlan:
    return plan_sweep("saw-500rpm", SAW, [PYMUNK], "default")


def recommended(runs: PretendedRuns, prior: Mapping[str, Any] | None = None, **allowed: float) -> Any:
    """The answer of a search that begins with the shipped table, or another one."""
    table = shipped_sweeps() if prior is None else prior
    (answer,) = pursue(recommendation_studies(grid_of_saw(), allowed, runs.time, table), runs.run)
    return answer


def test_coarsest_sufficient_step_is_found_between_grid_steps() -> None:
    answer = recommended(PretendedRuns(second_order, per_step), position=1e-4)
    # sqrt(40 / 1e-4) = 632 steps would just do; the error is aimed at 1.25 times below what is allowed.
    assert 708 <= answer.candidate.steps <= 1.01 * 708
    assert 1.25 <= answer.margin < 1.3


def test_the_cheapest_is_chosen_by_cost_and_not_by_steps() -> None:
    answer = recommended(PretendedRuns(second_order, per_iteration), position=1e-4)
    assert answer.candidate.case.settings.iterations == 10


@pytest.mark.parametrize(
    "outside",
    [
        lambda cell: cell.start_angle != 0.0,
        lambda cell: cell.revolutions != 2.0,
        lambda cell: cell.scene.speed < SAW.speed,
        lambda cell: cell.scene.speed > SAW.speed,
    ],
)
def test_setting_is_rejected_when_only_the_grid_allows_it(outside: Callable[[RunCase], bool]) -> None:
    """The planted defect: with ten iterations the error is a hundredfold wherever the grid did not look."""

    def error(cell: RunCase) -> float:
        lucky = cell.settings.as_dict()["iterations"] == 10 and outside(cell)
        return second_order(cell) * (100.0 if lucky else 1.0)

    answer = recommended(PretendedRuns(error, per_iteration), position=1e-4)
    assert answer.candidate.case.settings.iterations != 10
    assert {"10 iterations" in rejected.candidate.rule_plan.rule.name for rejected in answer.rejected} == {True}
    assert all(one.excess({"position": 1e-4}) <= 1.0 for one in answer.confirmations)
    assert len(answer.confirmations) == 5


def test_rule_is_tried_at_a_finer_step_after_a_rejection() -> None:
    """Errors a tenth larger outside the grid: what only just does is rejected, the step mended by as much is not."""

    def error(cell: RunCase) -> float:
        return 1e-4 / 1.05 * (200.0 / per_step(cell)) ** 2 * (1.1 if elsewhere(cell) else 1.0)

    # At 200 steps, where the table has the search begin, the error just does: no step between would save anything.
    answer = recommended(PretendedRuns(error, per_step), of_rules(1), position=1e-4)
    assert 200 < answer.candidate.steps < 240
    assert {rejected.candidate.steps for rejected in answer.rejected} == {200}
    assert recommended(PretendedRuns(lambda _: 1e-4, per_step), position=1e-4).rejected == ()  # just does everywhere


def test_a_confirming_run_that_does_not_complete_rejects_too() -> None:
    def error(cell: RunCase) -> float:
        return math.nan if cell.revolutions == 5.0 else second_order(cell)

    answer = recommended(PretendedRuns(error, per_step), position=1e-4)
    assert isinstance(answer, NoRecommendation)
    assert all(
        "exploded" in {one.result.outcome for one in rejected.failed_confirmations} for rejected in answer.rejected
    )


def test_an_error_that_is_no_number_is_within_nothing() -> None:
    found = TriedRun(RunResult("completed", errors={"C": {"position": {"max": 1e-9}, "velocity": {"max": math.nan}}}))
    assert found.excess({"position": 1e-6}) < 1.0
    assert found.excess({"position": 1e-6, "velocity": 1e-6}) == math.inf


# -- the next step to try ----------------------------------------------------------------------------------------------


def searching(found: Mapping[int, float | None], start: int = 0, order: float = 2.0) -> StepSearch:
    """A search of 20 to 20,000 steps with errors over what is allowed by steps; None where a run did not complete."""

    def at(steps: int) -> Any:
        return SimpleNamespace(settings=SimpleNamespace(steps_per_revolution=steps))

    rule: Any = SimpleNamespace(cases=[at(20), at(500), at(20000)])
    tried = [Candidate(measured(e and e * 1e-6), rule, at(n)) for n, e in found.items()]
    return StepSearch(rule, tried, start, order)


@pytest.mark.parametrize(
    ("search", "steps"),
    [
        # Nothing tried: the start, on the grid. Out: as many more as the order says, with a margin of 1.25.
        (searching({}, 101), 104), (searching({100: 2.0}), 160), (searching({100: 1e3}), 400),
        # The order between the two finest that completed; an error that stands still has no hope after three runs.
        (searching({50: 64.0, 100: 8.0, 200: 2.0}, order=1.0), 320), (searching({50: 2.0, 100: 2.0, 200: 2.0}), None),
        (searching({100: None, 200: 2.0}), 320), (searching({100: 2.0, 200: 2.0}), 800),
        (searching({100: None, 200: None}), None), (searching({20000: 2.0}), None),
        # Within, if only just: fewer, where that saves eight per cent, down to a fourth.
        (searching({1000: 0.6}), 868), (searching({1000: 0.7}), None), (searching({1000: 1.0}), None),
        (searching({1000: 0.05}), 252),
        # Between the last that is out and the first within; in the middle, where one has no error to go by.
        (searching({100: 4.0, 400: 0.25}), 224), (searching({100: None, 400: 0.25}), 200),
        (searching({100: 4.0, 400: 0.0}), 200), (searching({100: 0.65}), None),
    ],
)  # fmt: skip
def test_the_next_step_is_where_the_error_should_just_do(search: StepSearch, steps: int | None) -> None:
    assert search.next_steps({"position": 1e-6}) == steps


@pytest.mark.parametrize(
    ("tried", "error", "found", "ran"),
    [
        ((), 1.0, 1416, 1), ((), 1.5, None, 1),  # the error at 1416 decides
        ((1416,), 1.0, 1416, 0), ((1200, 1416), 0.5, 1200, 0), ((1200,), 1.5, None, 0),  # one that was run
        ((2000,), 0.5, 1416, 1), ((800,), 0.5, 1416, 1),
    ],
)  # fmt: skip
def test_the_finer_step_is_the_one_that_makes_up_for_the_excess(
    tried: tuple[int, ...], error: float, found: int | None, ran: int
) -> None:
    """At order 2 an excess of 1.6, with a margin of 1.25, takes 1.414 times the steps."""
    assert finer(tried, 1000, 1.6, error) == (found, ran)


@pytest.mark.parametrize(
    ("steps", "excess", "found", "ran"),
    [
        (1000, 100.0, 4000, 1),  # four times as many, though 11,180 were wanted
        (20000, 2.0, 31624, 1), (20000, 5.0, 50000, 1),  # up to 2.5 times the most of the grid
        (16000, 9.0, 20000, 1), (20000, 9.0, None, 0),  # no further than the grid where that would not do
    ],
)  # fmt: skip
def test_finer_step_leaves_the_grid_only_when_sufficient(
    steps: int, excess: float, found: int | None, ran: int
) -> None:
    assert finer((), steps, excess, 0.5) == (found, ran)


def finer(tried: tuple[int, ...], rejected: int, excess: float, error: float) -> tuple[int | None, int]:
    """The finer step of a rule that was tried at some, all with one error; and how many runs it takes."""
    runs = PretendedRuns(lambda _: error * 1e-6, per_step)
    search = StepSearch(grid_of_saw().rules[0], [])
    pursue([run_searches([(search, n) for n in (rejected, *tried)])], runs.run)
    choice, before = next(one for one in search.candidates if one.steps == rejected), len(runs.ran)
    (one,) = pursue([find_finer_candidate(search, choice, excess, {"position": 1e-6})], runs.run)
    return one and one.steps, len(runs.ran) - before


def test_a_pass_is_confirmed_backwards_and_at_other_speeds() -> None:
    geneva = scene_named("geneva")
    rule = plan_sweep("geneva", geneva, [PYMUNK], "coarse").rules[0]
    found = dict(confirming_cases(rule, rule.cases[-1]))
    assert list(found) == ["as pasted", "the pass backwards", "speed -10%", "speed +10%"]
    assert [c.scene.speed / geneva.speed for c in found.values()] == pytest.approx([1.0, -1.0, 0.9, 1.1])


def test_an_answer_says_all_that_it_rests_on() -> None:
    """Tuned errors are 40 / n², stock ones 2 / n, a revolution of n steps costs n."""
    runs = PretendedRuns(second_order, per_step)
    answer = recommended(runs, position=1e-4)
    assert answer.search_words.startswith("from the shipped sweeps of saw-500rpm, by ")
    assert answer.timing.ratio == answer.candidate.steps
    assert (answer.rounded_settings, answer.rejected) == (round_settings(SAW, answer.candidate.case.settings), ())
    assert f"space.step({answer.rounded_settings.timestep!r})" in answer.paste
    assert [one.change for one in answer.confirmations] == [
        "as pasted", "start at 37 deg", "five revolutions", "speed -10%", "speed +10%",
    ]  # fmt: skip
    (pasted,), settings = {c for c in runs.ran if c.settings == answer.rounded_settings}, answer.candidate.case.settings
    assert (pasted.start_angle, pasted.revolutions, pasted.scene.speed) == (0.0, 2.0, SAW.speed)
    outside = [
        (math.degrees(c.start_angle), c.revolutions, c.scene.speed / SAW.speed) for c in runs.ran if elsewhere(c)
    ]
    assert outside == [pytest.approx(one) for one in ((37, 2, 1), (0, 5, 1), (0, 2, 0.9), (0, 2, 1.1))]
    assert {c.settings.steps_per_revolution for c in runs.ran if elsewhere(c)} == {settings.steps_per_revolution}
    assert {c.name for c in runs.ran} == {"saw-500rpm"}


def test_nearest_candidate_and_excess_are_given_when_none_fits() -> None:
    answer = recommended(PretendedRuns(second_order, per_step), position=1e-3, acceleration=1e-9)
    assert answer.nearest.steps == 20000
    assert answer.nearest.excess({"acceleration": 1e-9}) == pytest.approx(40.0 / 20000**2 / 1e-9)
    assert answer.nearest.excess({"position": 1e-3}) < 1.0


@pytest.mark.parametrize(
    ("error", "timed", "why"),
    [
        (lambda _: math.nan, True, "no run completed: the loop is open"),
        (lambda _: 1e-3, True, ""),
        (lambda _: 1e-3, False, ""),
        (second_order, False, "nothing within the tolerances could be timed"),
    ],
)
def test_where_nothing_completes_or_can_be_timed_that_is_said(error: Any, timed: bool, why: str) -> None:
    runs: Any = PretendedRuns(error, per_step)
    if not timed:
        runs.time = lambda _: {}
    answer = recommended(runs, position=1e-4)
    assert isinstance(answer, NoRecommendation)
    assert (answer.engine, answer.reason) == ("pymunk", why)
    assert answer.search_words.startswith("from the shipped sweeps of saw-500rpm, by ")


def test_of_an_engine_that_cannot_be_timed_that_is_the_reason() -> None:
    plan, runs = grid_of_saw(), PretendedRuns(lambda _: 9e-5, per_step)
    untimed = replace(plan, rules=(replace(plan.rules[0], engine=PLANTED),))
    (answer,) = pursue(recommendation_studies(untimed, {"position": 1e-4}, lambda _: {}, shipped_sweeps()), runs.run)
    assert answer.reason == "planted has no stepping with nothing recorded, which timings take"
    assert answer.search_words == "from the shipped sweeps of no machine like it, by 1 run"


# -- from the shipped sweeps -------------------------------------------------------------------------------------------


def shifted(decibels: int, cost: float = 1.0) -> dict[str, Any]:
    """The shipped table with all errors and costs wrong by factors."""
    table = copy.deepcopy(shipped_sweeps())
    for engines in table.values():
        for rules in (rules for name, rules in engines.items() if name != "steps"):
            for row in rules.values():
                row[:] = row[0] * cost, *([None if e is None else e + decibels for e in errors] for errors in row[1:])
    return table


def test_the_shipped_table_is_that_of_the_committed_sweeps() -> None:
    data = Path(__file__).parents[2] / "reports" / "sweep" / "data"
    studies = [json.loads(path.read_text(encoding="utf-8")) for path in sorted(data.glob("*.json"))]
    assert table_of(studies) == shipped_sweeps()
    for study in studies:
        assert study["parameters"] == pytest.approx(SCENES[study["name"]].parameters, rel=1e-9)


@pytest.mark.parametrize("decibels", [-20, 20])
@pytest.mark.parametrize("cost", [0.01, 100.0])
def test_answer_keeps_tolerance_when_table_is_wrong_hundredfold(decibels: int, cost: float) -> None:
    """The planted defect: the answer still keeps the tolerance, and is as coarse as it can be."""
    answer = recommended(PretendedRuns(second_order, per_step), shifted(decibels, cost), position=1e-4)
    assert 1.0 <= answer.margin < 1.6
    assert all(one.excess({"position": 1e-4}) <= 1.0 for one in answer.confirmations)


def of_rules(count: int, order: int = 2, machines: tuple[str, ...] = ("shear-press", "saw-40rpm")) -> dict[str, Any]:
    """A table of some machines with the first rules of the saw's grid, which promises 1e-4 at 200 steps each."""
    rules = [rule.rule.name for rule in grid_of_saw().rules][:count]
    row = [1.0, *([-40 + order * 10, -40, -40 - order * 10],) * 3]
    return {name: {"steps": [20, 200, 2000], "pymunk": dict.fromkeys(rules, row)} for name in machines}


def test_a_search_begins_with_the_order_of_the_table() -> None:
    def tried(order: int) -> list[int]:
        runs = PretendedRuns(lambda c: 2e-4 if c.settings.steps_per_revolution == 200 else 9e-5, per_step)
        recommended(runs, of_rules(1, order), position=1e-4)
        return [c.settings.steps_per_revolution for c in runs.ran if not elsewhere(c)][:2]

    assert [tried(order) for order in (1, 2, 4)] == [[200, 504], [200, 320], [200, 252]]


def test_a_search_goes_on_in_waves_and_counts_them_all() -> None:
    """Seven rules are expected to do, of which none does elsewhere: six in the first wave, and one in the second."""
    runs = PretendedRuns(lambda c: 1e3 if elsewhere(c) else 9e-5, per_step)
    answer = recommended(runs, of_rules(7), position=1e-4)
    assert {one.candidate.rule_plan.rule.name for one in answer.rejected} == set(of_rules(7)["saw-40rpm"]["pymunk"])
    # Seven runs, and three finer ones for each rule of the first wave.
    assert answer.search_words == "from the shipped sweeps of shear-press, by 25 runs"
    assert (len(answer.rejected), answer.reason) == (7 + 3 * 7, "")


def test_a_search_names_all_machines_that_it_begins_from() -> None:
    press, saw = of_rules(1, machines=("shear-press",)), of_rules(2, machines=("saw-40rpm",))
    first = next(iter(press["shear-press"]["pymunk"]))
    saw["saw-40rpm"]["pymunk"].pop(first)
    answer = recommended(PretendedRuns(second_order, per_step), press | saw, position=1e-4)
    assert answer.search_words.startswith("from the shipped sweeps of shear-press and saw-40rpm, by ")


def test_numbers_to_paste_are_short_and_keep_a_pass_in_its_ends() -> None:
    tuned, driver = engine_named("mujoco").presets["tuned"], SimpleNamespace(span=(0.0, 1.0))
    one_pass: Any = SimpleNamespace(kinematics=SimpleNamespace(mechanism=SimpleNamespace(driver=driver)))
    for steps in range(76, 100):
        settings = tuned(SAW, steps)
        for machine in (SAW, one_pass):
            pasted = round_settings(machine, settings)
            assert len(f"{pasted.timestep!r}") <= len("0.00123456")
            assert pasted.timestep == pytest.approx(settings.timestep, rel=1e-5)
        assert pasted.timestep <= settings.timestep
    assert round_settings(SAW, tuned(SAW, 100)).timestep == 0.0012


@pytest.mark.parametrize("bad", [0.0, -1e-6, math.nan, math.inf, 1e-20, None])
def test_tolerance_is_refused_when_impossible_or_missing(bad: float | None) -> None:
    with pytest.raises(InvalidInput, match="^no tolerance: give at least one of" if bad is None else "^--position"):
        check_tolerances({"position": bad})
    assert check_tolerances({"position": 1e-6, "velocity": None}) == {"position": 1e-6}
