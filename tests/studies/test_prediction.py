"""Predicted errors against measured ones, by numbers worked out by hand and by planted samples."""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from catalogue import CAM, SAW
from synthetic import STAGGERED, synthetic_trajectory

from conrod import InvalidInput
from conrod.comparison.compare import ComparedPiece
from conrod.comparison.outcome import CHANGE_POINT_DISTANCE
from conrod.engines import engine_named
from conrod.exact.motion import QUANTITIES, Array
from conrod.execution.case import contradictions
from conrod.execution.prediction import (
    CorrectedStates,
    Prediction,
    keep_worst,
    merged_misfit,
    reference_misfit,
    solved_misfit,
    worst_misfit,
)
from conrod.execution.result import Plan, misfit_words, refinement_path, run_refinement_path
from conrod.scenes import catalogue_scene
from conrod.scenes.saw import Saw

TURN = 2.0 * math.pi

# -- what is allowed ---------------------------------------------------------------------------------------------------


def reference(*, near: bool = False, branch: int = 1, ends: tuple[float, ...] = (), conditioning: float = 0.5) -> Any:
    """Mechanism of size 2, whose point A has the length 0.5, at -4 rad/s; what its kinematics answer."""

    def near_change(angle: Array, distance: float) -> Array:
        assert distance == CHANGE_POINT_DISTANCE
        return np.full(len(angle), near)

    kinematics = SimpleNamespace(
        size=2.0,
        conditioning=lambda poses: np.full(len(poses), conditioning),
        near_change=near_change,
        branch=lambda poses: np.full(len(poses), branch),
        branch_at=lambda angle: np.full(len(angle), 1),
        arc_ends=ends,
        mechanism=SimpleNamespace(cam_contacts=ends),
    )
    return SimpleNamespace(kinematics=kinematics, lengths={"A": 0.5}, speed=-4.0)


def misfit(
    of: Any, order: int = 0, off: float = 2.5, angle: float = 3.0 * TURN, one: float = 0.1, two: float = 0.02
) -> Any:
    """Misfit of a sample that is off by so much over L omega^k, and of one that is not off at all."""
    norm, poses = 0.5 * 4.0**order, [np.zeros((2, 3))]
    mended = CorrectedStates(
        poses, poses, (np.full(2, one), np.full(2, two)), [np.array([0.0, 2.0 * 4.0**k]) for k in range(3)]
    )
    apart = norm * np.array([[0.0, 0.0], [0.6 * off, 0.8 * off]])
    left = norm * np.array([[0.0, 0.0], [0.3, 0.4]])
    return worst_misfit(of, mended, order, "A", apart, left, np.array([0.0, angle]))


@pytest.mark.parametrize("order", [0, 1, 2])
def test_allowance_is_two_second_steps_remainder_and_rounding(order: int) -> None:
    # 2 x 0.5 of the second step; 4 = S / L times e2^2 / e1 = 0.004, and rounding 1e-13 (1 + 3 turns + a change of 2).
    gain = 2.0  # over the least singular value, of a sample that is off by more than is allowed without it
    allowed = 1.0 + 4.0 * (gain**order * 0.004 + gain ** (order + 1) * 6e-13)
    found = misfit(reference(), order)
    assert found == {
        "difference": pytest.approx(2.5),
        "allowed": pytest.approx(allowed, rel=1e-14),
        "angle": 3.0 * TURN,
    }
    # Where the difference is within it anyway, nobody asks for singular values.
    found = misfit(reference(conditioning=math.nan), order, off=1.0)
    assert found["allowed"] == pytest.approx(1.0 + 4.0 * (0.004 + 6e-13), rel=1e-14)


def test_second_step_counts_as_itself_when_larger_than_the_first() -> None:
    assert misfit(reference(), off=0.1, one=0.01, two=0.02)["allowed"] == pytest.approx(1.0 + 4.0 * 0.02)
    assert misfit(reference(), off=0.1, one=0.0, two=0.02)["allowed"] == pytest.approx(1.0, rel=1e-11)


@pytest.mark.parametrize(
    ("facts", "of", "kept"),
    [
        ({}, {}, True),
        ({}, {"near": True}, False),
        ({}, {"branch": -1}, False),
        ({"one": 0.1, "two": 0.025}, {}, True),
        ({"one": 0.1, "two": 0.0251}, {}, False),
        ({"one": 1e-9, "two": 1e-9}, {}, True),  # after steps this small only rounding follows
        ({"one": 1e-9, "two": 1.1e-9}, {}, False),
        # Next to the end of an arc of a cam, a turn further, and by no more than the second step and 1e-6 rad.
        ({"angle": 1.0 + TURN}, {"ends": (1.0,)}, False),
        ({"angle": 1.0 - 0.0200005}, {"ends": (2.0, 1.0)}, False),
        ({"angle": 1.0 - 0.0200015}, {"ends": (2.0, 1.0)}, True),
        ({"angle": 1.0 + 1.5 * TURN}, {"ends": (1.0,)}, True),
    ],
)
def test_a_sample_without_a_prediction_is_left_out(facts: Any, of: Any, kept: bool) -> None:
    found = misfit(reference(**of), **facts)
    # The other sample is not off, so it is always kept.
    assert found["difference"] == pytest.approx(2.5 if kept else 0.0)


def test_what_is_no_number_is_the_worst_and_stays_it() -> None:
    found = misfit(reference(), off=math.nan)
    assert math.isnan(found["difference"])
    sizes = ((1.0, 1.0), (3.0, 2.0), (3.0, 4.0))
    small, large, other = ({"difference": d, "allowed": a, "angle": 0.0} for d, a in sizes)
    kept: dict[str, Any] = {}
    told = ((small, small), (None, small), (other, small), (large, large), (found, found), (large, found))
    for one, expected in told:
        keep_worst(kept, "position", one)
        assert kept["position"] is expected
    assert merged_misfit({"a": small, "b": large}, {"a": large, "b": small}, {"c": other}) == {
        "a": large,
        "b": large,
        "c": other,
    }


# -- planted samples ---------------------------------------------------------------------------------------------------


def planted(quantity: str, index: int, off: float, stride: int = 1, remaining: int = 0) -> Prediction:
    """Prediction on a run that is exact but for one sample of one quantity of the saw's point."""
    made = synthetic_trajectory(SAW, stamps=STAGGERED)
    point = made.points["C"]
    track = getattr(point, quantity)
    values = track.values.copy()
    values[index, 0] += off * SAW.lengths["C"] * SAW.speed ** QUANTITIES.index(quantity)
    points = {**made.points, "C": replace(point, **{quantity: replace(track, values=values)})}
    found = Prediction(SAW, stride)
    found.add(ComparedPiece(replace(made, points=points), SAW, remaining))
    return found


@pytest.mark.parametrize("quantity", QUANTITIES)
def test_a_point_that_is_not_its_bodys_is_a_misfit_where_it_is(quantity: str) -> None:
    found = planted(quantity, 700, 1e-3)
    # The prediction follows the point, and agrees with the exact motion: neither contradicts the other.
    assert found.sizes[quantity]["predicted"] == pytest.approx(1e-3, rel=1e-6)
    assert found.sizes[quantity]["difference"] < 1e-10
    wrong = contradictions(found.misfit)
    if quantity == "acceleration":
        assert wrong == {}
        return
    assert set(wrong) == {f"points' {quantity}"}
    angle = TURN * (700.0 + 0.5 * (quantity == "velocity")) / 500.0
    assert wrong[f"points' {quantity}"]["difference"] == pytest.approx(1e-3, rel=1e-6)
    assert wrong[f"points' {quantity}"]["angle"] == pytest.approx(angle)
    # Single precision of the size and of both values, over the length.
    exact = SAW.motion(np.array([angle]), SAW.speed).point("C")
    norm = SAW.lengths["C"] * abs(SAW.speed) ** QUANTITIES.index(quantity)
    size = 2.0 * float(np.linalg.norm(getattr(exact, quantity))) / norm
    allowed = 2e-6 * (SAW.kinematics.size / SAW.lengths["C"] + size)
    assert wrong[f"points' {quantity}"]["allowed"] == pytest.approx(allowed, rel=2e-3)


def test_a_point_that_is_no_number_is_a_misfit() -> None:
    found = planted("position", 700, math.nan).misfit
    assert math.isnan(found["points' position"]["difference"])
    assert math.isnan(found["position"]["difference"])


@pytest.mark.parametrize(
    ("index", "remaining", "seen"), [(996, 0, True), (997, 0, False), (997, 1, True), (1000, 1, False)]
)
def test_comparison_uses_every_nth_sample_and_the_last(index: int, remaining: int, seen: bool) -> None:
    found = planted("position", index, 1e-3, stride=4, remaining=remaining)
    assert ("points' position" in contradictions(found.misfit)) is seen


class Longer(Saw):
    """A saw whose closed form has a rod that is 0.001 % too long."""

    def motion(self, *args: Any, **kwargs: Any) -> Any:
        return Saw(rod=0.3 * 1.00001).motion(*args, **kwargs)


def test_a_reference_that_is_not_its_joints_is_a_misfit() -> None:
    found = contradictions(reference_misfit(Longer()))
    assert set(found) == set(QUANTITIES)
    # Looked at 0.37 of a 24th of a turn after each 24th.
    assert (found["position"]["angle"] * 24.0 / TURN) % 1.0 == pytest.approx(0.37)
    assert contradictions(reference_misfit(Saw())) == contradictions(reference_misfit(CAM)) == {}
    angle = np.array([0.3, 2.0])
    assert set(contradictions(solved_misfit(Longer(), angle, Saw().kinematics.poses(angle)))) >= {"position"}
    assert contradictions(solved_misfit(SAW, angle, SAW.kinematics.poses(angle) + 1e-5)) == {}


def test_a_misfit_is_told_with_the_worst_quantity_first() -> None:
    def of(difference: float, allowed: float = 1e-9) -> dict[str, float]:
        return {"difference": difference, "allowed": allowed, "angle": 0.5 * math.pi}

    assert misfit_words({}) == misfit_words({"position": of(1e-10)}) == ""
    assert misfit_words({"position": of(1e-8), "velocity": of(1e-7), "acceleration": of(1e-6, 1e-9)}) == (
        "the exact motion contradicts the joints' equations: acceleration by 1e-06 at crank angle 90 deg, where 1e-09 "
        "can be explained (position and velocity too)"
    )
    assert misfit_words({"velocity": of(1e-6)}).endswith("where 1e-09 can be explained")
    assert misfit_words({"position": of(1.0), "points' position": of(0.25), "points' velocity": of(0.5)}) == (
        "the measured points are not those of the bodies whose joints predict their errors, by 0.5"
    )


# -- plans of runs -----------------------------------------------------------------------------------------------------

PASS: Any = catalogue_scene("swinging-four-bar")


def test_orders_are_observed_at_steps_divided_by_powers_of_two() -> None:
    assert refinement_path(SAW, 1000) == (125, 250, 500, 1000)
    assert refinement_path(CAM, 1000) == (62, 125, 250, 500)
    assert refinement_path(SAW, 4) == (2, 4)


def test_a_plan_names_the_runs_of_a_preset() -> None:
    plan, preset = Plan(200, 3.0), engine_named("pymunk").presets["tuned"]
    of = [preset(SAW, n).as_dict() for n in (200, 25, 50, 100, 200)]
    facts = {"revolutions": 3.0, "start_angle": 0.0}
    assert plan.run_fields(SAW, preset) == {"settings": of[0], "refined": of[1:]} | facts
    assert plan.run_fields(SAW, preset, refined=False) == {"settings": of[0], "refined": []} | facts
    assert (Plan().steps(SAW), plan.steps(SAW), plan.extent(SAW)) == (1000, 200, (0.0, 3.0))


def test_a_pass_has_three_steps_at_least() -> None:
    # It takes 0.194 of a turn: 3 steps of 16, and 2 of 15.
    assert Plan(16).extent(PASS) == (PASS.kinematics.span[0], 3.0 / 16.0)
    with pytest.raises(InvalidInput, match=r"^15 steps per revolution are 2 of the pass: at least 3 are run$"):
        Plan(15).extent(PASS)
    assert Plan(2, 0.5).extent(SAW) == (0.0, 0.5)


def test_runs_of_a_refinement_path_share_their_extent() -> None:
    def run(steps: int, revolutions: float, start: float) -> Any:
        return steps, revolutions, start

    made = run_refinement_path(SAW, 100, 2.0, "judged", run)
    assert made == ((12, 2.0, 0.0), (25, 2.0, 0.0), (50, 2.0, 0.0), "judged")
    # Of a pass all take the part that the longest steps have room for, of those with three steps in it.
    start, begin = PASS.kinematics.span[0], 3.0 / 25.0
    made = run_refinement_path(PASS, 100, 2.0, "judged", run)
    longest = math.floor(25 * 0.194) / 25
    assert made == tuple((n, longest, start) for n in (25, 50, 100))
    assert begin < longest
