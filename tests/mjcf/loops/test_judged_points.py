"""Verdicts on closed loops look at what the loops move: judged points, the loops themselves, and what is left out."""

from __future__ import annotations

import math
import re
from dataclasses import replace
from functools import cache
from pathlib import Path

import mujoco
import pytest

from conrod.comparison.trajectory import Outcome
from conrod.mjcf.loop_results import LOOPS, LoopRequest, LoopRun, LoopStudy, ShippedRun
from conrod.models.loops import study
from conrod.models.loops.report import finding

CASES = Path(__file__).parents[2] / "data" / "cases"
LEG = CASES / "strut-leg.xml"
LEG_DRIVES = {"leg_length": "sine:50mm,1Hz", "hip_pitch": "sine:20deg,1Hz"}
ALLOWED = 1e-5  # [m]

# A pinion drives a gear by an equality: their frames stand still, and the only site is on the driven pinion.
GEARS = """<mujoco><option gravity="0 0 0"/><worldbody>
  <body name="pinion"><joint name="pinion" axis="0 0 1"/><geom type="cylinder" size="0.02 0.01" contype="0"
    conaffinity="0"/><site name="tooth" pos="0.02 0 0"/></body>
  <body name="gear" pos="0.1 0 0"><joint name="gear" axis="0 0 1"/><geom type="cylinder" size="0.08 0.01" contype="0"
    conaffinity="0"/></body></worldbody>
  <equality><joint name="mesh" joint1="gear" joint2="pinion" polycoef="0 -0.25 0 0 0"/></equality></mujoco>"""

# A four-bar of 120, 340, 280 and 360 mm whose bodies stand at their pins: the loop moves no frame of it.
BARS = """<mujoco><option timestep="0.002"/><default><geom type="capsule" size="0.01" contype="0" conaffinity="0"/>
  <joint axis="0 -1 0"/></default><worldbody>
  <body name="crank"><joint name="crank"/><geom fromto="0 0 0 0.0771345132 0 0.0919253332"/>
    <body name="coupler" pos="0.0771345132 0 0.0919253332"><joint name="pin"/>
      <geom fromto="0 0 0 0.2832455061 0 0.1880744089"/></body></body>
  <body name="rocker" pos="0.36 0 0"><joint name="rocker"/>
    <geom fromto="0 0 0 0.0003800193 0 0.2799997421"/></body></worldbody>
  <equality><connect body1="coupler" body2="rocker" anchor="0.2832455061 0 0.1880744089"/></equality></mujoco>"""


def judged_points(text: str, drives: dict[str, str]) -> set[str]:
    bench = study._LoopBench.from_request(mujoco.MjModel.from_xml_string(text), LoopRequest(drives, seconds=1.0))
    return {point.name for point in bench.points}


@cache
def leg(*points: str) -> LoopStudy:
    """The leg with its steps refined and coarsened once; whoever edits it takes a copy."""
    with pytest.MonkeyPatch.context() as patch:
        for name, cheap in {"COARSER": (4,), "FINER": (), "CHECKED_INSTANTS": 9}.items():
            patch.setattr(study, name, cheap)
        patch.setattr("conrod.execution.paired_timing.BLOCK_TIME", 2e-5)
        return study.study_loops(LEG, LoopRequest(LEG_DRIVES, points=points, tolerance={"position": ALLOWED}), "leg")


# -- judged points -----------------------------------------------------------------------------------------------------


def test_judged_points_are_those_that_closures_move() -> None:
    # strut_end is rigid with the driven strut, and the femur's frame lies on its own hinge's axis.
    assert judged_points(LEG.read_text(), LEG_DRIVES) == {"shin"}
    # Driven otherwise the closure moves the strut, and its site is judged.
    driven = {"femur": "sine:5deg,1Hz", "hip_pitch": "sine:20deg,1Hz"}
    assert judged_points(LEG.read_text(), driven) == {"strut_end"}


def test_points_on_driven_bodies_judge_loops_alone_and_say_so() -> None:
    found = leg("strut_end")
    assert found.judges_loops_alone
    assert found.driven_run.errors["position"] < 1e-12
    assert not found.passed
    words = finding(found)
    assert "Not judged: what moves by the loops: strut_end is rigid with what is driven (--point takes shin);" in words
    assert leg().moved == ()
    assert re.search(r"OUT OF TOLERANCE \(loops open 0\.15 mm \(.{3,7} L\), allowed 0\.010 mm \(.{3,7} L\)\)", words)
    assert not leg().judges_loops_alone


def test_gears_whose_frames_stand_still_are_judged_off_axes() -> None:
    # The radius of gyration of the cylinder about its axis is its radius over sqrt(2).
    assert judged_points(GEARS, {"pinion": "60rpm"}) == {"gear 56.6 mm off its axis"}
    assert judged_points(GEARS, {"gear": "60rpm"}) == {"tooth"}


@cache
def bars() -> LoopStudy:
    """The four-bar without sites, studied once."""
    with pytest.MonkeyPatch.context() as patch:
        for name, cheap in {"COARSER": (4,), "FINER": (1,), "CHECKED_INSTANTS": 9}.items():
            patch.setattr(study, name, cheap)
        patch.setattr("conrod.execution.paired_timing.BLOCK_TIME", 2e-5)
        request = LoopRequest({"crank": "60rpm"}, tolerance={"position": 1e-5})
        bench = study._LoopBench.from_request(mujoco.MjModel.from_xml_string(BARS), request)
        return bench.study("bars.xml", "bars", None)


def test_links_without_sites_are_judged_at_centres_of_gravity() -> None:
    assert bars().points == ("centre of gravity of coupler", "centre of gravity of rocker")
    assert not bars().judges_loops_alone
    # A frame at a driven pin would be "within tolerance" however far the loops open.
    assert bars().driven_run.errors["position"] > 1e-5
    assert not bars().passed
    # Where the loops stay closed the points are where the exact ones are, and move as these do.
    hardened = next(run for run in bars().runs if run.label == "hardened")
    assert hardened.errors["position"] < 1e-7
    assert hardened.errors["velocity"] < 1e-6
    assert hardened.errors["acceleration"] < 1e-4
    assert max(bars().kinematic.values()) < 1e-9  # position, velocity and acceleration beside a frame


# -- the loops ---------------------------------------------------------------------------------------------------------


def test_tolerance_of_position_bounds_how_far_loops_open() -> None:
    exact = LoopRun("as it is", 1e-3, Outcome.COMPLETED, "", {"position": 0.0, "velocity": 0.0}, "P", 3e-3)
    assert exact.exceeded_limits({"position": 1e-3}) == {LOOPS: (3e-3, 1e-3)}
    assert not exact.is_within({"position": 1e-3})
    assert exact.is_within({"position": 3e-3})
    assert exact.is_within({"velocity": 1e-9})
    assert not replace(exact, gap=math.nan).is_within({"position": 1.0})


def test_strut_leg_fails_and_no_open_run_is_recommended() -> None:
    found = leg()
    assert not found.passed
    assert found.driven_run.errors["position"] == pytest.approx(0.123e-3, rel=0.02)
    assert found.driven_run.gap == pytest.approx(0.15e-3, rel=0.05)
    coarse = next(run for run in found.steps if run.label == "as it is")
    assert coarse.gap > 50.0 * ALLOWED
    assert found.cheapest is not None
    assert found.cheapest.label != "as it is"
    assert found.cheapest.gap < ALLOWED


# -- the file as it is, and what is not judged -------------------------------------------------------------------------


def test_what_is_not_judged_is_named_in_the_finding() -> None:
    words = finding(leg())
    assert words.startswith("Run as the file has it, from its own pose, it runs through its 1 s")
    assert ": not judged, nothing drives it (no control and no rate at its start). Driven with its own" in words
    assert (
        "Not judged: velocity and acceleration; forces: torques of drives and reactions bear the force of actuator"
        in words
    )
    assert (
        "limit of joint ankle_pitch too, which the exact ones do not have; what ankle_pitch moves, which the" in words
    )
    every = replace(leg().question, tolerance={"position": 1.0, "velocity": 1.0, "acceleration": 1e3})
    assert "Not judged: forces: torques" in finding(replace(leg(), question=every))
    alone = replace(leg(), runs=tuple(replace(run, acting=()) for run in leg().runs), question=every)
    assert "Not judged: forces; what ankle_pitch" in finding(alone)


@pytest.mark.parametrize(("gap", "driven", "passes"), [
    (0.5 * ALLOWED, True, True), (2.0 * ALLOWED, True, False), (2.0 * ALLOWED, False, True),
])  # fmt: skip
def test_a_driven_own_run_is_held_to_the_tolerance(gap: float, driven: bool, passes: bool) -> None:
    shipped = ShippedRun("its own pose", 1.0, Outcome.COMPLETED, "", gap, driven=driven)
    tuned = next(run for run in leg().runs if run.label == "tuned")
    found = replace(leg(), runs=(tuned,), shipped=shipped)
    assert tuned.is_within(found.question.tolerance)
    assert found.passed == passes
    assert ("OUT OF TOLERANCE (allowed 0.010 mm (" in finding(found)) != passes
