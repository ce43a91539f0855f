"""Flights of a follower and their onset: found in gaps, in laws and in real engines; a wrong force is seen."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from cell_tasks import answer_study

from conrod import MuJoCoSettings, PymunkSettings
from conrod.exact.motion import Array
from conrod.execution.run import RunResult
from conrod.report.table import ColouredCell
from conrod.scenes import CamFollower
from conrod.studies.limits.case import LimitCase, Setup
from conrod.studies.limits.follower_float import ONSET_STEPS, ONSET_TOLERANCE, FollowerFloat, onset_search
from conrod.studies.limits.recorders import FLIGHT_DEPTH_RATIO, FlightRecorder
from conrod.studies.limits.records import Flight, LimitResult
from conrod.studies.limits.tables import onset_table

CAM = CamFollower()
PENETRATION = 1e-9  # [m]
LANDING = 205.1191  # [deg], of the exact flight at 1.2 times the float speed


def case(engine: str = "pymunk", preset: str = "tuned") -> Setup:
    return Setup("cam-follower", CAM, engine, preset)


def found_with(force: float = 1.0) -> FollowerFloat:
    """What is found where a follower flies for a time that grows beyond the float speed, and one that the step shrinks.

    The force that really acts is so much of the one that is meant.
    """

    def flown(cell: LimitCase) -> RunResult:
        length = 0.1 * max(1.0 - force * cell.scene.preload, 0.0) + 6.0 / cell.settings.steps_per_revolution
        flights = (Flight(1.0, 1.0 + length),)
        return LimitResult(samples=1, penetration=PENETRATION, flights=flights)

    return answer_study(onset_search(case()), flown)


def test_the_onset_is_where_flights_stop_shrinking_with_the_step() -> None:
    good = found_with()
    assert good.theory == pytest.approx(5.0)
    assert good.onset == pytest.approx(1.0, abs=0.003)
    # There are flights below, as there are in an engine, and they shrink.
    below = [probe for probe in good.probes if probe.speed < 0.998]
    assert below
    assert all(probe.lengths[0] > 0.0 and not probe.flies for probe in below)
    # Negative control: a force six per cent too large moves the onset by its root.
    found = found_with(force=1.06)
    assert found.onset == pytest.approx(math.sqrt(1.06), abs=0.003)
    assert ColouredCell("not within 2 %", "bad") in onset_table([found]).rows[0]


def test_speed_without_a_flight_is_not_run_with_a_finer_step() -> None:
    def flown(cell: LimitCase) -> RunResult:
        flights = (Flight(1.0, 1.2),) if cell.scene.preload < 1.0 else ()
        return LimitResult(samples=1, penetration=PENETRATION, flights=flights)

    found = answer_study(onset_search(case()), flown)
    assert found.onset == pytest.approx(1.0, abs=0.003)
    for probe in found.probes:
        assert probe.lengths == ((0.0, None) if probe.speed < found.onset else pytest.approx((0.2, 0.2)))


# -- real engines ------------------------------------------------------------------------------------------------------


def run_at(speed: float, engine: str, force: float = 1.0) -> LimitResult:
    """A run at a speed over the float speed, at 20000 steps a revolution."""
    scene = CAM.with_parameters(speed=speed * 5.0, preload=force / speed**2)
    cell = LimitCase("cam-follower", scene, case(engine).settings(scene, ONSET_STEPS[0]), 0.65)
    return cell.perform()


@pytest.mark.parametrize("engine", ["mujoco", "pymunk"])
def test_engines_fly_as_far_as_the_exact_parabola(engine: str) -> None:
    assert run_at(0.9, engine).flights == ()
    (flight,) = run_at(1.2, engine).flights
    assert math.degrees(flight.landing) == pytest.approx(LANDING, abs=0.1)
    # Negative control: six per cent more force are seen.
    (short,) = run_at(1.2, engine, force=1.06).flights
    assert LANDING - math.degrees(short.landing) > 1.0


@pytest.mark.slow
@pytest.mark.parametrize(("engine", "preset"), [("mujoco", "tuned"), ("pymunk", "tuned"), ("pymunk", "stock")])
def test_onset_is_within_two_per_cent_of_theory(engine: str, preset: str) -> None:
    assert answer_study(onset_search(case(engine, preset))).onset == pytest.approx(1.0, abs=ONSET_TOLERANCE)


STEP = 1e-3  # [rad]
HELD = 500
DEPTH, HEIGHT = 1e-6, 0.01  # [m], of the synthetic follower and its flights


def gaps(*flights: Flight, height: float = HEIGHT) -> tuple[Array, Array]:
    """A follower that sinks in by a depth, but for parabolic flights."""
    angle = STEP * np.arange(6001)
    gap = np.full_like(angle, -DEPTH)
    for flight in flights:
        across = (angle - flight.start) / (flight.landing - flight.start)
        gap = np.maximum(gap, 4.0 * height * across * (1.0 - across))
    return angle, gap


@pytest.mark.parametrize("length", [1, 499, 10_000])
def test_longest_flight_is_found_across_borders_of_pieces(length: int) -> None:
    planted = Flight(1.5, 3.0)
    # Beside it a shorter one, or none; and a hop below ten depths, which is no flight.
    for others in ((Flight(4.0, 4.2),), ()):
        angle, gap = gaps(planted, *others)
        gap = np.maximum(gap, gaps(Flight(3.5, 5.9), height=0.9 * FLIGHT_DEPTH_RATIO * DEPTH)[1])
        flights = FlightRecorder(HELD, 1.0)
        for begin in range(0, len(angle), length):
            flights.add(angle[begin : begin + length], gap[begin : begin + length])
        assert flights.penetration == DEPTH
        found = flights.longest_flight()
        # A parabola passes the threshold a little later than it leaves the ground.
        late = FLIGHT_DEPTH_RATIO * DEPTH / (4.0 * HEIGHT) * planted.length
        assert found.start == pytest.approx(planted.start + late, abs=0.1 * late + 1e-5)
        assert found.landing == pytest.approx(planted.landing - late, abs=0.1 * late + 1e-5)


@pytest.mark.parametrize("settings", [MuJoCoSettings.tuned, PymunkSettings.tuned], ids=["mujoco", "pymunk"])
def test_a_follower_that_lost_its_cam_is_followed_until_it_lands(settings: Any) -> None:
    def run(scene: CamFollower) -> RunResult:
        made = replace(settings(scene, 1000), cam_vertices=400)  # a cam of few facets is made sooner
        return LimitCase("cam-follower", scene, made, 1.0).perform()

    lost = run(CamFollower(preload=0.3))
    assert (lost.outcome, lost.errors) == ("lost-contact", None)
    seen, held = lost, run(CAM)
    assert seen.samples == held.samples == 1001
    assert 0.0 < seen.penetration < 1e-3
    assert seen.flights[0].length > 1.5
    assert held.flights == ()
