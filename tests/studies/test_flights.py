"""Flights of a follower: found in a gap that comes in pieces, and in a run that lost its cam."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from catalogue import CAM
from watched import coarse_cam, extremes, watched

from conrod import MuJoCoSettings, PymunkSettings
from conrod.exact.motion import Array
from conrod.scenes import CamFollower
from conrod.studies.limits.recorders import LEAST_DEPTH, TIMES, Flights
from conrod.studies.limits.records import Flight

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


def followed(angle: Array, gap: Array, length: int, travel: float = 1.0) -> Flights:
    flights = Flights(HELD, travel)
    for begin in range(0, len(angle), length):
        flights.add(angle[begin : begin + length], gap[begin : begin + length])
    return flights


@pytest.mark.parametrize("length", [1, 7, 499, 10_000])
def test_the_longest_flight_is_found_across_the_borders_of_pieces(length: int) -> None:
    planted = Flight(1.5, 3.0), Flight(4.0, 4.2)
    for exact, shown in ((planted[0], planted), (planted[1], planted[1:])):
        flights = followed(*gaps(*shown), length)
        assert flights.penetration == DEPTH
        found = flights.longest()
        assert found is not None
        # A parabola passes the threshold a little later than it leaves the ground.
        late = TIMES * DEPTH / (4.0 * HEIGHT) * exact.length
        assert found.start == pytest.approx(exact.start + late, abs=0.1 * late + 1e-5)
        assert found.landing == pytest.approx(exact.landing - late, abs=0.1 * late + 1e-5)


def test_a_hop_below_ten_depths_is_no_flight() -> None:
    assert followed(*gaps(Flight(2.0, 2.1), height=0.9 * TIMES * DEPTH), 100).longest() is None
    assert followed(*gaps(Flight(2.0, 2.1), height=1.1 * TIMES * DEPTH), 100).longest() is not None


def test_without_a_depth_the_travel_sets_the_threshold() -> None:
    angle, gap = gaps(Flight(2.0, 2.1), height=1e-3)
    held = np.where(gap < 0.0, 0.0, gap)
    flights = followed(angle, held, 100)
    assert (flights.penetration, flights.threshold) == (0.0, TIMES * LEAST_DEPTH)
    assert flights.longest() is not None
    assert followed(angle, held, 100, travel=2e3).longest() is None


def test_a_flight_at_the_start_and_one_at_the_end_are_flights() -> None:
    for planted in (Flight(-0.5, 0.2), Flight(5.5, 7.0)):
        found = followed(*gaps(planted), 100).longest()
        assert found is not None
        ends = max(planted.start, 0.0), min(planted.landing, 6.0)
        assert (found.start, found.landing) == pytest.approx(ends, abs=1e-3)


@pytest.mark.parametrize("settings", [MuJoCoSettings.tuned, PymunkSettings.tuned], ids=["mujoco", "pymunk"])
def test_a_follower_that_lost_its_cam_is_followed_until_it_lands(settings: Any) -> None:
    cam: Any = CamFollower(preload=0.3)
    lost = watched(cam, coarse_cam(settings(cam, 1000)), 1.0)
    assert (lost.outcome, lost.errors) == ("lost-contact", None)
    seen = extremes(lost)
    assert seen.samples == 1001
    assert seen.penetration is not None
    assert 0.0 < seen.penetration < 1e-3
    assert seen.flights[0].length > 1.5
    held = extremes(watched(CAM, coarse_cam(settings(CAM, 1000)), 1.0))
    assert held.flights == ()
