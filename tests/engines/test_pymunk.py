"""pymunk: free and torque-driven motion against the exact one, and its iterations by theory."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from catalogue import CAM
from free_machines import SWINGING_FOUR_BAR, SWINGING_SLIDER_CRANK, chain

from conrod.comparison.compare import compare
from conrod.comparison.trajectory import Outcome
from conrod.engines import engine_named
from conrod.engines.numerics import inverse_masses, iteration_matrix, poses_by_centres
from conrod.engines.pymunk import (
    PymunkSettings,
    _constraint_rows,
    engine,
    error_bound,
    iterations_by_masses,
    translating_bodies,
)
from conrod.engines.pymunk import dynamics as own
from conrod.engines.pymunk.loads import LoadForces
from conrod.engines.pymunk.space import build
from conrod.engines.pymunk.stepping import read_states
from conrod.engines.run import run_in_one_piece
from conrod.engines.tracks import FreeRun, Pace
from conrod.exact.dynamics.forward import ForwardDynamics, FreeMotion
from conrod.mechanism.loads import Displacement, Distance, Elastic, Friction, Load, SpeedLine, TimePulse, Turn, Viscous
from conrod.mechanism.mechanism import GROUND, ConstantForce, Mechanism
from conrod.scenes import SCENES, catalogue_scene, scene_named
from docs.studies.healthy import variant

PYMUNK: Any = engine_named("pymunk")
PACE = Pace(1.0)  # no rule of pymunk's asks for it
REFINED = (2e-3, 1e-3, 5e-4)  # steps [s]

Swing = tuple[FreeRun, FreeMotion]


# By a mechanism's identity, which is kept so that no other one gets it, start and instants: for all runs told at these.
_EXACT: dict[tuple[int, float, float, int], tuple[Mechanism, FreeMotion]] = {}


def swing(mechanism: Mechanism, h: float, seconds: float, rate: float = 0.0) -> Swing:
    """A run told at about 250 instants, with the exact motion at these."""
    steps = round(seconds / h)
    every = max(1, steps // 250)
    times = h * (every * np.arange(steps // every + 1))
    key = id(mechanism), rate, round(h * every, 12), len(times)
    if key not in _EXACT:
        rates = {mechanism.crank: mechanism.driver.sense * rate}
        _EXACT[key] = mechanism, ForwardDynamics(mechanism).motion(times, rates)
    right = _EXACT[key][1]
    return PYMUNK.free_run(mechanism, "tuned", h, steps, right.poses[0], right.rates[0], PACE, every), right


def pose_error(run: FreeRun, right: FreeMotion) -> float:
    """Largest error of a coordinate of a body [m] or [rad]."""
    return float(np.abs(run.poses - right.poses).max())


def orders(errors: list[float]) -> list[float]:
    return [float(np.log2(a / b)) for a, b in pairwise(errors)]


def pose_errors(mechanism: Mechanism) -> list[float]:
    return [pose_error(*swing(mechanism, h, 1.0)) for h in REFINED]


PUSHED = replace(SWINGING_FOUR_BAR, forces=(ConstantForce(SWINGING_FOUR_BAR.crank, (1.0, 2.0)),))


@pytest.mark.parametrize(
    ("mechanism", "rate"),
    [(SWINGING_FOUR_BAR, 0.0), (SWINGING_FOUR_BAR, 2.0), (PUSHED, 0.0)],
    ids=["", "moving", "pushed"],
)
def test_free_motion_of_a_four_bar_has_order_two(mechanism: Mechanism, rate: float) -> None:
    runs = [swing(mechanism, h, 1.0, rate) for h in REFINED]
    for told in ("poses", "rates"):
        errors = [float(np.abs(getattr(run, told) - getattr(right, told)).max()) for run, right in runs]
        assert errors[-1] < 1e-3
        assert min(orders(errors)) > 1.8
    for run, right in runs:
        np.testing.assert_allclose(run.times, right.times, rtol=1e-12)


def test_a_four_bar_swings_ten_seconds_within_a_thousandth() -> None:
    runs = [swing(SWINGING_FOUR_BAR, h, 10.0) for h in (1.25e-3, 6.25e-4)]
    assert [run.outcome for run, _ in runs] == [Outcome.COMPLETED] * 2
    assert pose_error(*runs[-1]) < 5e-4
    # Of energy, against the largest kinetic energy of the exact motion.
    drifts = [float(np.abs(run.energy - run.energy[0]).max()) / right.scale for run, right in runs]
    assert drifts[-1] < 1e-4
    assert orders(drifts)[0] == pytest.approx(2.2, abs=0.3)


def anchored_slider_crank(*laws: Any) -> Mechanism:
    """The slider-crank with laws between the rod and the ground."""
    along = Distance(GROUND, "rod", (0.2, 0.3), (0.05, 0.0))
    loads = tuple(Load(f"load {k}", along, law) for k, law in enumerate(laws))
    return replace(SWINGING_SLIDER_CRANK, loads=loads)


SPRING, DAMPER = Elastic(20.0, 0.2), Viscous(0.5)
DRIVEN = replace(
    SWINGING_SLIDER_CRANK,
    loads=(
        Load("motor", Turn(GROUND, "crank"), SpeedLine(2.0, 12.0)),
        Load("push", Turn(GROUND, "crank"), TimePulse(1.0, -0.5, 0.6)),
        Load("friction", Displacement("slider", (0.0, 0.0), 0.0), Friction(0.5, 0.3)),
    ),
)


SPRUNG = anchored_slider_crank(SPRING)


@pytest.mark.parametrize(
    "mechanism", [SPRUNG, anchored_slider_crank(DAMPER), anchored_slider_crank(SPRING, DAMPER), DRIVEN]
)
def test_free_motion_under_loads_has_order_two(mechanism: Mechanism) -> None:
    errors = pose_errors(mechanism)
    assert min(orders(errors)) > 1.8
    assert errors[-1] < 5e-4


def test_free_motion_of_a_cam_has_order_one() -> None:
    """A contact is corrected by velocities of its own, so nothing here is in the middle of a step."""
    push = Load("push", Turn(GROUND, CAM.mechanism().crank), TimePulse(0.2, 0.02, 0.3))
    cam = replace(CAM.mechanism(), loads=(push,))
    runs = [swing(cam, h, 0.2) for h in (4e-4, 2e-4)]
    errors = [pose_error(*one) for one in runs]
    assert errors[0] < 2e-3
    assert orders(errors) == pytest.approx([1.0], abs=0.1)
    run, right = runs[-1]
    assert np.abs(run.rates - right.rates).max() < 1e-4 * np.abs(right.rates).max()  # half a step off: ten times that


@pytest.mark.parametrize("mechanism", [DRIVEN, CAM.mechanism()], ids=["driven", "cam"])
@pytest.mark.parametrize("piece", [2, 40])
def test_sparse_samples_are_the_same_as_those_of_every_step(
    mechanism: Mechanism, piece: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    right = ForwardDynamics(mechanism).motion(np.zeros(1), {mechanism.crank: 1.0})
    asked = mechanism, "tuned", 1e-3, 103, right.poses[0], right.rates[0], PACE
    whole = PYMUNK.free_run(*asked)
    assert len(whole.times) == 104
    monkeypatch.setattr(own, "PIECE_STEPS", piece)
    told = PYMUNK.free_run(*asked, 4)
    for name in ("times", "poses", "rates"):
        assert np.array_equal(getattr(told, name), getattr(whole, name)[::4]), name


def test_loads_of_the_state_before_the_step_have_order_one(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(LoadForces, "apply_for_step", LoadForces.apply_now)
    assert orders(pose_errors(SPRUNG)) == pytest.approx([1.0, 1.0], abs=0.1)


def test_free_motion_without_the_half_step_has_order_one(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(own, "_half_step", lambda *_: None)
    assert orders(pose_errors(SWINGING_FOUR_BAR))[-1] == pytest.approx(1.0, abs=0.15)


def test_a_failed_free_run_states_outcome_and_reason() -> None:
    run, _ = swing(chain(2), 0.5, 10.0, 1.0)
    assert run.outcome in (Outcome.OPENED, Outcome.EXPLODED, Outcome.DIVERGED)
    assert run.reason


# -- iterations, by theory: what one of them does, and how many are enough wherever a run begins -----------------------

LINKAGES = ("crank-shaper", "jansen-leg")


def acceleration_over_its_law(machine: Any, steps: int, start: float, iterations: int | None = None) -> float:
    settings = PymunkSettings.tuned(machine, steps)
    settings = replace(settings, iterations=iterations or settings.iterations)
    found = compare(run_in_one_piece(PYMUNK, machine, settings, 0.1, start), machine)
    return float(found.worst("acceleration") / PYMUNK.expected_error(machine, settings, start).acceleration)


@pytest.mark.parametrize("name", LINKAGES)
def test_one_iteration_multiplies_velocities_by_its_matrix(name: str) -> None:
    """A step of no length, without correction, from bodies that move at random while the crank stands."""
    machine: Any = catalogue_scene(name)
    kinematics, mechanism = machine.kinematics, machine.kinematics.mechanism
    still = replace(PymunkSettings.stock(machine, 1000), iterations=1, gravity=False, error_bias=1.0)
    made, poses = build(machine, still), kinematics.poses(np.array([1.0]))
    inverse = inverse_masses(mechanism, translating_bodies(mechanism))
    free = np.flatnonzero(inverse)
    jacobian = kinematics.jacobian(poses) @ poses_by_centres(mechanism, poses)[:, :, free]
    once = iteration_matrix(jacobian, inverse[free], _constraint_rows(kinematics))[0]
    rates = np.zeros(len(inverse))
    rates[free] = np.random.default_rng(1).normal(size=len(free))
    made.set_states(poses[0], np.zeros_like(poses[0]))
    for body, (x, y, turn) in zip(made.bodies, rates.reshape(-1, 3).tolist(), strict=True):
        body.velocity, body.angular_velocity = (x, y), turn
    made.space.step(1e-12)
    assert np.allclose(read_states(made)[1][0][free], once @ rates[free], rtol=0.0, atol=1e-9)


@pytest.mark.parametrize("number", [0, 17])
def test_iterations_by_masses_are_too_few_for_a_crank_shaper(number: int) -> None:
    machine, steps, start = variant(catalogue_scene("crank-shaper"), number)
    assert acceleration_over_its_law(machine, steps, start) < 1.0
    assert acceleration_over_its_law(machine, steps, start, iterations_by_masses(machine.mechanism())) > 1.2


@pytest.mark.parametrize(("name", "start"), [("saw-500rpm", 4.7), ("whitworth", 4.5)])
def test_iterations_needed_suffice_at_the_worst_start(name: str, start: float) -> None:
    machine: Any = SCENES.get(name) or catalogue_scene(name)
    enough = PymunkSettings.tuned(machine, 1000).iterations
    assert acceleration_over_its_law(machine, 1000, start) < 1.0
    # It is for the finest steps that the rule takes more than a thousand of them need.
    assert acceleration_over_its_law(machine, 1000, start, enough // 3) > 1.0


# -- machines so slow that a step's weight is all that rounding counts by ---------------------------------------------


def shares_of_the_law(name: str, speed: float, steps: int) -> dict[str, float]:
    """Largest errors of a turn over their bounds."""
    engine: Any = engine_named("pymunk")
    machine = scene_named(name).with_parameters(speed=speed)
    settings = engine.presets["tuned"](machine, steps)
    bounds = engine.expected_error(machine, settings)
    found = compare(run_in_one_piece(engine, machine, settings, 1.0), machine)
    return {q: found.worst(q) / getattr(bounds, q) for q in ("position", "velocity", "acceleration")}


@pytest.mark.parametrize("speed", [1e-6, 1e-5, -1e-5])
@pytest.mark.parametrize("name", ["saw-40rpm", "shear-press", "crank-shaper"])
def test_error_law_holds_for_months_per_revolution(name: str, speed: float) -> None:
    assert max(shares_of_the_law(name, speed, 400).values()) < 1.0


def test_error_law_fails_without_the_rounding_of_weight(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(error_bound, "weight_rounding", lambda *_: [0.0, 0.0, 0.0])
    shares = shares_of_the_law("saw-40rpm", 1e-6, 400)
    assert shares["velocity"] > 1.0
    assert shares["acceleration"] > 10.0


def test_kinematic_mode_iterates_on_where_few_do_not_close(monkeypatch: pytest.MonkeyPatch) -> None:
    saw, angle = SCENES["saw-500rpm"], np.linspace(0.0, 0.5, 12)
    exact, few = saw.kinematics.poses(angle), PYMUNK.solve_kinematics(saw, angle)
    monkeypatch.setattr(engine, "_solve_in_few_iterations", lambda *_: None)
    many = PYMUNK.solve_kinematics(saw, angle)
    monkeypatch.undo()
    for found in (few, many):
        assert np.abs(found.poses - exact).max() < 1e-14
        for name, (_, velocity) in found.points.items():
            assert velocity == pytest.approx(many.points[name][1], abs=1e-13)
    # Negative control: with too few of them the joints do not close, which is noticed.
    monkeypatch.setattr(engine, "FEW_ITERATIONS", 2)
    assert np.array_equal(PYMUNK.solve_kinematics(saw, angle).poses, many.poses)
