"""The bound on what RK4's local errors leave of one pass."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from conrod.engines import engine_named
from conrod.engines.engine import run_of
from conrod.engines.mujoco.law import largest_errors
from conrod.engines.mujoco.settings import MuJoCoSettings
from conrod.engines.running import whole_run
from conrod.exact.motion import Array
from conrod.runs.comparison import compare
from conrod.scenes.catalogue import catalogue_scene

STEPS, SPACING, CONSTANT = 4000, 2.5e-4, 0.1
TIMES = SPACING * np.arange(STEPS + 1)
DEFECTS = {
    "steady": (np.ones(STEPS + 1), 3.0 * np.ones(STEPS + 1)),
    "gone soon": (np.exp(-TIMES / 0.01), -40.0 * np.exp(-TIMES / 0.02)),
    "to and fro": (np.sin(50.0 * TIMES), np.cos(80.0 * TIMES)),
}


def followed(steady: Array, growing: Array) -> tuple[float, float, float]:
    """Largest y, z and z' of y' = z + e, z' = -2 z/c - y/c^2 + f, by the trapezoidal rule."""
    matrix = np.array([[0.0, 1.0], [-1.0 / CONSTANT**2, -2.0 / CONSTANT]])
    before, after = np.eye(2) + 0.5 * SPACING * matrix, np.linalg.inv(np.eye(2) - 0.5 * SPACING * matrix)
    defects = np.column_stack([steady, growing])
    states = [np.zeros(2)]
    for first, second in pairwise(defects):
        states.append(after @ (before @ states[-1] + 0.5 * SPACING * (first + second)))
    y, z = np.array(states).T
    rates = -2.0 * z / CONSTANT - y / CONSTANT**2 + growing
    largest = [float(np.abs(values).max()) for values in (y, z, rates)]
    return largest[0], largest[1], largest[2]


@pytest.mark.parametrize("name", DEFECTS)
def test_no_closure_is_off_by_more_than_its_defects_folded(name: str) -> None:
    steady, growing = DEFECTS[name]
    bounds = largest_errors(np.abs(steady), np.abs(growing), SPACING, CONSTANT)
    found = followed(steady, growing)
    assert all(error <= bound for error, bound in zip(found, bounds, strict=True))
    # Negative control: defects half as large would not do, where they do not change their sign.
    if name == "steady":
        assert found[0] > 0.99 * bounds[0] > largest_errors(0.5 * steady, 0.5 * growing, SPACING, CONSTANT)[0]


def test_steady_defects_leave_two_time_constants_of_the_one_and_its_square_of_the_other() -> None:
    position, _, _ = largest_errors(*DEFECTS["steady"], SPACING, CONSTANT)
    assert position == pytest.approx(2.0 * CONSTANT + 3.0 * CONSTANT**2, rel=0.01)


@pytest.mark.parametrize("machine", ["rack-and-wheel", "swinging-four-bar", "two-slider-linkage"])
def test_a_pass_stays_within_a_bound_that_tells_something(machine: str) -> None:
    scene, mujoco = catalogue_scene(machine), engine_named("mujoco")
    start, revolutions = run_of(scene, 1000, 1.0)
    settings = MuJoCoSettings.hardened(scene, 1000)
    law = mujoco.expected_error(scene, settings)
    hardened, stock = (
        compare(whole_run(mujoco, scene, some, revolutions, start), scene)
        for some in (settings, MuJoCoSettings.stock(scene, 1000))
    )
    for quantity in ("position", "velocity", "acceleration"):
        bound = getattr(law, quantity)
        assert hardened.worst(quantity) < bound < 1e-3
        # Negative control: what exceeds the law is seen to.
        assert stock.worst(quantity) > bound
