"""What joints must give way by, told from each engine's documented law before a run, and then measured."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache
from typing import Any

import mujoco
import numpy as np
import pytest
from catalogue import CAM, LINKAGES, PRESS, SAW, SCENES

from conrod import Comparison, MuJoCoSettings, Outcome, PymunkSettings, compare, run
from conrod.engines import engine_named
from conrod.engines.capabilities import Softness
from conrod.engines.massless_rod import BODY, DISTANCE_JOINT
from conrod.engines.mujoco import softness as mujoco_softness
from conrod.engines.mujoco.model import build
from conrod.engines.mujoco.settings import Spring
from conrod.engines.mujoco.softness import Balance, integrated
from conrod.engines.numerics import largest_derivatives, self_consistent
from conrod.engines.pymunk.settings import STOCK_BIAS
from conrod.scenes.catalogue import scene_named

FAST = SCENES["saw-500rpm"]
# How far a law that leaves nothing out may be off: what sampling a turn 720 times misses, and what the step leaves.
SHARP = 1e-3


@cache
def measured(scene: Any, settings: Any) -> Comparison:
    trajectory = run(scene, settings)
    assert trajectory.outcome is Outcome.COMPLETED, trajectory.reason
    return compare(trajectory, scene)


def errors(scene: Any, settings: Any) -> tuple[float, float]:
    """Largest position error over the run, and over its last turn."""
    found, steps = measured(scene, settings), settings.steps_per_revolution
    return found.worst("position"), max(float(e.position.error[steps:].max()) for e in found.points.values())


@cache
def predicted(scene: Any, settings: Any) -> Softness:
    told = engine_named(settings.engine).predicted_softness(scene, settings)
    assert told is not None
    assert told.law
    return told


def assert_told(scene: Any, settings: Any, within: float = SHARP) -> None:
    told = predicted(scene, settings)
    assert (told.whole_run, told.last_turn) == pytest.approx(errors(scene, settings), rel=within)


def stock(scene: Any, **changes: Any) -> MuJoCoSettings:
    """MuJoCo's defaults but for the integrator, which leaves nothing of the step at 2000 steps a revolution."""
    return replace(MuJoCoSettings.stock(scene, 2000), integrator="RK4", **changes)


# -- MuJoCo's constraint model ---------------------------------------------------------------------------------------

SOLREFS = [(0.02, 1.0), (0.005, 0.4), (-2000.0, -70.0), (1e-6, 1.0)]
SOLIMPS = [
    (0.9, 0.95, 0.001, 0.5, 2.0),
    (0.2, 0.99, 0.002, 0.3, 3.0),
    (0.9, 0.5, 0.001, 0.0, 1.0),
    (0.8, 1.0, 0.001, 1.0, 2.5),
    (0.9, 0.9, 0.001, 0.5, 2.0),
]


@pytest.mark.parametrize("solimp", SOLIMPS)
@pytest.mark.parametrize("solref", SOLREFS)
def test_the_spring_is_the_one_that_the_engine_makes(solref: Any, solimp: Any) -> None:
    settings = stock(SAW, solref=solref, solimp=solimp)
    spring, model = Spring.of(solref, solimp, settings.timestep), build(SAW, settings).model
    data = mujoco.MjData(model)
    for way in (1e-5, 2e-4, 5e-4, 9e-4, 3e-3):
        data.joint("slide").qpos[0] = way
        mujoco.mj_fwdPosition(model, data)
        gap = np.linalg.norm(data.efc_pos[:2])
        impedance = spring.impedance(float(gap))
        stiffness, damping, engines_own, _ = np.asarray(data.efc_KBIP).reshape(-1, 4)[0]
        assert (spring.stiffness, spring.damping, impedance) == pytest.approx(
            (stiffness, damping, engines_own), rel=1e-12
        )


@pytest.mark.parametrize("name", LINKAGES)
def test_the_plateau_of_stock_mujoco_is_the_one_that_its_law_gives(name: str) -> None:
    assert_told(LINKAGES[name], stock(LINKAGES[name]))


def test_the_plateau_of_a_machine_under_a_spring_is_the_one_that_its_law_gives() -> None:
    scene = scene_named("slider-crank-spring")
    assert_told(scene, stock(scene), within=0.01)


@pytest.mark.parametrize(("factor", "gravity"), [(0.01, True), (100.0, False)])
@pytest.mark.parametrize("scene", [SAW, PRESS], ids=["saw", "press"])
def test_what_masses_and_gravity_do_to_it_follows(scene: Any, factor: float, gravity: bool) -> None:
    other = scene.with_parameters(slider_mass=factor * scene.slider_mass)
    settings = stock(other, gravity=gravity)
    if (scene, factor) == (PRESS, 100.0):
        assert run(other, settings).outcome is Outcome.OPENED
        told = engine_named("mujoco").predicted_softness(other, settings)
        assert told is None or told.whole_run > 0.05
        return
    assert_told(other, settings)
    # It is worth telling: the masses change it by more than a third.
    assert abs(predicted(other, settings).whole_run / predicted(scene, settings).whole_run - 1.0) > 0.3


KNOBS: dict[str, Any] = {
    "damping ratio 0.5": {"solref": (0.01, 0.5)},
    "stiffness and damping": {"solref": (-1e4, -2e2)},
    "impedance 0.99": {"solimp": (0.99, 0.99, 0.001, 0.5, 2.0)},
    "impedance over a wide range": {"solimp": (0.5, 0.98, 0.002, 0.3, 3.0)},
    "no gravity": {"gravity": False},
}


@pytest.mark.parametrize("knob", KNOBS)
def test_every_knob_of_a_closure_is_in_the_law(knob: str) -> None:
    assert_told(SAW, stock(SAW, **KNOBS[knob]))


@pytest.mark.parametrize("preset", ["stock", "tuned"])
def test_what_a_contact_sinks_by_is_in_the_law(preset: str) -> None:
    # The facets of the cam's polygon are not.
    assert_told(CAM, engine_named("mujoco").presets[preset](CAM, 15708), within=0.01)


@pytest.mark.parametrize("name", LINKAGES)
def test_hardening_leaves_no_softness(name: str) -> None:
    assert predicted(LINKAGES[name], MuJoCoSettings.hardened(LINKAGES[name], 500)).whole_run < 1e-12


def test_there_is_no_size_where_the_loop_does_not_hold() -> None:
    heavy: Any = FAST.with_parameters(slider_mass=600.0)
    assert engine_named("mujoco").predicted_softness(heavy, stock(heavy)) is None
    assert run(heavy, stock(heavy)).outcome is Outcome.OPENED


def test_a_law_with_a_part_left_out_is_caught(monkeypatch: pytest.MonkeyPatch) -> None:
    # Negative controls: no gravity in the forces, and no curvature in what the engine leaves out.
    right = engine_named("mujoco").predicted_softness(PRESS, stock(PRESS))
    weightless = engine_named("mujoco").predicted_softness(PRESS, stock(PRESS, gravity=False))
    assert right is not None
    assert weightless is not None
    assert abs(weightless.whole_run / errors(PRESS, stock(PRESS))[0] - 1.0) > 100.0 * SHARP
    distance = replace(MuJoCoSettings.tuned(SAW, 1000), rod=DISTANCE_JOINT)
    monkeypatch.setattr(
        mujoco_softness._SoftJoints, "_left_out", lambda self, closure, poses, *_: np.zeros((len(poses), closure.size))
    )
    told = engine_named("mujoco").predicted_softness(SAW, distance)
    assert told is not None
    assert told.whole_run < 0.01 * errors(SAW, distance)[0]


# -- pymunk's drift --------------------------------------------------------------------------------------------------

BIASES = {"stock": STOCK_BIAS, "0.5": 0.5, "none": 0.0}


def biased(scene: Any, steps: int, bias: float, rod: str = BODY) -> PymunkSettings:
    """Full iterations: a distance joint needs few."""
    tuned = PymunkSettings.tuned(scene, steps)
    return replace(tuned, error_bias=bias, rod=rod, iterations=tuned.iterations if rod == BODY else 30)


@pytest.mark.parametrize("rod", [BODY, DISTANCE_JOINT])
@pytest.mark.parametrize("bias", BIASES)
@pytest.mark.parametrize(
    ("name", "steps"),
    [
        *(("shear-press", 125), ("saw-500rpm", 125), ("saw-500rpm", 1000)),
        pytest.param("shear-press", 1000, marks=pytest.mark.slow),
    ],
)
def test_the_drift_of_pymunks_joints_is_the_one_that_its_law_gives(name: str, steps: int, bias: str, rod: str) -> None:
    assert_told(LINKAGES[name], biased(LINKAGES[name], steps, BIASES[bias], rod))


@pytest.mark.parametrize("name", LINKAGES)
def test_a_bias_costs_an_order(name: str) -> None:
    for bias, order in ((STOCK_BIAS, 1.0), (0.0, 2.0)):
        coarse, fine = (predicted(LINKAGES[name], biased(LINKAGES[name], n, bias)).whole_run for n in (2000, 4000))
        assert math.log2(coarse / fine) == pytest.approx(order, abs=0.01)


def test_a_slow_machine_drifts_by_the_step_over_twice_the_logarithm_of_the_bias() -> None:
    slow: Any = SAW.with_parameters(speed=0.05)
    settings = biased(slow, 40_000, STOCK_BIAS)
    # h x'' / (2 (-ln bias)), x'' in time.
    lag = settings.timestep * slow.speed**2 * largest_derivatives(slow.kinematics, 2)[2] / (-2.0 * math.log(STOCK_BIAS))
    assert predicted(slow, settings).whole_run == pytest.approx(lag, rel=0.03)


# -- how it is solved ------------------------------------------------------------------------------------------------


def test_a_state_that_answers_to_itself_is_found() -> None:
    for slope in (0.5, -0.5):
        found = self_consistent(lambda x, s=slope: 1.0 + s * x, np.zeros((3, 2)))
        assert found is not None
        assert found == pytest.approx(np.full((3, 2), 1.0 / (1.0 - slope)), rel=1e-5)


def test_a_state_without_an_end_is_none() -> None:
    assert self_consistent(lambda x: 1.0 - 3.0 * x, np.zeros(2)) is None
    assert self_consistent(lambda x: 1.0 - x, np.zeros(2)) is None
    assert self_consistent(lambda x: x + np.nan, np.zeros(2)) is None
    assert self_consistent(lambda x: np.linalg.solve(np.zeros((2, 2)), x), np.zeros(2)) is None


def oscillation_error(steps: int, stiffness: float) -> float:
    """Largest error of x'' + 2 r x' + r^2 x = its value on sin^2 t, from rest at zero, where r^2 is the stiffness."""
    time, decay = np.linspace(0.0, 2.0, steps + 1), math.sqrt(stiffness)

    def balance(at: float, _: Any) -> Balance:
        t = at * 2.0 / steps
        x, v, a = math.sin(t) ** 2, math.sin(2.0 * t), 2.0 * math.cos(2.0 * t)
        pull = 3.0 * a + 2.0 * decay * v + stiffness * x
        return Balance(np.array([[3.0]]), np.array([2.0 * decay]), np.array([stiffness]), np.array([pull]))

    places, _ = integrated(balance, steps + 1, 1, 2.0 / steps)
    return float(np.abs(places[:, 0] - np.sin(time) ** 2).max())


def test_the_gap_is_integrated_with_order_two_however_stiff() -> None:
    assert math.log2(oscillation_error(100, 1.0) / oscillation_error(200, 1.0)) == pytest.approx(2.0, abs=0.05)
    assert oscillation_error(100, 1e12) < 1e-6
