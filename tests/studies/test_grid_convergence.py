"""What a self-convergence study says, against what is known to be true; orders along declared paths."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from measured import FAILED, errors_by_step

from conrod.engines import ENGINES, engine_named
from conrod.engines.mujoco.settings import INTEGRATORS, MuJoCoSettings
from conrod.engines.pymunk.settings import PymunkSettings
from conrod.errors import InvalidInput
from conrod.runs.convergence import observed_order
from conrod.scenes import SCENES
from conrod.studies.frame.measurement import QUANTITIES
from conrod.studies.frame.run import measure
from conrod.studies.sweep.grid_convergence import (
    SAFE,
    UNSAFE,
    GridConvergence,
    bands,
    grid_convergence_of,
    observed_order_of_three,
    varying_components,
)
from conrod.studies.sweep.study import orders_along
from conrod.studies.validation.refinement import GRIDS, PATHS, Family, Path, family_of, refined

SAW, PRESS, CAM = SCENES["saw-500rpm"], SCENES["shear-press"], SCENES["cam-follower"]
RK4 = replace(MuJoCoSettings.stock(SAW, 1000), integrator="RK4")
STEPS = (20, 40, 100, 200, 400)
Size = Callable[[float], float]


def family(steps: tuple[int, ...] = STEPS, settings: MuJoCoSettings = RK4) -> Family:
    return family_of("saw-500rpm", SAW, settings, "step alone", steps)


def found_for(size: Size, steps: tuple[int, ...] = STEPS) -> GridConvergence:
    made = family(steps)
    runs = {cell.key: errors_by_step(SAW, size, cell.settings.steps_per_revolution) for cell in made.cells}
    return grid_convergence_of(made, runs)


# -- the order that three grids show ---------------------------------------------------------------------------------


@pytest.mark.parametrize("order", [-1.3, 0.4, 1.0, 2.0, 4.0, 7.5])
@pytest.mark.parametrize(("r21", "r32"), [(2.0, 2.0), (2.0, 2.5), (2.5, 2.0), (2.0, 10.0), (10.0, 2.0), (1.3, 1.1)])
def test_the_order_of_a_power_of_the_step_is_found_at_any_ratios(order: float, r21: float, r32: float) -> None:
    fine, middle, coarse = 1.0, r21**order, (r21 * r32) ** order
    found = observed_order_of_three(np.array([middle - fine]), np.array([coarse - middle]), r21, r32)
    assert found[0] == pytest.approx(order, abs=1e-6)


def test_the_order_agrees_with_the_published_fixed_point_iteration() -> None:
    # Celik et al. (2008), Table 1, first column: r21 = 1.5, r32 = 1.333, f = 6.063, 5.972, 5.863; they print p = 1.53
    # and a fine-grid index of 2.2 %.
    d21, d32 = np.array([5.972 - 6.063]), np.array([5.863 - 5.972])
    order = float(observed_order_of_three(d21, d32, 1.5, 1.333)[0])
    assert order == pytest.approx(1.53, abs=0.01)
    assert 1.25 * abs(d21[0] / 6.063) / (1.5**order - 1.0) == pytest.approx(0.022, abs=0.0005)


@pytest.mark.parametrize("order", [0.7, 2.0])
@pytest.mark.parametrize("r32", [2.0, 2.5])
def test_the_order_of_an_oscillating_sequence_solves_the_published_equation(order: float, r32: float) -> None:
    # Equation (3) with s = -1.
    ratio = 2.0**order * (r32**order + 1.0) / (2.0**order + 1.0)
    found = observed_order_of_three(np.array([-1e-3]), np.array([1e-3 * ratio]), 2.0, r32)
    assert found[0] == pytest.approx(order, abs=1e-6)


def test_grids_that_agree_to_the_last_digit_have_no_order() -> None:
    none, some = np.zeros(1), np.ones(1)
    assert math.isnan(observed_order_of_three(none, none, 2.0, 2.0)[0])
    assert observed_order_of_three(none, some, 2.0, 2.0)[0] > 20.0
    assert observed_order_of_three(some, none, 2.0, 2.0)[0] < -20.0


# -- the band --------------------------------------------------------------------------------------------------------


def one(fine: float, middle: float, coarse: float, formal: float = 2.0, rounding: float = 1e-13) -> tuple[float, bool]:
    found = bands(*(np.array([x]) for x in (fine, middle, coarse)), 2.0, 2.0, formal, rounding)
    return float(found.band[0]), bool(found.unreasonable[0])


def test_a_reasonable_order_gives_the_band_of_safety_factor_one_and_a_quarter() -> None:
    assert one(1e-3, 4e-3, 16e-3) == (pytest.approx(SAFE * 1e-3), False)


@pytest.mark.parametrize(
    ("values", "order"),
    [
        ((1e-3, 8e-3, 64e-3), 2.0),  # order 3 of a scheme of order 2
        ((1e-3, 1.2e-3, 1.44e-3), 0.5),  # order 0.26
        ((1e-3, 3e-3, 4e-3), 0.5),  # differences that grow
        ((1e-3, 2e-3, -2e-3), 2.0),  # oscillates, with order 2 by equation (3)
    ],
    ids=["too high", "too low", "diverging", "oscillating"],
)
def test_an_unreasonable_order_gives_safety_factor_three_and_a_clipped_order(
    values: tuple[float, float, float], order: float
) -> None:
    expected = UNSAFE * abs(values[1] - values[0]) / (2.0**order - 1.0)
    assert one(*values) == (pytest.approx(expected, rel=1e-6), True)


def test_an_order_a_little_above_the_formal_one_is_reasonable_but_not_used() -> None:
    step = 2.0**2.3
    assert one(1e-3, step * 1e-3, step**2 * 1e-3) == (pytest.approx(SAFE * (step - 1.0) * 1e-3 / 3.0), False)


def test_grids_that_agree_about_a_wrong_value_are_missed_and_no_tie() -> None:
    found = bands(*(np.array([0.04]) for _ in range(3)), 2.0, 2.0, 2.0, 1e-13).share()
    assert (found.contained, found.missed, found.at_rounding) == (0, 1, 0)


def test_a_true_error_at_rounding_is_neither_contained_nor_missed() -> None:
    found = bands(np.array([1e-15]), np.array([3e-14]), np.array([-2e-14]), 2.0, 2.0, 2.0, 1e-13).share()
    assert (found.contained, found.missed, found.at_rounding) == (0, 0, 1)
    assert found.share is None
    assert found.ratio is None


# -- shares over a family --------------------------------------------------------------------------------------------


@pytest.mark.parametrize("order", [1.0, 2.0, 4.0])
def test_an_error_that_is_a_power_of_the_step_is_always_contained(order: float) -> None:
    found = found_for(lambda h: 1e-2 * h**order)
    for share in found.shares.values():
        assert share.share == 1.0
        assert share.unreasonable == 0
        assert share.ratio == pytest.approx(SAFE, rel=1e-6)


def test_a_plateau_that_the_step_does_not_move_is_never_contained() -> None:
    # Negative control, and what a soft engine does: it converges well, to the wrong motion.
    found = found_for(lambda h: 3.8e-2 + 1e-3 * h**4)
    for share in found.shares.values():
        assert share.share == 0.0
        assert share.unreasonable == 0, "nothing in the observed order gives it away"
        assert share.ratio is not None
        assert share.ratio < 1e-2


def test_a_plateau_is_missed_only_where_it_is_larger_than_what_still_falls() -> None:
    def share(steps: tuple[int, ...]) -> float | None:
        return found_for(lambda h: 1e-5 + 1e-2 * h**2, steps).shares["position"].share

    assert share(GRIDS[:3]) == 1.0
    assert share(GRIDS[-3:]) == 0.0


def test_counts_cover_every_varying_component_of_every_point_at_every_angle() -> None:
    found = found_for(lambda h: h)
    assert varying_components(SAW) == {"C": (True, False), "M": (True, True)}
    triples = len(STEPS) - 2
    for share in found.shares.values():
        assert share.contained + share.missed + share.at_rounding == triples * 3 * 20


def test_only_components_that_the_exact_motion_changes_are_looked_at() -> None:
    assert varying_components(PRESS) == {"A": (False, True), "G": (True, True)}
    assert varying_components(CAM) == {"roller": (False, True)}


def test_a_grid_that_failed_is_listed_and_its_triples_are_missing() -> None:
    made = family()
    runs = {cell.key: errors_by_step(SAW, lambda h: h, cell.settings.steps_per_revolution) for cell in made.cells}
    runs[made.cells[0].key] = FAILED
    found = grid_convergence_of(made, runs)
    assert found.failed == ((20, "exploded"),)
    assert found.shares["position"].judged == 2 * 3 * 20  # of steps 40 to 200, and 100 to 400
    runs[made.cells[2].key] = FAILED
    assert grid_convergence_of(made, runs).shares == {}


def test_formal_orders_are_those_of_the_integrators() -> None:
    mujoco, pymunk = (engine_named(name).variations for name in ("mujoco", "pymunk"))
    assert mujoco.formal_order(RK4) == 4.0
    assert all(mujoco.formal_order(replace(RK4, integrator=i)) == 1.0 for i in INTEGRATORS if i != "RK4")
    assert pymunk.formal_order(PymunkSettings.stock(SAW, 100)) == 2.0


# -- paths -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("settings", [MuJoCoSettings.tuned(SAW, 1000), PymunkSettings.stock(SAW, 1000)])
def test_the_step_alone_changes_nothing_but_the_step(settings: MuJoCoSettings | PymunkSettings) -> None:
    coarse, fine = (refined(SAW, settings, n, "step alone").as_dict().items() for n in (1000, 4000))
    assert {name for name, _ in coarse ^ fine} == {"steps_per_revolution", "timestep"}


def test_softness_in_steps_keeps_its_steps() -> None:
    fine = refined(SAW, MuJoCoSettings.tuned(SAW, 1000), 4000, "step with softness")
    # The same run as the preset at that step: its time constant is eight steps.
    assert replace(fine, preset="tuned") == MuJoCoSettings.tuned(SAW, 4000)
    bias = refined(SAW, PymunkSettings.stock(SAW, 1000), 4000, "step with softness")
    stock = PymunkSettings.stock(SAW, 1000)
    assert isinstance(bias, PymunkSettings)
    assert bias.error_bias**bias.timestep == pytest.approx(stock.error_bias**stock.timestep)


@pytest.mark.parametrize("path", PATHS)
@pytest.mark.parametrize("engine", ENGINES)
def test_refining_to_the_same_step_changes_nothing(engine: str, path: Path) -> None:
    for preset in engine_named(engine).presets.values():
        settings = preset(SAW, 1000)
        assert replace(refined(SAW, settings, 1000, path), preset=settings.preset) == settings


@pytest.mark.parametrize("steps", [(40, 20), (20, 20), (30, 60), (0, 20)])
def test_steps_without_samples_at_the_kept_angles_are_refused(steps: tuple[int, ...]) -> None:
    with pytest.raises(InvalidInput, match="multiples of 20"):
        family(steps)


# -- orders along a path ---------------------------------------------------------------------------------------------


def test_order_plateau_and_floor_are_told_apart() -> None:
    steps = [20, 40, 80, 160, 320, 640]
    falling, stopped = (observed_order(steps, [rest + n**-2.0 for n in steps]) for rest in (0.0, 0.04))
    assert (falling.claimed, falling.plateau) == (pytest.approx(2.0), None)
    assert (stopped.claimed, stopped.plateau) == (None, pytest.approx(0.04, rel=1e-3))
    assert stopped.floor == pytest.approx(0.04, rel=1e-2)
    # A rounding floor that grows again is no plateau.
    assert observed_order(steps, [1e-5, 6e-7, 4e-8, 2e-12, 4e-12, 8e-12]).plateau is None


def test_the_order_is_that_of_the_runs_that_completed() -> None:
    made = family()
    runs = {cell.key: errors_by_step(SAW, lambda h: h**2, cell.settings.steps_per_revolution) for cell in made.cells}
    runs[made.cells[1].key] = FAILED
    assert orders_along(made, runs)["position"].claimed == pytest.approx(2.0)
    assert len(orders_along(made, runs)["position"].pairs) == len(STEPS) - 2


# -- real engines ----------------------------------------------------------------------------------------------------


def run_family(made: Family) -> GridConvergence:
    return grid_convergence_of(made, {cell.key: measure(cell) for cell in made.cells})


def test_self_convergence_never_notices_the_softness_of_stock_mujoco_under_rk4() -> None:
    found = run_family(family((100, 200, 400)))
    assert all(found.shares[q].share == 0.0 for q in QUANTITIES)
    assert all((found.shares[q].ratio or 1.0) < 1e-5 for q in QUANTITIES)


def test_self_convergence_is_right_about_hardened_mujoco() -> None:
    found = run_family(family((100, 200, 400), MuJoCoSettings.hardened(SAW, 1000)))
    assert all((found.shares[q].share or 0.0) >= 0.95 for q in QUANTITIES)


@pytest.mark.parametrize("preset", [PymunkSettings.stock, PymunkSettings.tuned])
def test_self_convergence_is_right_about_pymunk(preset: Callable[..., PymunkSettings]) -> None:
    found = run_family(family_of("saw-500rpm", SAW, preset(SAW, 1000), "step alone", (200, 400, 1000)))
    assert all((found.shares[q].share or 0.0) >= 0.95 for q in QUANTITIES)


@pytest.mark.slow
def test_softness_that_follows_the_step_hides_an_acceleration_that_does_not_converge() -> None:
    made = family_of("saw-500rpm", SAW, MuJoCoSettings.tuned(SAW, 1000), PATHS[1])
    runs = {cell.key: measure(cell) for cell in made.cells}
    orders = orders_along(made, runs)
    found = grid_convergence_of(replace(made, cells=made.cells[-3:]), runs)
    assert orders["position"].claimed == pytest.approx(2.0, abs=0.05)
    assert orders["acceleration"].plateau is not None
    assert (found.shares["position"].share or 0.0) > 0.95
    assert found.shares["acceleration"].share == 0.0
