"""Box2D, where it is installed: velocities a step late, joints closed to rounding, caps, and what it refuses."""

from __future__ import annotations

import importlib
from collections.abc import Iterator
from dataclasses import replace
from functools import cache
from importlib.util import find_spec
from typing import Any

import numpy as np
import pytest
from catalogue import CAM, EVERY_SCENE, SAW

from conrod import Outcome
from conrod.comparison.compare import compare
from conrod.comparison.trajectory import Piece, concatenate_pieces
from conrod.engines import engine_named
from conrod.engines.box2d import BOX2D_PRESETS, Box2DSettings
from conrod.engines.engine import SINGLE_EPSILON
from conrod.engines.numerics import largest_derivatives
from conrod.engines.run import run_in_one_piece
from conrod.exact.motion import Array
from conrod.scenes import scene_named
from conrod.testing import EngineConformance

pytestmark = pytest.mark.skipif(find_spec("Box2D") is None, reason="the extra conrod[box2d] is not installed")

QUANTITIES = ("position", "velocity", "acceleration")
TURNS = {name: EVERY_SCENE[name] for name in ("shear-press", "press-reversed", "saw-500rpm", "saw-slide-below")}


@pytest.fixture
def box2d() -> Any:
    """The engine."""
    return engine_named("box2d")


@cache
def run_box2d(scene: Any, settings: Box2DSettings, revolutions: float = 1.0) -> Piece:
    return concatenate_pieces(list(engine_named("box2d").run(scene, settings, revolutions)))


def worst(scene: Any, preset: str, steps: int, **fields: Any) -> Array:
    """Largest normalised errors of position, velocity and acceleration."""
    found = compare(run_box2d(scene, replace(BOX2D_PRESETS[preset](scene, steps), **fields)).trajectory, scene)
    return np.array([found.worst(quantity) for quantity in QUANTITIES])


class TestConformance(EngineConformance):
    scenes = ("saw-40rpm", "shear-press")
    first_order = ("stock",)
    rounding = 20.0 * SINGLE_EPSILON

    @pytest.fixture(autouse=True)
    def judged(self, box2d: Any, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
        """Its presets are not judged, and their stamps are looked at all the same."""
        monkeypatch.setattr(type(self), "engine", box2d, raising=False)
        monkeypatch.setattr(box2d, "presets", {name: replace(one, judged=True) for name, one in BOX2D_PRESETS.items()})
        return


# -- samples -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", TURNS)
def test_tuned_error_is_rounding_at_any_step(name: str) -> None:
    scene = TURNS[name]
    floor = [SINGLE_EPSILON * size for size in largest_derivatives(scene.kinematics, 1)]
    for steps in (50, 400):
        position, velocity, _ = worst(scene, "tuned", steps)
        assert position < 10.0 * floor[0]
        assert velocity < 10.0 * floor[1]


def test_accelerations_have_order_two_until_rounding_dominates() -> None:
    coarse, middle, fine, finest = (worst(SAW, "tuned", n)[2] for n in (50, 100, 400, 3200))
    assert np.log2(coarse / middle) == pytest.approx(2.0, abs=0.1)
    assert finest > 3.0 * fine


def test_stock_is_of_order_two_in_positions() -> None:
    errors = np.array([worst(SAW, "stock", n) for n in (200, 400, 800)])
    orders = -np.polyfit(np.log([200, 400, 800]), np.log(errors), 1)[0]
    assert orders == pytest.approx([2.0, 1.0, 0.0], abs=0.1)


def test_crank_angle_keeps_its_digits_after_many_revolutions() -> None:
    """Its angle is written without whole turns; a single-precision number of 200 turns has steps of 1e-4 rad."""
    scene, settings = SAW, BOX2D_PRESETS["stock"](SAW, 20)
    instants = run_box2d(scene, settings, 200.0).trajectory.bodies.position.instants  # type: ignore[union-attr]
    assert np.abs(instants.angle - scene.speed * instants.times).max() < 1e-6


@pytest.mark.parametrize("name", ["crank-shaper", "inverted-slider-crank", "six-bar"])
def test_iterations_needed_close_any_linkage(name: str) -> None:
    """Bound by the gaps' amplification; a tenth of the iterations leaves ten times as much, and more."""
    scene = scene_named(name)
    settings = BOX2D_PRESETS["tuned"](scene, 100)
    few = settings.position_iterations // 10
    position = worst(scene, "tuned", 100)[0]
    assert position < 2e-4
    assert worst(scene, "tuned", 100, position_iterations=few, velocity_iterations=few)[0] > 2.0 * position


def test_a_rod_too_long_by_a_hundred_thousandth_is_detected(box2d: Any) -> None:
    """The model is right: `tuned` is off by rounding, and a planted length is not."""
    wrong = replace(SAW, rod=SAW.rod * (1.0 + 1e-5))
    off = compare(run_in_one_piece(box2d, wrong, BOX2D_PRESETS["tuned"](wrong, 100), 1.0), SAW).worst("position")
    assert off > 10.0 * worst(SAW, "tuned", 100)[0]


def test_a_cam_lifts_its_follower_as_in_pymunk() -> None:
    steps = 1000
    mine = worst(CAM, "tuned", steps, cam_vertices=100)
    pymunk = engine_named("pymunk")
    other = compare(run_in_one_piece(pymunk, CAM, pymunk.presets["tuned"](CAM, steps), 1.0), CAM)
    for measured, quantity in zip(mine[:2], QUANTITIES[:2], strict=True):
        assert measured == pytest.approx(other.worst(quantity), rel=0.5)


# -- what it does silently ---------------------------------------------------------------------------------------------


def test_iterations_stop_at_5_mm_without_unclosable_joints() -> None:
    closed, slack = (worst(SAW, "tuned", 100, length_scale=1.0, all_iterations=every)[0] for every in (True, False))
    assert slack > 1e3 * closed


def test_a_body_moves_at_most_two_units_per_step() -> None:
    settings = BOX2D_PRESETS["tuned"](SAW, 100)
    fast = worst(SAW, "tuned", 100, length_scale=64.0 * settings.length_scale)
    assert worst(SAW, "tuned", 100)[1] < 1e-5
    assert fast[1] > 0.1


def test_a_slow_machine_falls_asleep_unless_that_is_forbidden() -> None:
    slow = SAW.with_parameters(speed=0.01)  # [rad/s], below 2 deg/s
    settings = replace(BOX2D_PRESETS["tuned"](slow, 400), length_scale=1.0, all_iterations=False)
    asleep, awake = (run_box2d(slow, replace(settings, sleeping=one)).trajectory for one in (True, False))
    assert asleep.outcome is Outcome.STALLED
    assert awake.outcome is Outcome.COMPLETED
    assert (BOX2D_PRESETS["stock"](slow, 400).sleeping, settings.sleeping) == (True, False)


# -- what it cannot do -------------------------------------------------------------------------------------------------


def test_a_failed_assertion_of_box2d_is_an_outcome(box2d: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    stepping = importlib.import_module("conrod.engines.box2d.engine")
    advance = stepping.Box2DStepper.__call__

    def fails(stepper: Any, steps: int) -> None:
        advance(stepper, steps)
        if stepper._steps > 50:
            raise AssertionError("b2IsValid")

    monkeypatch.setattr(stepping.Box2DStepper, "__call__", fails)
    pieces = list(box2d.run(SAW, BOX2D_PRESETS["stock"](SAW, 100), 1.0, steps=20))
    assert pieces[-1].trajectory.outcome is Outcome.DIVERGED
    assert sum(len(piece.clock) for piece in pieces) == 101
