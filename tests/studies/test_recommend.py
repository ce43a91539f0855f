"""A recommendation is the cheapest setting within all tolerances that runs outside the grid confirm."""

from __future__ import annotations

import copy
import json
import math
from collections.abc import Callable, Mapping
from functools import cache
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from benchmarks.prior import table_of
from conrod.engines import engine_named
from conrod.engines.engine import shortened
from conrod.errors import InvalidInput
from conrod.scenes import SCENES
from conrod.studies.frame.case import QUANTITIES, Measurement, pursue
from conrod.studies.frame.run import RunCase
from conrod.studies.frame.timing import Timing
from conrod.studies.sweep.prior import shipped
from conrod.studies.sweep.recommend import Refusal, check_tolerances, recommend_for
from conrod.studies.sweep.step_search import Choice, StepSearch, Tried
from conrod.studies.sweep.study import SweepPlan, plan_sweep

SAW, PYMUNK = SCENES["saw-500rpm"], engine_named("pymunk")


class PretendedRuns:
    """Runs whose errors and costs are given by formulas of the cell."""

    def __init__(self, error: Callable[[RunCase], float], cost: Callable[[RunCase], float]) -> None:
        self.error, self.cost, self.ran = error, cost, list[RunCase]()

    def run(self, cells: list[RunCase]) -> dict[str, Measurement]:
        self.ran += cells
        return {cell.key: measured(self.error(cell)) for cell in cells}

    def time(self, cells: list[RunCase]) -> dict[str, Timing]:
        costs = {cell.key: self.cost(cell) for cell in cells}
        return {key: Timing(1e-6 * cost, 1e-6, cost, 1, 1, "m") for key, cost in costs.items()}


def measured(error: float | None) -> Measurement:
    """A run with an error in all quantities, or one that did not complete."""
    if error is None or math.isnan(error):
        return Measurement("exploded")
    return Measurement("completed", errors={"C": {quantity: {"max": error} for quantity in QUANTITIES}})


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
    table = shipped() if prior is None else prior
    (answer,) = pursue(recommend_for(grid_of_saw(), allowed, runs.time, table), runs.run)
    return answer


def test_the_coarsest_step_that_does_is_found_between_those_of_the_grid() -> None:
    answer = recommended(PretendedRuns(second_order, per_step), position=1e-4)
    # sqrt(40 / 1e-4) = 632 steps would just do; the error is aimed at 1.25 times below what is allowed.
    assert 708 <= answer.choice.steps <= 1.01 * 708
    assert 1.25 <= answer.margin < 1.3


def test_the_cheapest_is_chosen_by_cost_and_not_by_steps() -> None:
    answer = recommended(PretendedRuns(second_order, per_iteration), position=1e-4)
    assert answer.choice.case.settings.iterations == 10


@pytest.mark.parametrize(
    "outside",
    [
        lambda cell: cell.start_angle != 0.0,
        lambda cell: cell.revolutions != 2.0,
        lambda cell: cell.scene.speed < SAW.speed,
        lambda cell: cell.scene.speed > SAW.speed,
    ],
)
def test_a_setting_that_only_the_grid_allows_is_rejected_and_said_so(outside: Callable[[RunCase], bool]) -> None:
    """The planted defect: with ten iterations the error is a hundredfold wherever the grid did not look."""

    def error(cell: RunCase) -> float:
        lucky = cell.settings.as_dict()["iterations"] == 10 and outside(cell)
        return second_order(cell) * (100.0 if lucky else 1.0)

    answer = recommended(PretendedRuns(error, per_iteration), position=1e-4)
    assert answer.choice.case.settings.iterations != 10
    assert {"10 iterations" in rejected.choice.swept.rule.name for rejected in answer.rejected} == {True}
    assert all(one.excess({"position": 1e-4}) <= 1.0 for one in answer.confirmations)
    assert len(answer.confirmations) == 5


def test_after_a_rejection_the_same_rule_is_tried_at_a_finer_step() -> None:
    """Errors a tenth larger outside the grid: what only just does is rejected, the step mended by as much is not."""

    def error(cell: RunCase) -> float:
        return 1e-4 / 1.05 * (200.0 / per_step(cell)) ** 2 * (1.1 if elsewhere(cell) else 1.0)

    # At 200 steps, where the table has the search begin, the error just does: no step between would save anything.
    rule = grid_of_saw().rules[0].rule.name
    row = [1.0, *([-20, -40, -60],) * 3]
    table = {name: {"steps": [20, 200, 2000], "pymunk": {rule: row}} for name in ("shear-press", "saw-40rpm")}
    answer = recommended(PretendedRuns(error, per_step), table, position=1e-4)
    assert 200 < answer.choice.steps < 240
    assert {rejected.choice.steps for rejected in answer.rejected} == {200}
    assert recommended(PretendedRuns(lambda _: 1e-4, per_step), position=1e-4).rejected == ()  # just does everywhere


def test_a_confirming_run_that_does_not_complete_rejects_too() -> None:
    def error(cell: RunCase) -> float:
        return math.nan if cell.revolutions == 5.0 else second_order(cell)

    answer = recommended(PretendedRuns(error, per_step), position=1e-4)
    assert isinstance(answer, Refusal)
    assert all("exploded" in {one.measurement.outcome for one in rejected.why} for rejected in answer.rejected)


def test_an_error_that_is_no_number_is_within_nothing() -> None:
    found = Tried(Measurement("completed", errors={"C": {"position": {"max": 1e-9}, "velocity": {"max": math.nan}}}))
    assert found.excess({"position": 1e-6}) < 1.0
    assert found.excess({"position": 1e-6, "velocity": 1e-6}) == math.inf


# -- the next step to try ----------------------------------------------------------------------------------------------


def searching(found: Mapping[int, float | None], start: int = 0, order: float = 2.0) -> StepSearch:
    """A search of 20 to 20,000 steps with errors over what is allowed by steps; None where a run did not complete."""

    def at(steps: int) -> Any:
        return SimpleNamespace(settings=SimpleNamespace(steps_per_revolution=steps))

    rule: Any = SimpleNamespace(cases=[at(20), at(500), at(20000)])
    tried = [Choice(measured(e and e * 1e-6), rule, at(n)) for n, e in found.items()]
    return StepSearch(rule, tried, start, order)


@pytest.mark.parametrize(
    ("search", "steps"),
    [
        # Nothing tried: the start, on the grid. Out: as many more as the order says, with a margin of 1.25.
        (searching({}, 101), 104), (searching({100: 2.0}), 160), (searching({100: 1e3}), 400),
        # The order between the two finest that completed; an error that stands still has no hope after three runs.
        (searching({50: 64.0, 100: 8.0, 200: 2.0}, order=1.0), 320), (searching({50: 2.0, 100: 2.0, 200: 2.0}), None),
        (searching({100: None, 200: None}), None), (searching({20000: 2.0}), None),
        # Within: fewer, where that saves eight per cent; or between the last that is out and the first within.
        (searching({1000: 0.6}), 868), (searching({1000: 0.7}), None), (searching({100: 4.0, 400: 0.25}), 224),
    ],
)  # fmt: skip
def test_the_next_step_is_where_the_error_should_just_do(search: StepSearch, steps: int | None) -> None:
    assert search.next_steps({"position": 1e-6}) == steps


def test_an_answer_says_all_that_it_rests_on() -> None:
    """Tuned errors are 40 / n², stock ones 2 / n, a revolution of n steps costs n."""
    runs = PretendedRuns(second_order, per_step)
    answer = recommended(runs, position=1e-4)
    assert answer.how.startswith("from the shipped sweeps of saw-500rpm, by ")
    assert answer.timing.ratio == answer.choice.steps
    assert (answer.pasted, answer.rejected) == (shortened(SAW, answer.choice.case.settings), ())
    assert f"space.step({answer.pasted.timestep!r})" in answer.paste
    assert [one.what for one in answer.confirmations] == [
        "as pasted", "start at 37 deg", "five revolutions", "speed -10%", "speed +10%",
    ]  # fmt: skip
    (pasted,), settings = {c for c in runs.ran if c.settings == answer.pasted}, answer.choice.case.settings
    assert (pasted.start_angle, pasted.revolutions, pasted.scene.speed) == (0.0, 2.0, SAW.speed)
    outside = [
        (math.degrees(c.start_angle), c.revolutions, c.scene.speed / SAW.speed) for c in runs.ran if elsewhere(c)
    ]
    assert outside == [pytest.approx(one) for one in ((37, 2, 1), (0, 5, 1), (0, 2, 0.9), (0, 2, 1.1))]
    assert {c.settings.steps_per_revolution for c in runs.ran if elsewhere(c)} == {settings.steps_per_revolution}
    assert {c.name for c in runs.ran} == {"saw-500rpm"}


def test_where_nothing_qualifies_the_nearest_and_how_far_it_is_out_is_said() -> None:
    answer = recommended(PretendedRuns(second_order, per_step), position=1e-3, acceleration=1e-9)
    assert answer.nearest.steps == 20000
    assert answer.nearest.excess({"acceleration": 1e-9}) == pytest.approx(40.0 / 20000**2 / 1e-9)
    assert answer.nearest.excess({"position": 1e-3}) < 1.0


# -- from the shipped sweeps -------------------------------------------------------------------------------------------


def shifted(decibels: int, cost: float = 1.0) -> dict[str, Any]:
    """The shipped table with all errors and costs wrong by factors."""
    table = copy.deepcopy(shipped())
    for engines in table.values():
        for rules in (rules for name, rules in engines.items() if name != "steps"):
            for row in rules.values():
                row[:] = row[0] * cost, *([None if e is None else e + decibels for e in errors] for errors in row[1:])
    return table


def test_the_shipped_table_is_that_of_the_committed_sweeps() -> None:
    data = Path(__file__).parents[2] / "reports" / "sweep" / "data"
    studies = [json.loads(path.read_text(encoding="utf-8")) for path in sorted(data.glob("*.json"))]
    assert table_of(studies) == shipped()
    for study in studies:
        assert study["parameters"] == pytest.approx(SCENES[study["name"]].parameters, rel=1e-9)


@pytest.mark.parametrize("decibels", [-20, 20])
@pytest.mark.parametrize("cost", [0.01, 100.0])
def test_a_table_that_is_wrong_by_a_hundredfold_breaks_no_promise(decibels: int, cost: float) -> None:
    """The planted defect: the answer still keeps the tolerance, and is as coarse as it can be."""
    answer = recommended(PretendedRuns(second_order, per_step), shifted(decibels, cost), position=1e-4)
    assert 1.0 <= answer.margin < 1.6
    assert all(one.excess({"position": 1e-4}) <= 1.0 for one in answer.confirmations)


def test_numbers_to_paste_are_short_and_a_pass_does_not_go_beyond_its_end() -> None:
    tuned, driver = engine_named("mujoco").presets["tuned"], SimpleNamespace(span=(0.0, 1.0))
    one_pass: Any = SimpleNamespace(kinematics=SimpleNamespace(mechanism=SimpleNamespace(driver=driver)))
    for steps in range(76, 100):
        settings = tuned(SAW, steps)
        for machine in (SAW, one_pass):
            pasted = shortened(machine, settings)
            assert len(f"{pasted.timestep!r}") <= len("0.00123456")
            assert pasted.timestep == pytest.approx(settings.timestep, rel=1e-5)
        assert pasted.timestep <= settings.timestep
    assert shortened(SAW, tuned(SAW, 100)).timestep == 0.0012


@pytest.mark.parametrize("bad", [0.0, -1e-6, math.nan, math.inf, 1e-20, None])
def test_a_tolerance_that_nothing_can_meet_is_refused_and_one_is_needed(bad: float | None) -> None:
    with pytest.raises(InvalidInput, match="^no tolerance: give at least one of" if bad is None else "^--position"):
        check_tolerances({"position": bad})
    assert check_tolerances({"position": 1e-6, "velocity": None}) == {"position": 1e-6}
