"""Exudyn, where it is installed: exact closures, the orders of its two solvers, and what it refuses or fails at."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from importlib.util import find_spec
from typing import Any

import numpy as np
import pytest
from catalogue import EVERY_SCENE, LINKAGES, PRESS, SAW
from kinematic_mode import kinematic_errors

from conrod import Outcome
from conrod.comparison.compare import compare
from conrod.comparison.outcome import joint_gaps
from conrod.comparison.trajectory import Piece, concatenate_pieces
from conrod.engines import engine_named
from conrod.engines.engine import run_extent
from conrod.engines.exudyn import EXUDYN_PRESETS, ExudynSettings
from conrod.errors import InvalidInput
from conrod.exact.motion import Array
from conrod.scenes import scene_named
from conrod.testing import EngineConformance

QUANTITIES = ("position", "velocity", "acceleration")
STEPS = (125, 250, 500)
TURNS = {name: EVERY_SCENE[name] for name in ("shear-press", "press-reversed", "saw-500rpm", "saw-slide-below")}


@pytest.fixture
def exudyn() -> Any:
    """The engine."""
    pytest.importorskip("exudyn", reason="the extra conrod[exudyn] is not installed")
    return engine_named("exudyn")


@cache
def run_exudyn(scene: Any, settings: ExudynSettings, revolutions: float = 1.0, start_angle: float = 0.0) -> Piece:
    return concatenate_pieces(list(engine_named("exudyn").run(scene, settings, revolutions, start_angle)))


def states(scene: Any, settings: ExudynSettings, revolutions: float = 1.0, start_angle: float = 0.0) -> Any:
    bodies = run_exudyn(scene, settings, revolutions, start_angle).trajectory.bodies
    assert bodies is not None
    return bodies.position


def errors_in_time(scene: Any, preset: str, steps: int, late: float = 0.0) -> list[Array]:
    """Largest error of any body's pose, rate and acceleration at each sample (T,), at unit speed.

    Args:
        late: steps by which the samples' instants are mistaken.
    """
    found = states(scene, EXUDYN_PRESETS[preset](scene, steps))
    exact = scene.kinematics.derivatives(scene.speed * (found.instants.times + late * found.instants.times[1]), 2)
    measured = (found.poses, found.rates / scene.speed, found.accelerations / scene.speed**2)
    return [np.abs(m - e).max(axis=1) for m, e in zip(measured, exact, strict=True)]


def orders(scene: Any, preset: str, after: float = 0.0, late: float = 0.0) -> list[float]:
    """Observed orders of poses, rates and accelerations, of what comes after so many turns."""
    errors = [[e[round(after * n) :].max() for e in errors_in_time(scene, preset, n, late)] for n in STEPS]
    return [float(-np.polyfit(np.log(STEPS), np.log(column), 1)[0]) for column in zip(*errors, strict=True)]


@pytest.mark.skipif(find_spec("exudyn") is None, reason="the extra conrod[exudyn] is not installed")
class TestConformance(EngineConformance):
    scenes = ("saw-40rpm",)

    @pytest.fixture(autouse=True)
    def installed(self, exudyn: Any, monkeypatch: pytest.MonkeyPatch) -> None:
        """Exudyn, loaded where it is tested alone."""
        monkeypatch.setattr(type(self), "engine", exudyn, raising=False)


# -- samples -----------------------------------------------------------------------------------------------------------


@pytest.mark.usefixtures("exudyn")
def test_all_quantities_of_a_sample_belong_to_its_instant() -> None:
    scene = TURNS["saw-500rpm"]
    assert orders(scene, "tuned") == pytest.approx([2.0, 2.0, 2.0], abs=0.1)
    # Stamped half a step late, either way, all three are off by their own rates.
    for late in (0.5, -0.5):
        assert orders(scene, "tuned", late=late) == pytest.approx([1.0, 1.0, 1.0], abs=0.1)


@pytest.mark.usefixtures("exudyn")
@pytest.mark.parametrize("name", ["shear-press", "saw-500rpm"])
def test_stock_positions_are_exact_and_accelerations_order_one(name: str) -> None:
    scene = TURNS[name]
    assert max(errors_in_time(scene, "stock", n)[0].max() for n in STEPS) < 1e-12
    assert orders(scene, "stock")[1:] == pytest.approx([2.0, 1.0], abs=0.1)
    # What the start leaves has died away by numerical damping after half a turn of the finer runs.
    steps = (500, 1000)
    late = [errors_in_time(scene, "stock", n)[2][n // 2 :].max() for n in steps]
    assert np.log2(late[0] / late[1]) == pytest.approx(2.0, abs=0.1)


@pytest.mark.usefixtures("exudyn")
def test_velocity_constraints_drift_and_position_ones_do_not() -> None:
    scene, turns = scene_named("crank-shaper"), (2, 4, 8)

    def ends(preset: str) -> Array:
        """Largest gap of a joint at the end of so many turns [m]."""
        poses = states(scene, EXUDYN_PRESETS[preset](scene, 100), turns[-1]).poses[[100 * n for n in turns]]
        return np.max(list(joint_gaps(scene.kinematics.mechanism, [poses]).values()), axis=0)

    assert ends("stock").max() < 1e-11
    assert ends("tuned")[0] > 1e-5
    np.testing.assert_allclose(ends("tuned") / ends("tuned")[0], [1.0, 2.0, 4.0], rtol=0.02)


@pytest.mark.parametrize("preset", EXUDYN_PRESETS)
def test_a_run_is_the_same_every_time_and_in_any_pieces(preset: str, exudyn: Any) -> None:
    scene = TURNS["saw-500rpm"]
    settings = EXUDYN_PRESETS[preset](scene, 100)
    whole = run_exudyn(scene, settings, 11.0)
    for steps in (1100, 99, 1024):
        parts = concatenate_pieces(list(exudyn.run(scene, settings, 11.0, steps=steps)))
        assert np.array_equal(parts.clock, whole.clock)
        for name in ("poses", "rates", "accelerations"):
            mine, other = (getattr(p.trajectory.bodies.position, name) for p in (parts, whole))  # type: ignore[union-attr]
            assert np.array_equal(mine, other), name


# -- model -------------------------------------------------------------------------------------------------------------

ANGLES = np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False)


@pytest.mark.parametrize("name", [*LINKAGES, "saw-reversed", "crank-shaper", "inverted-slider-crank", "whitworth"])
@pytest.mark.usefixtures("exudyn")
def test_kinematic_mode_gives_exact_poses_and_rates(name: str) -> None:
    scene: Any = EVERY_SCENE.get(name) or scene_named(name)
    position, velocity = kinematic_errors("exudyn", scene, ANGLES)
    assert position <= 1e-12
    assert velocity <= 1e-9


@pytest.mark.parametrize("scene", [PRESS, SAW], ids=["press", "saw"])
@pytest.mark.usefixtures("exudyn")
def test_a_rod_too_long_by_a_millionth_is_detected(scene: Any) -> None:
    wrong = replace(scene, rod=scene.rod * (1.0 + 1e-6))
    position, velocity = kinematic_errors("exudyn", scene, ANGLES, wrong)
    assert position > 1e-7
    assert velocity > 1e-8
    settings = EXUDYN_PRESETS["stock"](scene, 125)
    right, off = (
        compare(run_exudyn(machine, settings).trajectory, scene).worst("position") for machine in (scene, wrong)
    )
    assert right < 1e-9
    assert off > 1e-7


# -- what it cannot do -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("preset", EXUDYN_PRESETS)
def test_a_solver_failure_is_an_outcome_and_prints_nothing(
    preset: str, exudyn: Any, capfd: pytest.CaptureFixture[str]
) -> None:
    scene = TURNS["saw-500rpm"]
    hopeless = replace(EXUDYN_PRESETS[preset](scene, 125), relative_tolerance=1e-15, absolute_tolerance=1e-15)
    pieces = list(exudyn.run(scene, hopeless, 1.0, steps=50))
    last = pieces[-1].trajectory
    assert last.outcome is Outcome.DIVERGED
    assert "Newton's iteration did not converge; not finite from" in last.reason
    assert sum(len(piece.clock) for piece in pieces) == 126  # none is left out: what was not reached is not a number
    assert capfd.readouterr() == ("", "")


# -- timing ------------------------------------------------------------------------------------------------------------


def test_stepper_for_timings_steps_the_recorded_machine(exudyn: Any) -> None:
    settings = EXUDYN_PRESETS["stock"](SAW, 125)
    stepper = exudyn.stepper(SAW, settings)
    for steps in (50, 75):
        stepper(steps)
    timed = next(stepper.states(1))
    np.testing.assert_allclose(timed[0], states(SAW, settings).poses[125], atol=1e-12)
    assert run_extent(SAW, 125, 1.0) == (0.0, 1.0)
    exudyn.reference_loop()(1000)


# -- an extra ----------------------------------------------------------------------------------------------------------


def test_an_engine_not_installed_is_refused_with_the_command(monkeypatch: pytest.MonkeyPatch) -> None:
    engine_named.cache_clear()
    monkeypatch.setattr("conrod.engines.find_spec", lambda _: None)
    with pytest.raises(InvalidInput, match=r"^engine 'exudyn' is an extra .*: pip install 'conrod\[exudyn\]'$"):
        engine_named("exudyn")
    engine_named.cache_clear()
