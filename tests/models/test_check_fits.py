"""Frames, branches and lengths that are planted in scans made from exact paths are found, with their words."""

from __future__ import annotations

import math
from contextlib import nullcontext
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from conrod.errors import InvalidInput
from conrod.mjcf.request import Scan
from conrod.models.check import fitting, references
from conrod.models.check.fitting import FrameFit, PathSearch, _fit_coarsely, fit_frame
from conrod.models.check.frame import GivenFrame, candidate_views
from conrod.models.check.identity import _fit_best_branch, _round_frame, identify, is_machine
from conrod.models.check.references import (
    ALL_LENGTHS,
    length_names,
    length_of,
    other_branches,
    paths_of,
    returns_after_turn,
    shaft_of,
    uncertainty_shares,
    with_branch_of,
    with_lengths,
)
from conrod.scenes import Saw, Scene, ShearPress, scene_named

SAW = Saw()
SAMPLES = 60
RIGHT, UP, AXIS = np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0]), np.array([0.0, -1.0, 0.0])


def scan_of(
    scene: Scene, rotation: float = 0.0, zero: float = 0.0, unit: float = 1.0, sense: int = 1, **changes: Any
) -> Scan:
    """A scan of a machine in a plane xz: turned [rad], in a unit [m], at coordinates from 0.4 rad on."""
    span, way = scene.kinematics.mechanism.driver.span, sense * scene.mechanism().driver.sense
    if span is None:
        coordinate = 0.4 + 2.0 * np.pi * np.arange(SAMPLES) / SAMPLES
    else:
        spacing, begin = (span[1] - span[0]) / SAMPLES, zero + (span[0] if way > 0 else -span[1])
        coordinate = begin + spacing * np.arange(SAMPLES + 1)
    names = tuple(scene.lengths)
    flat = paths_of(scene, names)(way * (coordinate - zero)) * np.exp(1j * rotation) / unit
    anchor = np.array([5.0, 6.0, 7.0])
    positions = anchor + flat.real[..., None] * RIGHT + flat.imag[..., None] * UP
    known = {
        "facts": None, "coordinate": coordinate, "points": names, "positions": positions,
        "turns": np.zeros((len(names), len(coordinate))), "anchor": anchor, "axis": sense * AXIS, "wander": 0.0,
        "shape_error": 0.0,
    }  # fmt: skip
    return Scan(**(known | changes))


# -- frames ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("rotation", "zero", "unit", "sense"), [
    (0.0, 0.0, 1.0, 1), (30.0, 45.0, 1e-3, 1), (-90.0, 123.0, 0.0254, 1), (180.0, -60.0, 1e-2, 1), (17.3, 5.7, 1.0, 1),
])  # fmt: skip
def test_a_planted_frame_is_found(rotation: float, zero: float, unit: float, sense: int) -> None:
    scan = scan_of(SAW, math.radians(rotation), math.radians(zero), unit, sense)
    identity, machine = identify(SAW, scan, GivenFrame())
    frame = identity.frame
    assert machine == SAW
    assert identity.is_machine(1e-9)
    assert (frame.view.name, frame.unit, frame.sense) == ("xz", unit, sense)
    assert math.degrees(frame.rotation) == pytest.approx(rotation, abs=1e-7)
    assert math.degrees(frame.zero) == pytest.approx(zero, abs=1e-7)
    assert frame.anchor == (5.0, 6.0, 7.0)
    assert frame.shaft == pytest.approx(SAW.shaft)
    assert list(identity.off_by) == ["C", "M"]
    assert identity.explanations == ()
    assert identity.left < 1e-9


def test_a_given_frame_is_kept_and_what_it_leaves_is_said() -> None:
    scan = scan_of(SAW, math.radians(30.0), math.radians(45.0))
    right = identify(SAW, scan, GivenFrame("xz", math.radians(30.0), math.radians(45.0)))[0]
    assert right.is_machine(1e-9)
    assert (math.degrees(right.frame.rotation), math.degrees(right.frame.zero)) == pytest.approx((30.0, 45.0))
    # A turn more of the crank is the same place.
    turn = identify(SAW, scan, GivenFrame(zero=math.radians(405.0)))[0]
    assert turn.is_machine(1e-9)
    assert math.degrees(turn.frame.zero) == pytest.approx(405.0)
    wrong = identify(SAW, scan, GivenFrame(rotation=math.radians(31.0), zero=math.radians(45.0)))[0]
    assert math.degrees(wrong.frame.rotation) == pytest.approx(31.0)
    assert not wrong.is_machine(1e-3)
    # A point is turned about the shaft by a degree: its distance from there is what it is off by.
    farthest = {name: np.abs(paths_of(SAW, [name])(np.linspace(0.0, 6.28, 400))).max() for name in SAW.lengths}
    off = {name: 2.0 * math.sin(math.radians(0.5)) * far / SAW.lengths[name] for name, far in farthest.items()}
    assert wrong.off_by == {name: pytest.approx(size, rel=1e-3) for name, size in off.items()}
    assert wrong.largest == max(wrong.off_by.values())


def test_distance_of_exactly_the_tolerance_is_within_it() -> None:
    identity = replace(identify(SAW, scan_of(SAW), GivenFrame())[0], off_by={"C": 1e-4, "M": 5e-5})
    assert identity.is_machine(1e-4)
    assert not identity.is_machine(0.999e-4)
    # Times a point's weight; and whatever the tolerance, what rounding explains is none.
    assert identity.is_machine(5e-5, {"C": 0.5})
    assert replace(identity, floor=1e-4).is_machine(1e-9)


def fit_of(scene: Scene, scan: Scan, given: GivenFrame) -> FrameFit:
    """The frame that is fitted to a scan, seen as it was made."""
    (view,) = candidate_views(scan.axis, 1, "xz")
    return fit_frame(PathSearch(scene, scan, view, given))


@pytest.mark.parametrize("turns", [-0.5, 0.5, 1.5])
def test_rotation_is_within_half_a_turn_where_turns_differ(turns: float) -> None:
    scene = scene_named("planetary-gear")
    fit = fit_of(scene, scan_of(scene, math.pi, 0.4), GivenFrame())
    assert not returns_after_turn(scene)
    assert _round_frame(replace(fit, rotation=2.0 * math.pi * turns), 1e-9).rotation == pytest.approx(math.pi)


def test_machine_without_another_branch_is_fitted_on_its_own() -> None:
    pendulum = scene_named("pendulum")
    assert other_branches(pendulum) == ()
    scan = scan_of(pendulum)
    uneven = scan.positions + 0.01 * np.cos(3.0 * scan.coordinate)[:, None] * RIGHT
    fit = _fit_best_branch(pendulum, replace(scan, positions=uneven), GivenFrame())
    assert fit.search.branch is None
    assert fit.largest > 1e-3


@pytest.mark.parametrize("name", ["swinging-four-bar"])
@pytest.mark.parametrize("zero", [None, 0.3])
def test_one_pass_of_a_machine_is_found(name: str, zero: float | None) -> None:
    scene = scene_named(name)
    scan = scan_of(scene, math.radians(15.0), 0.3, 1e-3)
    given = None if zero is None else zero - 4.0 * math.pi
    identity = identify(scene, scan, GivenFrame(zero=given))[0]
    assert identity.is_machine(1e-9)
    assert identity.frame.unit == 1e-3
    # Of one pass there is one turn that a given zero can be in. Seen from behind it would lie out of reach.
    assert identity.frame.zero == pytest.approx(0.3, abs=1e-7)
    assert math.degrees(identity.frame.rotation) == pytest.approx(15.0, abs=1e-6)


@pytest.mark.parametrize("scene", [SAW, scene_named("planetary-gear")])  # whose turns are each another
def test_coarse_fit_is_exact_when_a_sample_is_at_crank_zero(scene: Scene) -> None:
    # The turn begins at 0.4 rad, and the crank is at zero in the eighth sample.
    zero = 0.4 + 7 * 2.0 * np.pi / SAMPLES
    scan = scan_of(scene, 0.3, zero, 1e-3)
    (view,) = candidate_views(scan.axis, 1, "xz")
    found = _fit_coarsely(PathSearch(scene, scan, view, GivenFrame()))
    assert (found.zero, found.rotation, found.unit) == pytest.approx((zero, 0.3, 1e-3))
    assert found.largest < 1e-9
    # Negative control: between samples it is not.
    between = scan_of(scene, 0.3, zero + np.pi / SAMPLES, 1e-3)
    assert _fit_coarsely(PathSearch(scene, between, view, GivenFrame())).largest > 1e-3


def test_pass_is_refused_when_given_zero_leaves_its_reach() -> None:
    scene = scene_named("swinging-four-bar")
    scan = scan_of(scene, 0.0, 0.3)
    assert identify(scene, scan, GivenFrame("xz", zero=0.3))[0].is_machine(1e-9)
    with pytest.raises(InvalidInput, match=r"^swinging-four-bar cannot be assembled at every crank angle from "):
        identify(scene, scan, GivenFrame("xz", zero=2.3))


def test_short_verdict_on_paths_is_that_of_the_identity() -> None:
    scan, verdicts = scan_of(SAW, 0.3, 0.2, 1e-3), list[bool]()
    for name in ("crank", "rod"):
        # The last share but one is about where 1e-4 of the paths is reached.
        for share in (0.0, 1e-7, 1e-4, 2e-4, 3e-4, 1e-2):
            other = SAW.with_parameters(**{name: (1.0 + share) * SAW.parameters[name]})
            verdicts.append(is_machine(other, scan, GivenFrame(), 1e-4))
            assert verdicts[-1] is identify(other, scan, GivenFrame())[0].is_machine(1e-4)
    # Negative control: both verdicts are among them.
    assert {*verdicts} == {True, False}
    with pytest.raises(InvalidInput, match="nothing moves"):
        is_machine(SAW, replace(scan, positions=0.0 * scan.positions), GivenFrame(), 1e-4)


# -- lengths and branches --------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("change", "excess"), [({"rod": 0.303}, 0.01), ({"crank": 0.0999}, -1e-3)])
def test_a_length_that_is_off_is_the_explanation(change: dict[str, float], excess: float) -> None:
    ((name, found),) = change.items()
    # M is the middle of the rod in this machine and in the longer one.
    identity, machine = identify(SAW, scan_of(Saw(**change)), GivenFrame())
    (explanation,) = [one for one in identity.explanations if [length.name for length in one.lengths] == [name]]
    (length,) = explanation.lengths
    assert (length.expected, length.found) == (getattr(SAW, name), pytest.approx(found, rel=1e-8))
    assert length.excess == pytest.approx(excess, rel=1e-6)
    assert explanation.misplaced == ()
    assert getattr(machine, name) == pytest.approx(found, rel=1e-8)
    assert explanation.left < 1e-9
    assert identity.largest > 1e-5


def test_a_length_is_fitted_beside_lengths_that_close_no_machine() -> None:
    # A rod of less than 0.19 m does not reach from the crank pin to the slide, and the first step goes there.
    fit = fit_of(SAW, scan_of(Saw(rod=0.191)), GivenFrame(rotation=0.0, zero=0.0)).refine(["rod"])
    assert length_of(fit.machine, "rod") == pytest.approx(0.191, rel=1e-9)
    assert fit.rms < 1e-12


def test_fit_ends_with_the_step_that_gains_little(monkeypatch: pytest.MonkeyPatch) -> None:
    made, scan, random = list[float](), scan_of(Saw(rod=0.303)), np.random.default_rng(3)
    noise = 1e-3 * (random.normal(size=(2, SAMPLES, 1)) * RIGHT + random.normal(size=(2, SAMPLES, 1)) * UP)
    fit = fit_of(SAW, replace(scan, positions=scan.positions + noise), GivenFrame())

    def with_lengths_noted(scene: Scene, names: Any, values: Any, **how: Any) -> Any:
        made.append(values[0])
        return with_lengths(scene, names, values, **how)

    monkeypatch.setattr(fitting, "with_lengths", with_lengths_noted)
    rms = fit.refine(["rod"]).rms
    # Two steps: where it starts, where each leads, and two beside each for the slope.
    assert len(made) <= 9
    assert rms < 0.9 * fit.rms


def test_a_machine_of_another_size_has_a_factor_on_all_lengths() -> None:
    press = ShearPress()
    scan = scan_of(with_lengths(press, [ALL_LENGTHS], np.array([1.01])))
    (explanation,) = identify(press, scan, GivenFrame())[0].explanations
    (length,) = explanation.lengths
    assert (length.name, length.expected, length.found) == (ALL_LENGTHS, 1.0, pytest.approx(1.01, rel=1e-9))


def test_the_other_branch_is_named() -> None:
    (other,) = other_branches(SAW)
    scan = scan_of(SAW)
    flat = paths_of(other, tuple(SAW.lengths))(scan.coordinate)
    positions = scan.anchor + flat.real[..., None] * RIGHT + flat.imag[..., None] * UP
    identity, machine = identify(SAW, replace(scan, positions=positions), GivenFrame(rotation=0.0, zero=0.0))
    assert identity.other_branch
    assert not identity.is_machine(1.0)
    assert identity.left < 1e-9
    assert identity.largest < 1e-9
    assert machine.mechanism().name == "saw-otherwise"


@pytest.mark.parametrize("meant", [0, 1])
def test_nearest_branch_is_named_when_a_machine_has_three(meant: int) -> None:
    scene = scene_named("whitworth")
    others = other_branches(scene)
    assert len(others) == 2
    scan = scan_of(scene)
    flat = paths_of(others[meant], scan.points)(scan.coordinate)
    positions = scan.anchor + flat.real[..., None] * RIGHT + flat.imag[..., None] * UP
    identity, machine = identify(scene, replace(scan, positions=positions), GivenFrame(rotation=0.0, zero=0.0))
    assert identity.other_branch
    assert identity.largest < 1e-9
    assert machine.mechanism().poses == others[meant].described.poses


def test_points_that_do_not_move_in_a_plane_are_refused() -> None:
    scan = scan_of(SAW)
    still = replace(scan, positions=np.zeros_like(scan.positions))
    leaving = scan.positions.copy()
    leaving[1, 7] += 0.01 * AXIS
    for wrong, message in (
        (still, "the crank turns and nothing moves, of C, M: the plane cannot be determined"),
        (
            replace(scan, wander=0.0123),
            "the crank's axis itself moves, by 0.0123 (of the model's unit of length) in a turn: there is no plane of "
            "motion; the crank is to turn about a fixed axis",
        ),
        (
            replace(scan, positions=leaving),
            "M leaves the plane across the crank's axis by 0.01 (of the model's unit of length): the plane of motion "
            "cannot be determined",
        ),
    ):
        with pytest.raises(InvalidInput) as refused:
            identify(SAW, wrong, GivenFrame())
        assert str(refused.value) == message


@pytest.mark.parametrize(("unit", "limit"), [(1.0, 1e-6), (1e-3, 1e-6 * 1e3 * 2.0 * SAW.crank)])
def test_axis_may_move_by_a_millionth_of_span_or_of_a_unit(unit: float, limit: float) -> None:
    # Paths are as long as the stroke, of some two cranks: 0.2 of the unit in m, 200 in mm.
    scan = scan_of(SAW, unit=unit)
    for factor in (0.9, 1.1):
        moved = replace(scan, wander=factor * limit)
        with pytest.raises(InvalidInput, match="axis itself moves") if factor > 1.0 else nullcontext():
            assert identify(SAW, moved, GivenFrame())[0].is_machine(1e-9)


# -- references ------------------------------------------------------------------------------------------------------


def test_lengths_of_a_machine_are_its_parameters_in_metres() -> None:
    assert length_names(SAW) == ("crank", "rod", "offset", "all lengths")
    assert [length_of(SAW, name) for name in length_names(SAW)] == [0.1, 0.3, 0.09, 1.0]
    assert with_lengths(SAW, (), np.array([])) is SAW
    assert with_lengths(SAW, ["rod"], np.array([0.31])) == replace(SAW, rod=0.31)
    both = with_lengths(SAW, ["rod", ALL_LENGTHS], np.array([0.31, 2.0]))
    assert [both.parameters[name] for name in ("crank", "rod", "offset")] == pytest.approx([0.2, 0.62, 0.18])
    assert (both.speed, both.parameters["rod_mass"]) == (SAW.speed, SAW.rod_mass)
    assert shaft_of(SAW) == pytest.approx(SAW.shaft)


def test_paths_are_around_the_shaft() -> None:
    angle = np.array([0.0, 1.0, 2.0])
    found = paths_of(SAW, ["M", "C"])(angle)
    shaft = complex(*SAW.shaft)
    for row, name in zip(found, ("M", "C"), strict=True):
        place = SAW.motion(angle, 1.0).point(name).position
        assert row == pytest.approx(place[:, 0] + 1j * place[:, 1] - shaft)


@pytest.mark.parametrize(("name", "returns"), [("saw-40rpm", True), ("swinging-four-bar", False)])
def test_points_return_after_a_turn_but_of_one_pass(name: str, returns: bool) -> None:
    assert returns_after_turn(scene_named(name)) is returns


@pytest.mark.parametrize("factor", [1e-4, 1.0, 1e4])
@pytest.mark.parametrize(("name", "returns"), [("saw-40rpm", True), ("planetary-gear", False)])
def test_points_return_or_not_when_a_machine_is_tiny_or_huge(name: str, returns: bool, factor: float) -> None:
    scene = scene_named(name)
    sized = with_lengths(scene, [ALL_LENGTHS], np.array([factor]))
    assert sized.kinematics.size == pytest.approx(factor * scene.kinematics.size)
    assert returns_after_turn(sized) is returns


def test_slider_crank_has_one_other_branch_for_any_lengths() -> None:
    (other,) = other_branches(SAW)
    # The rod leads to the other side: the slider is as far beyond the pin as it was before it.
    pin = SAW.shaft[0] + 0.1
    assert other.motion(np.zeros(1), 1.0).point("C").position[0] == pytest.approx([2.0 * pin, 0.0], abs=1e-9)
    assert with_branch_of(SAW, None) is SAW
    assert with_branch_of(other, other) is other
    longer = with_branch_of(replace(SAW, rod=0.31), other)
    reach, shaft = math.sqrt(0.31**2 - 0.09**2), replace(SAW, rod=0.31).shaft
    assert longer.motion(np.zeros(1), 1.0).point("C").position[0] == pytest.approx(
        [shaft[0] + 0.1 + reach, 0.0], abs=1e-9
    )


def test_assembly_is_tried_from_even_turns_and_their_mirrors(monkeypatch: pytest.MonkeyPatch) -> None:
    mechanism, start = SAW.kinematics.mechanism, SAW.kinematics.start[0].reshape(-1, 3)
    tried: list[Any] = []

    def newton(self: Any, guess: Any, *_: Any) -> Any:
        tried.append(guess.reshape(-1, 3))
        if len(tried) == 1:
            raise InvalidInput("it cannot be assembled")
        return guess

    monkeypatch.setattr(references.Equations, "newton", newton)
    # The first cannot be assembled, which stops none of the others.
    assert len(list(references._assembled_poses(SAW))) == 15
    crank = mechanism.body_index[mechanism.crank]
    rod = next(k for k in range(len(start)) if k != crank)
    for first, mirror in ((0, 1.0), (1, -1.0)):
        turns = [guess[rod, 2] - mirror * start[rod, 2] for guess in tried[first::2]]
        assert turns == pytest.approx([k * math.pi / 4.0 for k in range(8)])
        assert all(guess[crank].tolist() == start[crank].tolist() for guess in tried)


def test_uncertainty_shares_are_at_the_angle_of_largest_effect() -> None:
    slopes = {"a": np.array([[1.0, 3.0], [0.0, 2.0]]), "b": np.array([[4.0, 0.0], [0.0, 1.0]])}
    together, shares = uncertainty_shares(slopes, {"a": 1e-3, "b": 0.5e-3})
    # (3 * 1)^2 + 0 = 9 at the second angle, 1 + 4 = 5 at the first.
    assert together == pytest.approx(3e-3)
    assert shares == {"a": pytest.approx(1.0), "b": 0.0}
    together, shares = uncertainty_shares(slopes, {"a": 1e-3, "b": 1e-3})
    assert together == pytest.approx(math.sqrt(17.0) * 1e-3)
    assert shares == {"a": pytest.approx(1.0 / 17.0), "b": pytest.approx(16.0 / 17.0)}
    assert uncertainty_shares(slopes, {}) == (0.0, {"a": 0.0, "b": 0.0})
