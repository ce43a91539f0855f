"""Flights of a follower: found in a gap that comes in pieces, and in a run that lost its cam."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from catalogue import CAM, SAW
from watched import coarse_cam, extremes, watched

from conrod import MuJoCoSettings, PymunkSettings
from conrod.exact.motion import Array
from conrod.scenes import CamFollower
from conrod.studies.limits.recorders import KEPT, LEAST_DEPTH, TIMES, Flights
from conrod.studies.limits.records import Flight

STEP = 1e-3  # [rad]
HELD = 500
DEPTH = 1e-6  # [m], of the synthetic follower


def gaps(*flights: Flight) -> tuple[Array, Array]:
    """A follower that sinks in by a depth, but for parabolic flights."""
    angle = STEP * np.arange(6001)
    gap = np.full_like(angle, -DEPTH)
    for flight in flights:
        across = (angle - flight.start) / (flight.landing - flight.start)
        gap = np.maximum(gap, 4.0 * flight.gap * across * (1.0 - across))
    return angle, gap


def followed(angle: Array, gap: Array, length: int, travel: float = 1.0) -> Flights:
    flights = Flights(HELD, travel)
    for begin in range(0, len(angle), length):
        flights.add(angle[begin : begin + length], gap[begin : begin + length])
    return flights


@pytest.mark.parametrize("length", [1, 7, 499, 10_000])
def test_flights_are_found_across_the_borders_of_pieces(length: int) -> None:
    planted = Flight(1.5, 3.0, 0.01), Flight(4.0, 4.2, 1e-3)
    flights = followed(*gaps(*planted), length)
    assert flights.penetration == DEPTH
    found = flights.found()
    assert len(found) == 2
    for flight, exact in zip(found, planted, strict=True):
        # A parabola passes the threshold a little later than it leaves the ground.
        late = TIMES * DEPTH / (4.0 * exact.gap) * (exact.landing - exact.start)
        assert flight.start == pytest.approx(exact.start + late, abs=0.1 * late + 1e-5)
        assert flight.landing == pytest.approx(exact.landing - late, abs=0.1 * late + 1e-5)
        assert flight.gap == pytest.approx(exact.gap, rel=1e-4)
    assert found == followed(*gaps(*planted), 100).found()


def test_a_hop_below_ten_depths_is_no_flight() -> None:
    hop = gaps(Flight(2.0, 2.1, 0.9 * TIMES * DEPTH))
    assert followed(*hop, 100).found() == ()
    leap = gaps(Flight(2.0, 2.1, 1.1 * TIMES * DEPTH))
    assert len(followed(*leap, 100).found()) == 1


def test_without_a_depth_the_travel_sets_the_threshold() -> None:
    angle, gap = gaps(Flight(2.0, 2.1, 1e-3))
    held = np.where(gap < 0.0, 0.0, gap)
    flights = followed(angle, held, 100)
    assert flights.penetration == 0.0
    assert flights.threshold == TIMES * LEAST_DEPTH
    assert len(flights.found()) == 1
    assert followed(angle, held, 100, travel=2e3).found() == ()


def test_a_flight_at_the_start_and_one_at_the_end_are_flights() -> None:
    angle, gap = gaps(Flight(-0.5, 0.2, 0.01), Flight(5.5, 7.0, 0.01))
    last, first = followed(angle, gap, 100).found()
    assert (first.start, last.landing) == (angle[0], angle[-1])
    assert first.landing == pytest.approx(0.2, abs=1e-3)
    assert last.start == pytest.approx(5.5, abs=1e-3)


def test_the_longest_are_kept_and_the_longest_comes_first() -> None:
    planted = [Flight(0.6 + 0.04 * k, 0.6 + 0.04 * k + 0.002 * (k % 15 + 2), 1e-3) for k in range(130)]
    angle, gap = gaps(*planted)
    found = followed(angle, gap, 100).found()
    lengths = [flight.landing - flight.start for flight in found]
    assert len(found) == KEPT
    assert lengths == sorted(lengths, reverse=True)
    assert min(lengths) > 0.028


@pytest.mark.parametrize("settings", [MuJoCoSettings.tuned, PymunkSettings.tuned], ids=["mujoco", "pymunk"])
def test_a_follower_that_lost_its_cam_is_followed_until_it_lands(settings: Any) -> None:
    cam: Any = CamFollower(preload=0.3)
    lost = watched(cam, coarse_cam(settings(cam, 1000)), 1.0)
    assert (lost.outcome, lost.errors) == ("lost-contact", None)
    seen = extremes(lost)
    assert seen.samples == 1001
    assert seen.penetration is not None
    assert 0.0 < seen.penetration < 1e-3
    flight = seen.flights[0]
    assert flight.landing - flight.start > 1.5
    assert 0.04 < flight.gap < 0.06
    held = extremes(watched(CAM, coarse_cam(settings(CAM, 1000)), 1.0))
    assert held.flights == ()


def test_a_linkage_has_no_follower() -> None:
    seen = extremes(watched(SAW, PymunkSettings.tuned(SAW, 100)))
    assert (seen.penetration, seen.flights) == (None, ())
