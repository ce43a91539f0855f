"""`conrod free`: engines' free motion against the exact one in time."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from functools import cache
from itertools import product
from pathlib import Path

import numpy as np
import pytest
from cell_tasks import InProcessExecutor
from command_line import conrod

from conrod.engines import engine_named
from conrod.errors import InvalidInput
from conrod.exact.dynamics.forward import ForwardDynamics
from conrod.execution.ledger import Ledger
from conrod.execution.resolve_arguments import select_scene
from conrod.execution.runner import run_cases
from conrod.mechanism.loads import Elastic
from conrod.mechanism.mechanism import Mechanism, Revolute
from conrod.scenes import SCENES, Scene, catalogue_names, dynamics_names
from conrod.studies.free_motion.exact import ExactCourse, exact_course
from conrod.studies.free_motion.plan import FREE, TORQUE, MotionPlan, TimeGrid
from conrod.studies.free_motion.results import MAX_EXACT_DRIFT, ExactSummary, MotionResult, MotionStudy
from conrod.studies.free_motion.study import MotionCase, inactive_loads, run_motion

SHORT = MotionPlan(FREE, 2.0)


def scene_from_tables(name: str) -> Scene:
    return select_scene(name, ())[1]


@cache
def course(name: str, seconds: float = 2.0, step: float | None = None) -> ExactCourse:
    return exact_course(name, scene_from_tables(name), MotionPlan(FREE, seconds, step))


def result(of: ExactCourse, engine: str = "mujoco", preset: str = "hardened", plan: MotionPlan = SHORT) -> MotionResult:
    return run_motion("it", of, engine_named(engine), preset, plan).with_verdict(plan.tolerance)


# -- what is found ---------------------------------------------------------------------------------------------------


def test_an_exact_motion_that_loses_its_energy_passes_nothing() -> None:
    held = MotionStudy("it", scene_from_tables("pendulum"), (result(course("pendulum")),), FREE, ())
    assert held.passed
    lost = ExactSummary(2.0 * MAX_EXACT_DRIFT, "", 1.0)
    drifting, measured = (replace(result(course("pendulum"), preset=one), exact=lost) for one in ("hardened", "stock"))
    assert not replace(held, results=(drifting,)).passed
    assert replace(held, results=(measured,)).passed  # and not judged


def stiffer(mechanism: Mechanism) -> Mechanism:
    springs = [load for load in mechanism.loads if isinstance(load.law, Elastic)]
    assert springs
    wrong = replace(springs[0], law=replace(springs[0].law, stiffness=1.01 * springs[0].law.stiffness))
    return replace(mechanism, loads=tuple(wrong if load is springs[0] else load for load in mechanism.loads))


def test_a_pendulum_converges_with_the_order_of_the_integrator() -> None:
    # At the default step the finest of three runs is at the rounding of some processors.
    coarser = result(course("pendulum", step=5e-3), plan=replace(SHORT, step=5e-3))
    assert coarser.order["position"] == pytest.approx(4.0, abs=0.1)
    stock = result(course("pendulum"), preset="stock")
    assert stock.order["position"] == pytest.approx(1.0, abs=0.1)
    assert stock.passed is None
    assert stock.leaves is not None
    assert stock.largest("energy") > 1e-4


def test_pymunk_is_measured_and_judged_when_tolerance_is_given() -> None:
    pendulum = course("pendulum")
    assert result(pendulum, "pymunk", "tuned").passed is None
    judged = result(pendulum, "pymunk", "tuned", replace(SHORT, tolerance={"position": 1e-5, "energy": 1.0}))
    assert judged.passed is False
    assert set(judged.out_of_tolerance()) == {"position"}
    assert judged.leaving == 1e-5


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "unresolved", "why", "resolved"),
    [
        (
            "saw-coasting",
            (0.1, 6e-5),
            r"the sign of forces.friction changes .*--step 0\.0[45]ms",
            (0.1, 4e-5),
        ),
        # After ten seconds hardened MuJoCo is off by 0.046.
        ("four-bar-chain-11", (0.8,), "where branches cross, 11 loops are singular at once", (0.5,)),
        # At the first crossing it moves.
        ("peaucellier", (0.4,), "the crank stands in a dead centre just where branches cross", (0.2,)),
    ],
)
def test_unresolved_motion_is_judged_only_with_a_given_tolerance(
    name: str, unresolved: tuple[float, ...], why: str, resolved: tuple[float, ...]
) -> None:
    long, early = course(name, *unresolved), course(name, *resolved)
    assert re.match(why, long.unresolved)
    assert result(long).passed is None
    assert result(long, plan=replace(SHORT, tolerance={"position": 1e-13})).passed is False
    assert early.unresolved == ""
    assert result(early).passed is True


def moved(mechanism: Mechanism) -> Mechanism:
    """The pin that is farthest from its body's origin, further by a ten-thousandth."""
    pins = [joint for joint in mechanism.joints if isinstance(joint, Revolute) and joint.name != mechanism.driver.joint]
    pin = max(pins, key=lambda one: np.hypot(*one.point_a) + np.hypot(*one.point_b))
    end = "point_a" if any(pin.point_a) else "point_b"
    wrong = replace(pin, **{end: tuple(1.0001 * x for x in getattr(pin, end))})
    return replace(mechanism, joints=tuple(wrong if joint is pin else joint for joint in mechanism.joints))


def with_defect(right: ExactCourse, name: str, defect: Callable[[Mechanism], Mechanism]) -> ExactCourse:
    """A wrong machine that begins in poses which fit its own lengths, held against the right one's motion."""
    wrong = defect(right.mechanism)
    rates = scene_from_tables(name).start_rates
    start, motion = ForwardDynamics(wrong).motion(np.zeros(1), rates=rates), right.motion
    poses, turning = (np.vstack([a, b[1:]]) for a, b in ((start.poses, motion.poses), (start.rates, motion.rates)))
    return replace(right, mechanism=wrong, motion=replace(motion, poses=poses, rates=turning))


def heaviest(mechanism: Mechanism) -> Mechanism:
    """The heaviest body but the crank, heavier by a hundredth all over."""
    body = max((b for b in mechanism.bodies if b.name != mechanism.crank), key=lambda b: b.mass)
    wrong = replace(body, mass=1.01 * body.mass, inertia=1.01 * body.inertia)
    return replace(mechanism, bodies=tuple(wrong if b is body else b for b in mechanism.bodies))


@pytest.mark.parametrize("name", ["whitworth", "saw-40rpm", "four-bar-swing", "slider-crank-spring"])
def test_wrong_pin_mass_or_spring_is_out_of_tolerance(name: str) -> None:
    # Runs at the step of the rule alone, by which a verdict is given.
    right = replace(course(name, 0.5), refinement=(Fraction(1),))
    assert result(right).passed is True
    for defect in (moved, heaviest) if name != "slider-crank-spring" else (stiffer,):
        assert result(with_defect(right, name, defect)).passed is False


# What `conrod free` answers for each dynamics scene with default settings, where that is not a run: what it says.
REFUSED = {("cam-spring-fast", FREE): "leaves the cam", ("press-cutting", FREE): "comes to rest in a force"}
DRIVEN = ("press-cutting", "press-cutting-flywheel")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "motion"),
    [*((name, FREE) for name in (*SCENES, *catalogue_names())), *product(dynamics_names(), (FREE, TORQUE))],
)
def test_no_shipped_scene_fails_with_default_settings(name: str, motion: str) -> None:
    # Nothing but hardened MuJoCo is judged.
    given = ("--torque",) if motion == TORQUE else ()
    done = conrod("free", name, *given, "--engine", "mujoco", "--preset", "hardened", "--jobs", "1")
    said = "no torque that drives its crank" if motion == TORQUE and name not in DRIVEN else REFUSED.get((name, motion))
    assert done.returncode == (0 if said is None else 2), done
    assert (said or "") in done.stderr
    assert ("OUT OF TOLERANCE" in done.stdout) is False


# -- what is run -----------------------------------------------------------------------------------------------------


def test_order_is_observed_at_longer_steps_where_those_hold() -> None:
    assert course("pendulum").refinement == (Fraction(1, 4), Fraction(1, 2), Fraction(1))
    assert course("pendulum", step=5e-3).refinement == (Fraction(1), Fraction(2), Fraction(4))
    found = result(course("pendulum"))
    step = course("pendulum").grid.step
    assert [point.step for point in found.refinement] == [4.0 * step, 2.0 * step, step]
    assert found.refinement[-1].position == found.largest("position")
    # A longer step leads to each second instant only where four of them are six of the run's: errors are taken there.
    grid, every = TimeGrid(1.0, 6, 101).with_step_divided(Fraction(1, 4))
    assert (grid, every) == (TimeGrid(4.0, 3, 50), 2)
    # Negative control: at instants of another run the errors would not be of order 4.
    pendulum = replace(course("pendulum"), grid=replace(course("pendulum").grid, stride=2))
    assert result(pendulum).order["position"] is None


def test_runs_of_a_scene_share_one_exact_motion(ledger: Ledger) -> None:
    scene = scene_from_tables("pendulum")
    cases = [MotionCase("pendulum", scene, "mujoco", preset, SHORT) for preset in ("stock", "hardened")]
    other = MotionCase("pendulum", scene, "mujoco", "stock", replace(SHORT, seconds=1.0))
    here = InProcessExecutor()
    found = run_cases([*cases, other], ledger, here)
    made = [case.known_course for case in here.cases if isinstance(case, MotionCase)]
    assert len(here.cases) - len(made) == len({id(one) for one in made}) == 2  # the other case has one of its own
    for case in cases:
        assert replace(found[case.key], curves=None) == replace(case.perform(), curves=None)


def test_free_motion_omits_crank_drive_and_torque_needs_it() -> None:
    scene = scene_from_tables("press-cutting")
    free = MotionPlan(FREE).keep_acting_loads(scene.mechanism(), "press-cutting")
    driven = MotionPlan(TORQUE).keep_acting_loads(scene.mechanism(), "press-cutting")
    assert driven is scene.mechanism()
    lost = {load.name for load in driven.loads} - {load.name for load in free.loads}
    assert len(lost) == 1
    assert set(inactive_loads(scene, MotionPlan(FREE))) == lost
    with pytest.raises(InvalidInput, match="no torque that drives its crank"):
        MotionPlan(TORQUE).keep_acting_loads(course("pendulum").mechanism, "pendulum")


def test_the_example_of_the_documentation_runs(capsys: pytest.CaptureFixture[str]) -> None:
    text = (Path(__file__).parents[2] / "docs/free-motion.md").read_text()
    exec(text.split("```python\n")[1].split("```")[0], {})
    drift, error, passed = capsys.readouterr().out.split()
    assert float(drift) < MAX_EXACT_DRIFT
    assert 0.0 < float(error) < 1e-6
    assert passed == "True"
