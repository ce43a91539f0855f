"""pymunk's iterations, by theory: what one of them does, and how many are enough wherever a run begins."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from benchmarks.healthy import variant
from conrod.engines import engine_named
from conrod.engines.numerics import by_centres, inverse_masses, one_iteration
from conrod.engines.pymunk import settings as iteration
from conrod.engines.pymunk.settings import PymunkSettings, iterations_by_masses
from conrod.engines.pymunk.space import build
from conrod.engines.pymunk.stepping import state
from conrod.engines.running import whole_run
from conrod.runs.comparison import compare
from conrod.scenes import SCENES
from conrod.scenes.catalogue import catalogue_scene

PYMUNK: Any = engine_named("pymunk")
LINKAGES = ("crank-shaper", "jansen-leg")


def acceleration_over_its_law(machine: Any, steps: int, start: float, iterations: int | None = None) -> float:
    settings = PymunkSettings.tuned(machine, steps)
    settings = replace(settings, iterations=iterations or settings.iterations)
    found = compare(whole_run(PYMUNK, machine, settings, 0.1, start), machine)
    return float(found.worst("acceleration") / PYMUNK.expected_error(machine, settings, start).acceleration)


@pytest.mark.parametrize("name", LINKAGES)
def test_one_iteration_does_to_the_velocities_what_the_theory_says(name: str) -> None:
    """A step of no length, without correction, from bodies that move at random while the crank stands."""
    machine: Any = catalogue_scene(name)
    kinematics, mechanism = machine.kinematics, machine.kinematics.mechanism
    still = replace(PymunkSettings.stock(machine, 1000), iterations=1, gravity=False, error_bias=1.0)
    made, poses = build(machine, still), kinematics.poses(np.array([1.0]))
    inverse = inverse_masses(mechanism, iteration.straight(mechanism))
    free = np.flatnonzero(inverse)
    jacobian = kinematics.jacobian(poses) @ by_centres(mechanism, poses)[:, :, free]
    once = one_iteration(jacobian, inverse[free], iteration._constraints(kinematics))[0]
    rates = np.zeros(len(inverse))
    rates[free] = np.random.default_rng(1).normal(size=len(free))
    made.place(poses[0], np.zeros_like(poses[0]))
    for body, (x, y, turn) in zip(made.bodies, rates.reshape(-1, 3).tolist(), strict=True):
        body.velocity, body.angular_velocity = (x, y), turn
    made.space.step(1e-12)
    assert np.allclose(state(made)[1][0][free], once @ rates[free], rtol=0.0, atol=1e-9)


@pytest.mark.parametrize("number", [0, 17])
def test_what_the_masses_alone_call_for_is_too_little_for_a_crank_shaper(number: int) -> None:
    machine, steps, start = variant(catalogue_scene("crank-shaper"), number)
    assert acceleration_over_its_law(machine, steps, start) < 1.0
    assert acceleration_over_its_law(machine, steps, start, iterations_by_masses(machine.mechanism())) > 1.2


@pytest.mark.parametrize(("name", "start"), [("saw-500rpm", 4.7), ("whitworth", 4.5)])
def test_the_rule_is_enough_where_a_run_begins_worst_and_not_many_times_too_many(name: str, start: float) -> None:
    machine: Any = SCENES.get(name) or catalogue_scene(name)
    enough = PymunkSettings.tuned(machine, 1000).iterations
    assert acceleration_over_its_law(machine, 1000, start) < 1.0
    # It is for the finest steps that the rule takes more than a thousand of them need.
    assert acceleration_over_its_law(machine, 1000, start, enough // 3) > 1.0
