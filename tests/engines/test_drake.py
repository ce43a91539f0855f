"""Drake, where it is installed: orders of its two presets, its drives, and what it refuses or fails at."""

from __future__ import annotations

import re
from dataclasses import replace
from functools import cache
from importlib.util import find_spec
from typing import Any
from unittest.mock import Mock

import numpy as np
import pytest
from catalogue import EVERY_SCENE, PRESS, SAW

from conrod import Outcome
from conrod.comparison.compare import compare
from conrod.comparison.trajectory import Piece, concatenate_pieces
from conrod.engines import engine_named
from conrod.engines.drake import DRAKE_PRESETS, DrakeSettings
from conrod.engines.engine import run_extent
from conrod.engines.space import exact_start
from conrod.errors import InvalidInput
from conrod.exact.motion import Array
from conrod.exact.space.drive_laws import DriveLaw
from conrod.scenes import scene_named
from conrod.scenes.space import MACHINES
from conrod.scenes.space.tree import exact_points, machine_laws, spatial_tree
from conrod.testing import EngineConformance

STEPS = (100, 200, 400)
TURNS = {name: EVERY_SCENE[name] for name in ("shear-press", "press-reversed", "saw-500rpm", "saw-slide-below")}
REASON = "the extra conrod[drake] is not installed"


@pytest.fixture
def drake() -> Any:
    """The engine."""
    pytest.importorskip("pydrake", reason=REASON)
    return engine_named("drake")


@cache
def run_drake(scene: Any, settings: DrakeSettings, revolutions: float = 1.0) -> Piece:
    return concatenate_pieces(list(engine_named("drake").run(scene, settings, revolutions)))


def errors_in_time(scene: Any, preset: str, steps: int, late: float = 0.0) -> list[Array]:
    """Largest error of any body's pose, rate and acceleration at each sample (T,), at unit speed.

    Args:
        late: steps by which the samples' instants are mistaken.
    """
    bodies = run_drake(scene, DRAKE_PRESETS[preset](scene, steps)).trajectory.bodies
    assert bodies is not None
    found = bodies.position
    exact = scene.kinematics.derivatives(scene.speed * (found.instants.times + late * found.instants.times[1]), 2)
    measured = (found.poses, found.rates / scene.speed, found.accelerations / scene.speed**2)
    return [np.abs(m - e).max(axis=1) for m, e in zip(measured, exact, strict=True)]


def orders(scene: Any, preset: str, late: float = 0.0) -> list[float]:
    """Observed orders of poses, rates and accelerations, of what comes after a quarter of a turn."""
    errors = [[e[n // 4 :].max() for e in errors_in_time(scene, preset, n, late)] for n in STEPS]
    return [float(-np.polyfit(np.log(STEPS), np.log(column), 1)[0]) for column in zip(*errors, strict=True)]


@pytest.mark.skipif(find_spec("pydrake") is None, reason=REASON)
class TestConformance(EngineConformance):
    scenes = ("saw-40rpm",)

    @pytest.fixture(autouse=True)
    def installed(self, drake: Any, monkeypatch: pytest.MonkeyPatch) -> None:
        """Drake, loaded where it is tested alone."""
        monkeypatch.setattr(type(self), "engine", drake, raising=False)


# -- samples -----------------------------------------------------------------------------------------------------------


@pytest.mark.usefixtures("drake")
def test_constraints_are_of_order_two_and_their_rates_of_one() -> None:
    scene = TURNS["shear-press"]
    assert orders(scene, "stock") == pytest.approx([2.0, 1.0, 2.0], abs=0.1)
    # Stamped half a step late, either way, positions and accelerations are off by their own rates.
    for late in (0.5, -0.5):
        assert orders(scene, "stock", late)[::2] == pytest.approx([1.0, 1.0], abs=0.1)


@pytest.mark.usefixtures("drake")
def test_bushings_are_of_order_two_in_all_but_accelerations() -> None:
    scene = TURNS["shear-press"]
    assert orders(scene, "tuned")[:2] == pytest.approx([2.0, 2.0], abs=0.1)
    assert orders(scene, "tuned", late=0.5)[:2] == pytest.approx([1.0, 1.0], abs=0.1)


@pytest.mark.usefixtures("drake")
@pytest.mark.parametrize("name", TURNS)
def test_bushings_are_more_exact_than_constraints(name: str) -> None:
    scene = TURNS[name]
    stock, tuned = (errors_in_time(scene, preset, 200)[:2] for preset in ("stock", "tuned"))
    assert tuned[0].max() < 1e-4 * stock[0].max()
    assert tuned[1].max() < 0.1 * stock[1].max()


@pytest.mark.usefixtures("drake")
def test_first_accelerations_of_constraints_are_wrong() -> None:
    errors = [errors_in_time(TURNS["shear-press"], "stock", n)[2] for n in STEPS]
    assert [found[0] for found in errors] == pytest.approx([errors[0][0]] * 3, rel=0.05)  # whatever the step
    assert all(found[20:].max() < 0.01 * found[0] for found in errors)


@pytest.mark.parametrize("preset", DRAKE_PRESETS)
def test_a_drake_run_is_the_same_every_time_and_in_any_pieces(preset: str, drake: Any) -> None:
    scene = TURNS["saw-500rpm"]
    settings = DRAKE_PRESETS[preset](scene, 100)
    whole = run_drake(scene, settings, 2.0)
    for steps in (200, 33):
        parts = concatenate_pieces(list(drake.run(scene, settings, 2.0, steps=steps)))
        assert np.array_equal(parts.clock, whole.clock)
        for name in ("poses", "rates", "accelerations"):
            mine, other = (getattr(p.trajectory.bodies.position, name) for p in (parts, whole))  # type: ignore[union-attr]
            assert np.array_equal(mine, other), name


# -- model -------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("scene", [PRESS, SAW], ids=["press", "saw"])
@pytest.mark.usefixtures("drake")
def test_a_rod_too_long_is_detected_in_drake(scene: Any) -> None:
    wrong = replace(scene, rod=scene.rod * (1.0 + 1e-6))
    settings = DRAKE_PRESETS["tuned"](scene, 200)
    right, off = (
        compare(run_drake(machine, settings).trajectory, scene).worst("position") for machine in (scene, wrong)
    )
    assert right < 6e-8
    assert off > 1e-7


@pytest.mark.usefixtures("drake")
def test_flywheel_of_the_right_size_keeps_the_speed() -> None:
    scene = TURNS["saw-500rpm"]
    stock = DRAKE_PRESETS["stock"](scene, 200)

    def errors(ratio: float) -> tuple[float, float]:
        """Largest error of the crank's angle [rad], and of positions at the angle reached."""
        found = run_drake(scene, replace(stock, flywheel_ratio=ratio)).trajectory
        assert found.bodies is not None
        at = found.bodies.position.instants
        return float(np.abs(at.angle - scene.speed * at.times).max()), compare(found, scene).worst("position")

    light, right, heavy = (errors(ratio) for ratio in (1e4, 1e9, 1e14))
    assert light[0] > 1e3 * right[0]
    assert right[0] < 1e-8
    assert heavy[1] > 2.0 * right[1]  # rounding of the solver


# -- what it cannot do -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "reason"),
    [
        ("cam-follower", "no cams that act by contact and no wheels that roll"),
        ("planetary-gear", "no cams that act by contact and no wheels that roll"),
    ],
)
def test_drake_refuses_what_it_is_not_given(name: str, reason: str, drake: Any) -> None:
    scene: Any = EVERY_SCENE.get(name) or scene_named(name)
    assert reason in (drake.refusal(scene, DRAKE_PRESETS["stock"](scene, 100)) or "")


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ({"integrator": "radau"}, "integrator 'radau'.*radau3"),
        ({"flywheel_ratio": 0.0}, "flywheel_ratio = 0 is out of range: 1 <= "),
        ({"bushing_stiffness": -1.0}, "bushing_stiffness = -1 is out of range"),
        ({"accuracy": 1.0}, "accuracy = 1 is out of range"),
    ],
)
def test_wrong_drake_settings_are_refused_with_the_range(fields: dict[str, Any], message: str) -> None:
    with pytest.raises(InvalidInput, match=message):
        replace(DRAKE_PRESETS["stock"](SAW, 100), **fields)


def test_a_simulator_that_gives_up_is_an_outcome(drake: Any, capfd: pytest.CaptureFixture[str]) -> None:
    scene = TURNS["saw-500rpm"]
    hopeless = DRAKE_PRESETS["tuned"](scene, 4)
    pieces = list(drake.run(scene, replace(hopeless, accuracy=1e-13, bushing_stiffness=1e12), 1.0, steps=3))
    last = pieces[-1].trajectory
    assert last.outcome is Outcome.DIVERGED
    assert last.reason.startswith("Newton's iteration of Drake's integrator fails even in 1/1024 of a step; not finite")
    assert sum(len(piece.clock) for piece in pieces) == 5  # none is left out: what was not reached is not a number
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("preset", DRAKE_PRESETS)
def test_drives_follow_a_law_whose_rate_jumps(preset: str, drake: Any) -> None:
    def stop_dead(times: Array) -> Array:
        """A coordinate that grows at 2 rad/s and stands from 0.05 s on: derivatives (4, T)."""
        zeros = np.zeros(len(times))
        return np.array([2.0 * np.minimum(times, 0.05), 2.0 * (times < 0.05), zeros, zeros])

    machine = MACHINES["cardan"]()
    law = DriveLaw("stop", 1.0, stop_dead)
    start = exact_start(spatial_tree(machine), {"input": law}, exact_points(machine, np.zeros(1)))
    stepper = drake.stepper_in_space(replace(start, step=0.005), preset)
    joint, off = stepper.made.joints["input"].joint, []
    for k in range(1, 21):
        stepper(1)
        reached = stepper.made.plant.GetPositions(stepper.context)[joint.position_start()]
        off.append(abs(reached - stop_dead(np.array([0.005 * k]))[0, 0]))
    assert not stepper.failure
    assert max(off) < 1e-9


def test_drake_in_space_refuses_a_joint_it_has_not(drake: Any) -> None:
    machine = MACHINES["cardan"]()
    start = exact_start(spatial_tree(machine), machine_laws(machine), exact_points(machine, np.zeros(1)))
    bodies = [replace(one, joints=tuple(replace(j, kind="free") for j in one.joints)) for one in start.tree.bodies]
    other = Mock(tree=replace(start.tree, bodies=tuple(bodies)))
    assert drake.refusal_in_space(other, "stock") == "drake in space is given hinges, slides and balls, no free joints"
    assert drake.refusal_in_space(start, "stock") is None


@pytest.mark.parametrize(
    ("message", "words"),
    [
        ("Pitch angle p = 89 degrees is within 0.01 degrees of gimbal-lock which\nmeans", "a loop's bushing .*gimbal"),
        ("MapVelocityToQDot(): The RpyBallMobilizer (implementing a BallRpyJoint) ...", "a ball joint .BallRpyJoint"),
        ("anything\nelse", "^Drake: anything else$"),
    ],
)
@pytest.mark.usefixtures("drake")
def test_what_drake_raises_is_said_in_one_line(message: str, words: str) -> None:
    from conrod.engines.drake.stepping import explain_error

    assert re.search(words, explain_error(message))
    assert "\n" not in explain_error(message)


# -- timing ------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("preset", DRAKE_PRESETS)
def test_drake_stepper_steps_the_recorded_machine(preset: str, drake: Any) -> None:
    settings = DRAKE_PRESETS[preset](SAW, 100)
    stepper = drake.stepper(SAW, settings)
    for steps in (40, 60):
        stepper(steps)
    bodies = run_drake(SAW, settings).trajectory.bodies
    assert bodies is not None
    np.testing.assert_allclose(stepper.state()[0], bodies.position.poses[100], atol=1e-9)
    assert run_extent(SAW, 100, 1.0) == (0.0, 1.0)
    drake.reference_loop()(1000)


# -- an extra ----------------------------------------------------------------------------------------------------------


def test_drake_not_installed_is_refused_with_the_command(monkeypatch: pytest.MonkeyPatch) -> None:
    engine_named.cache_clear()
    monkeypatch.setattr("conrod.engines.find_spec", lambda _: None)
    with pytest.raises(InvalidInput, match=r"^engine 'drake' is an extra .*: pip install 'conrod\[drake\]'$"):
        engine_named("drake")
    engine_named.cache_clear()
