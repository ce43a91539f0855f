"""Each part of a verdict on closed loops counts alone, and at its limit."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import pytest

from conrod.comparison.trajectory import Outcome
from conrod.errors import InvalidInput
from conrod.exact.space.mobility import Mobility
from conrod.mjcf.crank_speed import CrankSpeed
from conrod.mjcf.differences import MachineComparison
from conrod.mjcf.loop_results import (
    KINEMATIC_TOLERANCE,
    JointSpeed,
    LawComparison,
    LoopRequest,
    LoopRun,
    LoopStudy,
    ShippedRun,
    loop_limits,
)
from conrod.mjcf.request import ModelRequest, OpenStart, PointPlace, controls_of, places_of

RPM = 2.0 * math.pi / 60.0
ERRORS = {"position": 1e-3, "velocity": 0.1, "acceleration": 2.0}
RUN = LoopRun("as it is", 1e-3, Outcome.COMPLETED, errors=ERRORS, worst="A", gap=5e-4)
SHIPPED = ShippedRun("its own pose", 1.0, Outcome.COMPLETED, "", gap=1e-4)
MOBILITY = Mobility(4, 3, 3, {}, (), (), 1.0, 0.0, rigid=("A",))
STUDY = LoopStudy(
    "m.xml", "m", "MuJoCo", LoopRequest({"crank": "40rpm"}, tolerance={"position": 1e-3}), 1.0, 0.2, (), MOBILITY, 0.0,
    {"position": 1e-12, "velocity": 1e-11}, (), (), (), SHIPPED, (RUN, replace(RUN, label="tuned")), (),
    points=("A", "B"),
)  # fmt: skip
AT_SPEED = CrankSpeed(40 * RPM, 39 * RPM, 41 * RPM, 1.0)
OFF_SPEED = JointSpeed("crank", replace(AT_SPEED, mean=41 * RPM), 40 * RPM)
AJAR = OpenStart("its own pose", {"pin": 2e-4, "slide": 1.1e-3}, extent=0.5, closed="0 0")
OTHER = MachineComparison("rssr", 0.0, "A", ())


def test_a_study_in_which_all_is_well_passes() -> None:
    assert STUDY.passed
    assert not STUDY.begins_open
    assert STUDY.is_machine
    assert STUDY.agrees
    assert not STUDY.shipped_failed
    assert STUDY.driven_run is RUN


@pytest.mark.parametrize("wrong", [
    {"kinematic": {"position": 1e-12, "velocity": 2.0 * KINEMATIC_TOLERANCE}},
    {"kinematic": {"position": math.nan, "velocity": 0.0}},
    {"runs": (replace(RUN, errors=ERRORS | {"position": 1.001e-3}), RUN)},
    {"runs": (replace(RUN, gap=1.001e-3), RUN)},
    {"runs": (replace(RUN, outcome=Outcome.DIVERGED), RUN)},
    {"runs": (replace(RUN, errors={}), RUN)},
    {"runs": (replace(RUN, gap=None), RUN)},
    {"begins": AJAR},
    {"shipped": replace(SHIPPED, outcome=Outcome.OPENED)},
    {"shipped": replace(SHIPPED, chatter=("crank", 0.2))},
    {"shipped": replace(SHIPPED, gap=1.001e-3)},
    {"shipped": replace(SHIPPED, gap=math.nan)},
    {"shipped": replace(SHIPPED, laws=LawComparison((OFF_SPEED,)))},
    {"shipped": replace(SHIPPED, laws=LawComparison(other_branch=True))},
    {"compared": replace(OTHER, off=1.001e-3)},
    {"compared": replace(OTHER, off=None)},
    {"compared": replace(OTHER, other_kinds=True)},
])  # fmt: skip
def test_one_wrong_part_alone_fails_a_study(wrong: dict[str, Any]) -> None:
    assert not replace(STUDY, **wrong).passed


@pytest.mark.parametrize("right", [
    {"kinematic": {"position": KINEMATIC_TOLERANCE}},
    {"runs": (replace(RUN, errors=ERRORS | {"position": 1e-3}, gap=1e-3), replace(RUN, outcome=Outcome.DIVERGED))},
    {"shipped": replace(SHIPPED, gap=1e-3)},
    {"shipped": replace(SHIPPED, gap=0.5, driven=False)},  # that nothing drives it is said elsewhere
    {"shipped": replace(SHIPPED, laws=LawComparison((JointSpeed("crank", AT_SPEED, 40 * RPM),)))},
    {"begins": replace(AJAR, gaps={"pin": 1e-3})},
    {"compared": replace(OTHER, off=1e-3)},
    {"compared": replace(OTHER, differences=("rod is 1e-05 % longer",), loads=("rod has 2 kg",))},
])  # fmt: skip
def test_what_is_just_at_its_limit_passes(right: dict[str, Any]) -> None:
    assert replace(STUDY, **right).passed


def test_default_tolerance_is_1e_6_for_motion_and_1e_3_for_start() -> None:
    asked = replace(STUDY, question=LoopRequest({"crank": "40rpm"}))
    # 1e-6 of a travel of 0.2 m.
    assert replace(asked, compared=replace(OTHER, off=2e-7)).is_machine
    assert not replace(asked, compared=replace(OTHER, off=2.001e-7)).is_machine
    # 1e-3 of an extent of 0.5 m.
    for gap, is_open in ((5e-4, False), (5.001e-4, True)):
        assert replace(asked, begins=replace(AJAR, gaps={"pin": gap, "slide": 1e-6})).begins_open == is_open
    assert AJAR.worst == "slide"
    assert replace(asked, shipped=replace(SHIPPED, gap=0.5)).passed
    # A tolerance of nothing but the velocity says nothing of how far loops open.
    fast = replace(asked, question=replace(asked.question, tolerance={"velocity": 0.1}))
    assert replace(fast, shipped=replace(SHIPPED, gap=0.5), runs=(replace(RUN, gap=0.5),)).passed


def test_the_positions_tolerance_bounds_the_opening_of_loops_too() -> None:
    assert loop_limits({"position": 1e-3, "velocity": 0.2}) == {"position": 1e-3, "velocity": 0.2, "loops": 1e-3}
    assert loop_limits({"velocity": 0.2}) == {"velocity": 0.2}
    off = replace(RUN, gap=2e-3).exceeded_limits({"position": 1e-4, "velocity": 0.1, "acceleration": 1.9})
    assert off == {"position": (1e-3, 1e-4), "acceleration": (2.0, 1.9), "loops": (2e-3, 1e-4)}
    assert RUN.judged_error("loops") == 5e-4
    assert RUN.judged_error("velocity") == 0.1
    assert math.isnan(RUN.judged_error("force"))
    assert math.isnan(replace(RUN, gap=None).judged_error("loops"))


@pytest.mark.parametrize(("points", "alone"), [(("A",), True), (("A", "B"), False), (("B",), False), ((), False)])
def test_loops_alone_are_judged_when_closures_move_no_point(points: tuple[str, ...], alone: bool) -> None:
    assert replace(STUDY, points=points).judges_loops_alone is alone


# -- speeds ------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("mean", "least", "most", "allowed", "strays"), [
    (40.0, 36.1, 43.9, 0.01, False),
    (40.39, 40.0, 41.0, 0.01, False),
    (40.41, 40.0, 41.0, 0.01, True),
    (39.61, 39.0, 40.0, 0.01, False),
    (39.59, 39.0, 40.0, 0.01, True),
    (40.0, 35.9, 41.0, 0.01, True),  # a tenth of the speed, at its slowest
    (40.0, 39.0, 44.1, 0.01, True),  # at its fastest
    (40.0, 39.0, 44.1, 0.2, False),  # whoever allows a fifth of the mean allows it of the rest
    (47.0, 39.0, 47.9, 0.2, False),
    (-40.0, -41.0, -39.0, 0.01, True),
    (math.nan, 39.0, 41.0, 0.01, True),
    (40.0, 39.0, math.nan, 0.01, True),
])  # fmt: skip
def test_a_speed_strays_by_its_mean_its_slowest_or_its_fastest(
    mean: float, least: float, most: float, allowed: float, strays: bool
) -> None:
    speed = JointSpeed("crank", CrankSpeed(mean * RPM, least * RPM, most * RPM), 40 * RPM, allowed)
    assert speed.strays is strays
    assert LawComparison((speed,)).strayed == ((speed,) if strays else ())
    assert LawComparison((speed,)).differs is strays
    # Both backwards: the same.
    assert JointSpeed("crank", CrankSpeed(-mean * RPM, -most * RPM, -least * RPM), -40 * RPM, allowed).strays is strays


def test_speed_strays_beyond_one_per_cent_unless_more_is_allowed() -> None:
    for mean, strays in ((40.39, False), (40.41, True)):
        assert CrankSpeed(mean * RPM, 40 * RPM, 41 * RPM).strays(40 * RPM) is strays
        assert JointSpeed("crank", CrankSpeed(mean * RPM, 40 * RPM, 41 * RPM), 40 * RPM).strays is strays
    assert not CrankSpeed(80.0, 48.0, 80.0).strays(64.0, 0.25)  # exactly a quarter


@pytest.mark.parametrize(("turns", "still"), [(0.0, True), (0.01, True), (0.0101, False), (math.inf, False)])
def test_a_crank_within_a_hundredth_of_a_turn_stands_still(turns: float, still: bool) -> None:
    assert CrankSpeed(0.0, 0.0, 0.0, turns).is_still is still
    assert not CrankSpeed(0.0, 0.0, 0.0).is_still


# -- what is asked for -------------------------------------------------------------------------------------------------


def test_places_are_sites_unless_their_kind_is_said() -> None:
    given = {"A": "tip", "B": "body:bow", "C": "geom:rod", "D": "site:x:y", "E": "left:pin", "F": "site:"}
    assert places_of(given) == (
        PointPlace("A", "site", "tip"),
        PointPlace("B", "body", "bow"),
        PointPlace("C", "geom", "rod"),
        PointPlace("D", "site", "x:y"),
        PointPlace("E", "site", "left:pin"),
        PointPlace("F", "site", ""),
    )
    assert str(PointPlace("C", "geom", "rod")) == "geom:rod"
    assert places_of({"M": "tip"}, ("C", "M")) == (PointPlace("M", "site", "tip"),)
    with pytest.raises(InvalidInput, match=r"unknown observed point 'N': .*choose from C, M"):
        places_of({"N": "tip"}, ("C", "M"))
    with pytest.raises(InvalidInput, match=r"unknown kind of element 'joint': .*choose from body, geom, site"):
        places_of({"C": "joint:"})
    with pytest.raises(InvalidInput, match=r"^points = 'C': give a mapping, such as \{'C': 'site:tip'\}$"):
        places_of("C")  # type: ignore[arg-type]


def test_controls_are_finite_numbers_by_name() -> None:
    assert controls_of({"motor": 4, "0": -0.5}) == (("motor", 4.0), ("0", -0.5))
    assert isinstance(controls_of({"motor": 4})[0][1], float)
    for bad in (math.inf, math.nan, "4", None, 4j):
        form = f"--ctrl 'motor={bad}': give an actuator and a finite number in MuJoCo's units: motor=4.19"
        with pytest.raises(InvalidInput) as refused:
            controls_of({"motor": bad})  # type: ignore[dict-item]
        assert str(refused.value) == form
    with pytest.raises(InvalidInput, match=r"^controls = 4: give a mapping, such as \{'motor': 4.19\}$"):
        controls_of(4)  # type: ignore[arg-type]


def test_a_crank_goes_through_a_turn_or_its_pass() -> None:
    asked = ModelRequest("crank", (), 1, 0)
    assert asked.width == pytest.approx(6.283185307179586, rel=1e-15)
    assert replace(asked, span=(-0.5, 1.25)).width == 1.75
