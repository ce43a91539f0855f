"""The exact flight of a follower, against independent arithmetic, an integration, fifty digits and its own limits."""

from __future__ import annotations

import math
from collections.abc import Callable

import mpmath
import numpy as np
import pytest
from short_flights import short_flight

from conrod.mechanism.cam import symmetric_cam
from conrod.scenes import CamFollower
from conrod.studies.limits.exact_flight import (
    LEAST_HEIGHT,
    Fall,
    exact_flight,
    fall_per_radian,
    float_speed,
    separation,
)

CAM = CamFollower()
ONE_CIRCLE = CAM.with_parameters(flank_radius=CAM.least_flank_radius)


def at(speed: float, cam: CamFollower = CAM) -> CamFollower:
    """The cam at a speed over its float speed, the force kept."""
    return cam.with_parameters(speed=speed * float_speed(cam), preload=1.0 / speed**2)


@pytest.mark.parametrize("speed", [0.2, 0.99, 1.0])
def test_a_follower_is_held_up_to_the_float_speed(speed: float) -> None:
    assert exact_flight(at(speed)) is None


@pytest.mark.parametrize("speed", [1.0002, 1.01, 1.2, 3.0])
def test_it_parts_at_the_joint_of_flank_and_nose(speed: float) -> None:
    flight = exact_flight(at(speed))
    assert flight is not None
    assert flight.start == CAM.joint_angles[1]


def test_on_one_circle_it_parts_where_the_acceleration_just_falls_below_the_force() -> None:
    scene = at(1.5, ONE_CIRCLE)
    start = separation(scene)
    assert start is not None
    excess = scene.motion([start - 1e-9, start + 1e-9], 1.0).point("roller").acceleration[:, 1] + fall_per_radian(scene)
    assert excess[0] > 0.0 > excess[1]
    flight = exact_flight(scene)
    assert flight is not None
    assert flight.gap > 0.01 * scene.full_lift


@pytest.mark.parametrize("speed", [1.05, 2.0])
def test_an_integration_in_time_with_the_cam_as_points_finds_the_same_flight(speed: float) -> None:
    scene = at(speed)
    flight = exact_flight(scene)
    assert flight is not None
    cam = symmetric_cam(scene.base_radius, scene.flank_radius, scene.nose_radius, scene.centre_distance)
    outline = cam.points(np.linspace(0.0, 2.0 * np.pi, 100001))

    def gap(angle: float, height: float) -> float:
        """Distance from the roller's centre to the nearest point of the turned outline, less its radius."""
        c, s = math.cos(angle - 0.5 * math.pi), math.sin(angle - 0.5 * math.pi)
        x, y = c * outline[:, 0] - s * outline[:, 1], s * outline[:, 0] + c * outline[:, 1]
        return float(np.sqrt((x**2 + (y - height) ** 2).min())) - scene.roller_radius

    # Start from differences of the position alone, and from there by the mid-point rule, exact for a constant force.
    rise = 1e-6
    heights = scene.motion([flight.start - rise, flight.start], 1.0).point("roller").position[:, 1]
    curvature = scene.motion(flight.start, 1.0, side="left").point("roller").acceleration[0, 1]
    height = heights[1]
    velocity = (heights[1] - heights[0]) / rise * scene.speed + 0.5 * curvature * rise * scene.speed
    acceleration = -scene.preload_force / scene.follower_mass
    steps = 100
    h = (flight.landing - flight.start) / scene.speed / steps
    gaps = []
    for n in range(steps):
        height += h * velocity + 0.5 * h**2 * acceleration
        velocity += h * acceleration
        gaps.append(gap(flight.start + (n + 1) * h * scene.speed, height))
    # Outline points are 7e-6 m apart or less, which is 2e-10 m of the distance; the difference of heights leaves 1e-10.
    assert gaps[-1] == pytest.approx(0.0, abs=2e-9)
    assert min(gaps[2:-1]) > 0.0
    assert max(gaps) == pytest.approx(flight.gap, rel=5e-4)
    # Negative control: with a force one per cent off, it is not on the cam there.
    off = 0.01 * 0.5 * abs(acceleration) * ((flight.landing - flight.start) / scene.speed) ** 2
    assert abs(gap(flight.landing, height + off)) > 1e-6


def test_fifty_digits_give_the_same_flight() -> None:
    scene = at(1.5)
    flight = exact_flight(scene)
    assert flight is not None
    with mpmath.workdps(50):
        base, flank, nose, distance, roller = (
            mpmath.mpf(length) for length in (0.036, 0.118, 0.029, 0.080, scene.roller_radius)
        )
        to_base, to_nose = flank - base, flank - nose
        at_shaft = mpmath.acos((to_base**2 + distance**2 - to_nose**2) / (2 * to_base * distance))
        # The joint of flank and nose: the line from the flank's centre through the nose's.
        centre = (to_base * mpmath.cos(mpmath.pi + at_shaft), to_base * mpmath.sin(mpmath.pi + at_shaft))
        # In the cam's frame the nose is on +x; the rising flank's centre lies beyond the shaft.
        centre = (-centre[0], -centre[1])
        normal = mpmath.atan2(-centre[1], distance - centre[0])
        joint = (distance + (nose + roller) * mpmath.cos(normal), (nose + roller) * mpmath.sin(normal))
        start = mpmath.pi - mpmath.atan2(abs(joint[1]), joint[0])

        def on_arc(offset: mpmath.mpf, lowest: mpmath.mpf, radius: mpmath.mpf) -> Callable[[mpmath.mpf], mpmath.mpf]:
            return lambda t: (
                -offset * mpmath.cos(t - lowest) + mpmath.sqrt(radius**2 - (offset * mpmath.sin(t - lowest)) ** 2)
            )

        on_nose = on_arc(distance, mpmath.mpf(0), nose + roller)
        on_falling_flank = on_arc(to_base, -at_shaft, flank + roller)
        fall = -mpmath.diff(on_nose, start, 2) / mpmath.mpf(1.5) ** 2
        height, slope = on_nose(start), mpmath.diff(on_nose, start)

        def path(t: mpmath.mpf) -> mpmath.mpf:
            return height + slope * (t - start) - fall * (t - start) ** 2 / 2

        landing = mpmath.findroot(lambda t: path(t) - on_falling_flank(t), flight.landing)
        assert float(abs(start - flight.start)) < 1e-14
        assert float(abs(landing - flight.landing)) < 1e-12

        def gap(t: mpmath.mpf) -> mpmath.mpf:
            # From the falling flank's centre, which is below the shaft at crank angle -at_shaft.
            x, y = to_base * mpmath.sin(-(t + at_shaft)), -to_base * mpmath.cos(t + at_shaft)
            return mpmath.sqrt(x**2 + (path(t) - y) ** 2) - flank - roller

        widest = mpmath.findroot(lambda t: mpmath.diff(gap, t), 0.5 * (flight.start + flight.landing))
        assert float(abs(gap(widest) - flight.gap)) < 1e-15


def test_short_flights_grow_from_nothing_as_the_law_says() -> None:
    least, curvature = short_flight(CAM)
    assert least == pytest.approx(-CAM.least_acceleration / CAM.speed**2)
    # The joint's normal, from the shaft, the nose's centre and the roller's: the law of sines.
    reach = CAM.nose_radius + CAM.roller_radius
    cosine = math.sqrt(1.0 - (CAM.centre_distance / reach * math.sin(CAM.joint_angles[1])) ** 2)
    off = []
    for speed in (1.02, 1.002, 1.0002):
        flight, excess = exact_flight(at(speed)), 1.0 - 1.0 / speed**2
        assert flight is not None
        length = (flight.landing - flight.start) / (3.0 * excess / curvature)
        gap = flight.gap / (2.0 / 3.0 * least * excess**3 / curvature**2 * cosine)
        off.append((length - 1.0, gap - 1.0))
    # The next term is proportional to the excess of speed.
    assert np.allclose(np.array(off[1]) / off[0], 0.1, rtol=0.3)
    assert np.allclose(np.array(off[2]) / off[1], 0.1, rtol=0.3)
    assert np.abs(off[-1]).max() < 3e-3


def test_flights_lower_than_rounding_are_none() -> None:
    assert exact_flight(at(1.000001)) is None
    flight = exact_flight(at(1.0001))
    assert flight is not None
    assert flight.gap > LEAST_HEIGHT * CAM.base_radius


def test_the_gap_is_zero_along_the_cam_and_at_both_ends_of_the_flight() -> None:
    scene = at(2.0)
    flight = exact_flight(scene)
    assert flight is not None
    fall = Fall(scene, flight.start)
    ends = np.array([flight.start, flight.landing])
    assert np.abs(fall.gap(ends)).max() < 1e-15
    assert np.abs(fall.above(ends)).max() < 1e-14
    assert fall.gap(np.array([flight.landing + 1e-3]))[0] < 0.0
