"""Velocity and acceleration polygons, and the parts of accelerations, against closed forms and printed values."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
import rolling_machines
from catalogue import EVERY_SCENE
from linkages import (
    RPM,
    crank_shaper,
    example_4_10,
    example_5_6,
    example_6_15,
    example_6_18,
    four_bar,
    inverted_slider_crank,
    planetary_wheel,
    slider_crank,
)

from conrod.exact.kinematics import Kinematics
from conrod.exact.linkage.points import linkage_points
from conrod.exact.linkage.polygon import Polygon, acceleration_polygon, coincident_parts, path_parts, velocity_polygon
from conrod.exact.linkage.state import LinkageState, left_of, linkage_state
from conrod.exact.motion import Array
from conrod.mechanism.cam import CamProfile
from conrod.mechanism.mechanism import Mechanism, ObservedPoint, Rolling

LINKAGES = [
    four_bar(0.1, 0.3, 0.25, 0.3),
    slider_crank(0.1, 0.3, 0.09),
    inverted_slider_crank(0.1, 0.25),
    inverted_slider_crank(0.1, 0.25, 0.03),
    example_4_10(),
    example_5_6(),
    example_6_15(),
    crank_shaper(),
]
NAMES = [f"{mechanism.name} {k}" for k, mechanism in enumerate(LINKAGES)]


def at(mechanism: Mechanism, angle: float = 0.0, speed: float = 7.0, acceleration: float = 0.0) -> LinkageState:
    return linkage_state(Kinematics(mechanism), angle, speed, acceleration)


def length(vector: Array) -> float:
    return float(np.linalg.norm(vector))


def both(state: LinkageState) -> tuple[Polygon, Polygon]:
    return velocity_polygon(state), acceleration_polygon(state)


# -- they close -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("mechanism", [*LINKAGES, EVERY_SCENE["cam-follower"].mechanism()], ids=[*NAMES, "cam"])
@pytest.mark.parametrize("acceleration", [0.0, 11.0])
def test_polygons_close(mechanism: Mechanism, acceleration: float) -> None:
    for polygon in both(at(mechanism, 0.25, 7.0, acceleration)):
        assert len(polygon.vectors) >= 3
        assert polygon.gap <= 1e-12


@pytest.mark.parametrize("mechanism", LINKAGES, ids=NAMES)
def test_a_wrong_angular_velocity_or_acceleration_leaves_a_polygon_open(mechanism: Mechanism) -> None:
    state = at(mechanism, 0.1)
    # A floating link, or the link that carries a slide.
    name = next((link for link in ("slotted", "lever") if link in state.links), list(state.links)[2])
    good = state.links[name]
    velocity = replace(good, angular_velocity=good.angular_velocity * (1.0 + 1e-6))
    assert velocity_polygon(replace(state, links={**state.links, name: velocity})).gap > 1e-9
    faster = replace(good, angular_acceleration=good.angular_acceleration * (1.0 + 1e-6))
    assert acceleration_polygon(replace(state, links={**state.links, name: faster})).gap > 1e-9


def test_half_the_coriolis_part_leaves_the_polygon_open() -> None:
    polygon = acceleration_polygon(at(inverted_slider_crank(0.1, 0.25)))
    name = "A^c_A/A4"
    halved = tuple(replace(v, value=0.5 * v.value) if v.name == name else v for v in polygon.vectors)
    assert polygon.gap <= 1e-12
    assert replace(polygon, vectors=halved).gap > 0.01


# -- rolling --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("track", "wheel"), [(0.3, 0.1), (-0.3, 0.1), (-0.3, 0.2), (0.05, 0.2)])
def test_where_a_wheel_rolls_polygons_show_no_slip_and_what_its_point_is_drawn_to_its_centre_with(
    track: float, wheel: float
) -> None:
    state = at(planetary_wheel(track, wheel), 0.4, 7.0, 3.0)
    velocities, accelerations = both(state)
    assert max(velocities.gap, accelerations.gap) <= 1e-14
    assert length(velocities.vector("V_B").value) <= 1e-14
    assert velocities.vector("V_B/A").value == pytest.approx(-velocities.vector("V_A").value, abs=1e-13)
    turning = state.links["wheel"].angular_velocity
    # Document 001, figures 6.12 and 6.13: w^2 r R / (R + r) outside a track, w^2 r R / (R - r) inside one.
    other = abs(track) + wheel if track > 0.0 else abs(track) - wheel
    found = accelerations.vector("A_B3").value
    assert length(found) == pytest.approx(turning**2 * wheel * abs(track) / other, rel=1e-12)
    # From the contact towards the wheel's centre.
    centre = state.links["wheel"].place((0.0, 0.0))
    contact = centre * track / (track + wheel)
    assert float(found @ (centre - contact)) == pytest.approx(length(found) * wheel, rel=1e-12)


@pytest.mark.parametrize("driving", [0.02, -0.09])
def test_teeth_of_a_pair_of_gears_have_one_velocity_and_other_accelerations(driving: float) -> None:
    machine = rolling_machines.gear_pair(driving)
    state = linkage_state(Kinematics(machine), 0.3, 7.0, 2.0)
    velocities, accelerations = both(state)
    assert len(velocities.vectors) >= 1
    assert max(velocities.gap, accelerations.gap) <= 1e-13
    (between,) = (vector for vector in accelerations.vectors if "/" in vector.name)
    (pair,) = machine.meshes
    assert isinstance(pair, Rolling)
    turned = [state.links[link].angular_velocity for link in (pair.a, pair.b)]
    closed = (turned[1] - turned[0]) ** 2 * abs(pair.radius_a * pair.radius_b) / pair.distance
    assert length(between.value) == pytest.approx(closed, rel=1e-12)


def test_a_wheel_that_slips_leaves_both_polygons_open() -> None:
    state = at(planetary_wheel(0.3, 0.1), 0.4)
    wheel = state.links["wheel"]
    slips = replace(wheel, angular_velocity=wheel.angular_velocity * (1.0 + 1e-6))
    # The wheel's own point in contact moves then, and its acceleration is not that of rolling.
    spoiled = replace(state, links={**state.links, "wheel": slips})
    velocities, accelerations = both(spoiled)
    assert length(velocities.vector("V_B").value) > 1e-8
    assert accelerations.gap > 1e-8


# -- closed forms ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("angle", [0.4, 1.7, 3.5])
def test_the_slider_cranks_vectors_are_those_of_its_closed_form(angle: float) -> None:
    r, rod, w = 0.3, 0.56, 30.0
    state = at(slider_crank(r, rod, turn=0.5), angle - 0.5, w)
    s, c = math.sin(angle), math.cos(angle)
    down = math.sqrt(rod**2 - (r * s) ** 2)  # the rod's extent along the slide
    rod_speed = -r * c * w / down
    # From rod sin(phi) = -r sin(t), twice differentiated.
    rod_acceleration = (r * s * w**2 - r * s * rod_speed**2) / down
    assert state.links["rod"].angular_velocity == pytest.approx(rod_speed, rel=1e-12)
    assert state.links["rod"].angular_acceleration == pytest.approx(rod_acceleration, rel=1e-12)
    velocities, accelerations = both(state)
    assert velocities.vector("V_A").value == pytest.approx([-r * w * s, r * w * c], rel=1e-12)
    assert velocities.vector("V_B").value == pytest.approx([-r * w * s + r * s * rod_speed, 0.0], abs=1e-12)
    slider = -r * c * w**2 - down * rod_speed**2 + r * s * rod_acceleration
    assert accelerations.vector("A_B").value == pytest.approx([slider, 0.0], abs=1e-10)
    assert length(accelerations.vector("A^n_B/A").value) == pytest.approx(rod * rod_speed**2, rel=1e-12)
    assert length(accelerations.vector("A^t_B/A").value) == pytest.approx(rod * abs(rod_acceleration), rel=1e-12)
    assert length(accelerations.vector("A^t_A").value) == 0.0


@pytest.mark.parametrize("angle", [0.8, 2.0, 4.4])
def test_the_inverted_slider_cranks_sliding_and_coriolis_parts_are_those_of_its_closed_form(angle: float) -> None:
    r, d, w = 0.1, 0.25, 12.0
    state = at(inverted_slider_crank(r, d), angle - 0.8, w)
    reach = math.sqrt(r * r + d * d - 2.0 * r * d * math.cos(angle))
    reach_rate = r * d * math.sin(angle) * w / reach
    reach_change = (r * d * math.cos(angle) * w**2 - reach_rate**2) / reach
    turning = (r * r - r * d * math.cos(angle)) * w / reach**2
    velocities, accelerations = both(state)
    assert state.links["slotted"].angular_velocity == pytest.approx(turning, rel=1e-12)
    assert length(velocities.vector("V_A/A4").value) == pytest.approx(abs(reach_rate), rel=1e-12)
    assert length(accelerations.vector("A^c_A/A4").value) == pytest.approx(2.0 * abs(turning * reach_rate), rel=1e-12)
    assert length(accelerations.vector("A_A/A4").value) == pytest.approx(abs(reach_change), rel=1e-11)


def test_coriolis_acts_on_the_side_that_the_link_turns_the_sliding_velocity_to() -> None:
    state = at(inverted_slider_crank(0.1, 0.25, 0.03), 0.3)
    parts = coincident_parts(state, "slotted", "block", (0.0, 0.0))
    turned = 2.0 * state.links["slotted"].angular_velocity * left_of(parts.relative_velocity)
    assert parts.coriolis == pytest.approx(turned, rel=1e-14)
    assert length(parts.normal) <= 1e-12 * length(parts.tangential)  # a straight slot


def test_on_a_cam_the_normal_part_is_that_of_the_pitch_curves_arc() -> None:
    scene = EVERY_SCENE["cam-follower"]
    state = linkage_state(scene.kinematics, 2.6, scene.speed)
    contact = scene.mechanism().cam_contacts[0]
    parts = coincident_parts(state, contact.a, contact.b, contact.roller_centre)
    sliding = length(parts.relative_velocity)
    radius = sliding**2 / length(parts.normal)
    assert isinstance(contact.profile, CamProfile)
    pitch_radii = [arc.radius + contact.roller_radius for arc in contact.profile.arcs]
    assert min(abs(radius / pitch - 1.0) for pitch in pitch_radii) <= 1e-10


def test_a_points_acceleration_falls_into_parts_along_and_across_its_path() -> None:
    state = at(four_bar(0.1, 0.3, 0.25, 0.3), 0.4, 7.0, 5.0)
    parts = path_parts(state, "rocker", (0.25, 0.0))
    assert parts.radius == pytest.approx(0.25, rel=1e-12)  # the rocker's pin goes round its bearing
    assert length(parts.tangential) == pytest.approx(0.25 * abs(state.links["rocker"].angular_acceleration), rel=1e-12)
    whole = state.links["rocker"].acceleration_at((0.25, 0.0))
    assert parts.normal + parts.tangential == pytest.approx(whole, rel=1e-14)
    slider = path_parts(at(slider_crank(0.1, 0.3), 0.4), "slider", (0.0, 0.0))
    assert slider.radius == math.inf
    resting = path_parts(at(slider_crank(0.1, 0.3, turn=0.0)), "slider", (0.0, 0.0))
    assert resting.radius is None


def test_the_image_of_a_link_is_its_figure_turned_and_scaled() -> None:
    # The method of images: a point of the rod divides its image as it divides the rod.
    mechanism = replace(slider_crank(0.1, 0.3), observed=(ObservedPoint("M", "rod", (0.1, 0.0)),))
    for polygon in both(at(mechanism, 0.9, 7.0, 3.0)):
        a, b, m = (polygon.places[name] for name in ("a", "b", "m"))
        assert m == pytest.approx(a + (b - a) / 3.0, abs=1e-13 * polygon.size)


# -- names ----------------------------------------------------------------------------------------------------------


def test_points_have_the_letters_of_their_joints_and_do_not_depend_on_the_order_of_declaration() -> None:
    mechanism = example_6_15()
    turned = replace(mechanism, bodies=mechanism.bodies[::-1], joints=mechanism.joints[::-1])
    for some in (mechanism, turned):
        assert [point.name for point in linkage_points(some).points] == ["A", "B", "C", "D"]


def test_nameless_pins_are_lettered_from_the_crank_on() -> None:
    mechanism = four_bar(0.1, 0.3, 0.25, 0.3)
    joints = tuple(replace(joint, name=f"joint {joint.name}") for joint in mechanism.joints)
    nameless = replace(mechanism, joints=joints, driver=replace(mechanism.driver, joint="joint O12"))
    assert [point.name for point in linkage_points(nameless).points] == ["A", "B"]
    named = replace(nameless, observed=(ObservedPoint("K", "rocker", (0.25, 0.0)),))
    assert [point.name for point in linkage_points(named).points] == ["A", "K"]


def test_three_links_on_one_pin_share_a_point() -> None:
    points = {point.name: point for point in linkage_points(example_4_10()).points}
    assert set(points) == {"A", "B", "C"}
    assert {carrier.link for carrier in points["B"].carriers} == {"three", "four", "five"}


# -- printed values -------------------------------------------------------------------------------------------------


def test_example_6_15_accelerations_of_the_recovered_geometry() -> None:
    # Normal parts follow from speeds: printed 781.25 from 12.5^2 / .2; a tangential one from the printed polygon.
    polygon = acceleration_polygon(at(example_6_15(), 0.0, -600.0 * RPM))
    assert length(polygon.vector("A^n_A").value) == pytest.approx((600.0 * RPM) ** 2 * 0.2, rel=1e-12)
    assert length(polygon.vector("A^n_C").value) == pytest.approx(111.75, rel=0.07)
    assert length(polygon.vector("A^t_B/A").value) == pytest.approx(727.5, rel=0.03)


def test_example_6_18_velocities_and_the_accelerations_that_follow_from_them() -> None:
    state = at(example_6_18(), 0.0, 20.0)
    velocities, accelerations = both(state)
    assert length(velocities.vector("V_B").value) == pytest.approx(6.9, rel=1e-12)
    assert length(velocities.vector("V_B/A").value) == pytest.approx(5.0, rel=1e-12)
    assert state.links["coupler"].angular_velocity == pytest.approx(20.0, rel=1e-12)
    # Printed 366.23 and 100.
    assert length(accelerations.vector("A^n_B").value) == pytest.approx(6.9**2 / 0.13, rel=1e-12)
    assert length(accelerations.vector("A^n_B/A").value) == pytest.approx(100.0, rel=1e-12)
    # Printed 320, measured in a drawn polygon; the recovered geometry gives 315.6.
    assert length(accelerations.vector("A^t_B").value) == pytest.approx(320.0, abs=5.0)
