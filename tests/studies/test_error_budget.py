"""Error budgets: planted causes are found in the part that they belong to, and the parts sum to the whole."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from measured import FAILED, measured, shape_of

from conrod.engines.mujoco.settings import STOCK_SOLIMP, MuJoCoSettings
from conrod.engines.pymunk.settings import STOCK_BIAS, PymunkSettings
from conrod.errors import InvalidInput
from conrod.exact.motion import Array
from conrod.runs.trajectory import Settings
from conrod.scenes import SCENES
from conrod.studies.frame.measurement import QUANTITIES, Measurement
from conrod.studies.frame.run import measure
from conrod.studies.sweep.error_budget import (
    AS_IS,
    BUDGET_ANGLES,
    CONVERGED,
    FINER,
    FINEST,
    ITERATION,
    MODEL,
    REGULARISATION,
    STABILISATION,
    STEP,
    TOTAL,
    TWICE,
    BudgetPlan,
    ErrorBudget,
    budget_of,
    budget_plan_of,
    combined,
)

SAW, CAM = SCENES["saw-500rpm"], SCENES["cam-follower"]
PARTS = (ITERATION, STEP, MODEL)
TUNED = PymunkSettings.tuned(SAW, 100)
SOFT = MuJoCoSettings.tuned(SAW, 100)


def plan_of(settings: Settings, fineness: int = 16) -> BudgetPlan:
    return budget_plan_of("saw-500rpm", SAW, settings, fineness)


def made_up(plan: BudgetPlan, sizes: Mapping[str, float]) -> dict[str, Measurement]:
    """Runs whose errors are the sum, over the roles' sizes, of vectors that belong to each cause."""
    return {cell.key: measured(vectors(sizes.get(role, 0.0), cell.key)) for role, cell in plan.cases.items()}


def vectors(size: float, seed: str) -> dict[str, Array]:
    return {n: size * v for n, v in shape_of(SAW, BUDGET_ANGLES, seed=int(seed[:8], 16)).items()}


@cache
def runs_of(settings: Settings, fineness: int) -> Mapping[str, Measurement]:
    """The runs of a budget, which several tests judge."""
    return {cell.key: measure(cell) for cell in plan_of(settings, fineness).cases.values()}


@cache
def run_budget(settings: Settings, fineness: int = 4) -> ErrorBudget:
    return budget_of(plan_of(settings, fineness), dict(runs_of(settings, fineness)))


def sizes_of(budget: ErrorBudget, quantity: str = "position") -> dict[str, float]:
    norms = {part.name: part.norms for part in budget.parts}
    return {name: found[quantity].max for name, found in norms.items() if found is not None}


def largest_part(budget: ErrorBudget, quantity: str = "position") -> str:
    sizes = sizes_of(budget, quantity)
    return max(PARTS, key=lambda name: sizes[name])


# -- the plan --------------------------------------------------------------------------------------------------------


def test_each_run_varies_one_thing_alone() -> None:
    cells = plan_of(SOFT).cases
    changed = {
        role: {
            k
            for k, v in cell.settings.as_dict().items()
            if v != cells[CONVERGED].settings.as_dict()[k] and k != "preset"
        }
        for role, cell in cells.items()
    }
    step = {"steps_per_revolution", "timestep"}
    assert changed[AS_IS] == changed[TWICE] == {"iterations"}
    assert changed[FINER] == changed[FINEST] == step
    assert changed[REGULARISATION] == {"hardening"}
    assert changed[STABILISATION] == {"solref"}
    assert changed[f"{STABILISATION} finest"] == {"solref"} | step


@pytest.mark.parametrize(
    ("settings", "knob", "change"),
    [
        (PymunkSettings.stock(SAW, 200), STABILISATION, {"error_bias": (STOCK_BIAS, 0.0)}),
        # A time constant that cannot be halved is doubled.
        (
            replace(SOFT, solref=(2.0 * SOFT.timestep, 1.0)),
            STABILISATION,
            {"solref": ([2.0 * SOFT.timestep, 1.0], [4.0 * SOFT.timestep, 1.0])},
        ),
        # Stiffness and damping given directly are varied as the same time constant.
        (replace(SOFT, solref=(-1e6, -2e3)), STABILISATION, {"solref": ([-1e6, -2e3], [-4e6, -4e3])}),
    ],
)
def test_a_knob_is_varied_as_far_as_the_engine_admits(settings: Settings, knob: str, change: object) -> None:
    assert plan_of(settings).changes[knob] == change
    # Joints of pymunk are not regularised.
    assert (REGULARISATION in plan_of(settings).changes) == (settings.engine == "mujoco")


@pytest.mark.parametrize(
    ("settings", "knob", "field"),
    [
        (MuJoCoSettings.tuned(CAM, 1000), REGULARISATION, "contact_solimp"),
        (MuJoCoSettings.tuned(CAM, 1000), STABILISATION, "contact_solref"),
        (PymunkSettings.tuned(CAM, 1000), REGULARISATION, "collision_slop"),
    ],
)
def test_contact_is_not_hardened_but_stiffened(settings: Settings, knob: str, field: str) -> None:
    assert set(budget_plan_of("cam", CAM, settings).changes[knob]) == {field}


@pytest.mark.parametrize(("steps", "fineness", "wrong"), [(120, 16, "multiple of 100"), (200, 3, "even number")])
def test_plans_without_common_angles_are_refused(steps: int, fineness: int, wrong: str) -> None:
    with pytest.raises(InvalidInput, match=wrong):
        plan_of(PymunkSettings.stock(SAW, steps), fineness)


# -- the sums --------------------------------------------------------------------------------------------------------


def test_signed_parts_sum_to_the_signed_error_at_every_angle() -> None:
    plan = plan_of(SOFT)
    measurements = made_up(plan, {AS_IS: 1e-3, CONVERGED: 3.0, FINEST: 1e-7, FINER: 2e-7})
    runs = {role: measurements[cell.key] for role, cell in plan.cases.items()}
    parts = [combined(plan, runs, w) for w in ({AS_IS: 1, CONVERGED: -1}, {CONVERGED: 1, FINEST: -1}, {FINEST: 1})]
    total = combined(plan, runs, {AS_IS: 1})
    for quantity in QUANTITIES:
        for point in SAW.lengths:
            off = sum(part[quantity][point] for part in parts) - total[quantity][point]
            assert np.abs(off).max() <= 1e-15 * 3.0
    budget_of(plan, measurements)


def test_norms_are_not_summands_where_parts_point_against_each_other() -> None:
    plan = plan_of(SOFT)
    same = shape_of(SAW, BUDGET_ANGLES)
    factors = {AS_IS: 0.0, CONVERGED: 0.0, TWICE: 0.0}
    runs = {
        cell.key: measured({n: factors.get(role, 1.0) * v for n, v in same.items()})
        for role, cell in plan.cases.items()
    }
    found = sizes_of(budget_of(plan, runs))
    assert found[TOTAL] == 0.0
    assert found[STEP] == found[MODEL] > 0.1


def test_a_part_no_larger_than_the_last_doubling_is_not_resolved() -> None:
    plan = plan_of(TUNED)
    shape = shape_of(SAW, BUDGET_ANGLES)
    # An error that is the step's alone, of order 1: what is left at the finest step looks like a model's.
    runs = {
        cell.key: measured({n: 100.0 / cell.settings.steps_per_revolution * v for n, v in shape.items()})
        for cell in plan.cases.values()
    }
    budget = budget_of(plan, runs)
    model, step = budget.part(MODEL).norms, budget.part(STEP).norms
    assert model is not None
    assert step is not None
    assert not model["position"].resolved
    assert step["position"].resolved
    assert (step["position"].known_to or 0.0) > 0.01 * step["position"].max


def test_a_run_that_failed_leaves_its_parts_out_and_says_so() -> None:
    plan = plan_of(TUNED)
    runs = made_up(plan, dict.fromkeys(plan.cases, 1.0)) | {plan.cases[FINEST].key: FAILED}
    budget = budget_of(plan, runs)
    assert budget.part(ITERATION).norms is not None
    assert budget.part(MODEL).norms is None
    assert budget.part(MODEL).missing == {FINEST: "exploded"}


# -- causes ----------------------------------------------------------------------------------------------------------


def test_too_few_iterations_grow_the_iterations_part_alone() -> None:
    right, planted = run_budget(TUNED, 2), run_budget(replace(TUNED, iterations=20), 2)
    assert sizes_of(right)[ITERATION] < 1e-6 * sizes_of(planted)[ITERATION]
    for part in (STEP, MODEL):
        assert sizes_of(planted)[part] == pytest.approx(sizes_of(right)[part], rel=1e-6)
    iteration = planted.part(ITERATION).norms
    assert iteration is not None
    assert (iteration["position"].known_to or 0.0) < 0.01 * iteration["position"].max


@pytest.mark.parametrize(("solver", "iterations"), [("PGS", 10), pytest.param("CG", 1, marks=pytest.mark.slow)])
def test_a_solver_that_stops_early_grows_the_iterations_part_alone(solver: str, iterations: int) -> None:
    right, planted = run_budget(SOFT, 2), run_budget(replace(SOFT, solver=solver, iterations=iterations), 2)
    assert sizes_of(right)[ITERATION] < 1e-12
    assert largest_part(planted) == ITERATION
    assert sizes_of(planted)[MODEL] == sizes_of(right)[MODEL]


def test_a_coarse_step_grows_the_steps_part() -> None:
    right, planted = (run_budget(MuJoCoSettings.hardened(SAW, steps)) for steps in (300, 100))
    assert sizes_of(planted)[STEP] > 50.0 * sizes_of(right)[STEP]
    assert largest_part(planted) == STEP


@pytest.mark.parametrize(
    "planted", [{"solref": (0.01, 1.0)}, pytest.param({"solimp": STOCK_SOLIMP}, marks=pytest.mark.slow)]
)
def test_softness_grows_the_models_part(planted: Mapping[str, tuple[float, ...]]) -> None:
    # At most two steps' time constant would be MuJoCo's own choice and not the one that is planted.
    right = replace(SOFT, solref=(0.0024, 1.0))
    before, after = run_budget(right, 2), run_budget(replace(right, **planted), 2)
    assert largest_part(after) == MODEL
    assert sizes_of(after)[MODEL] > 10.0 * sizes_of(before)[MODEL]
    # Without regularisation, or without what it multiplies, all of it goes.
    knob = sizes_of(after)[f"{REGULARISATION}, no step"]
    assert knob == pytest.approx(sizes_of(after)[MODEL], rel=0.05)
