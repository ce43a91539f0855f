"""Instant centres: where exact velocities put them, and joints, on Kennedy's lines, where a course printed them."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest
from catalogue import EVERY_SCENE
from linkages import (
    crank_shaper,
    example_4_10,
    example_5_6,
    example_6_15,
    four_bar,
    inverted_slider_crank,
    planetary_wheel,
    slider_crank,
)

from conrod.exact.kinematics import Kinematics
from conrod.exact.linkage.centres import (
    InstantCentre,
    centre_count,
    instant_centres,
    joint_centre,
    primary_joints,
)
from conrod.exact.linkage.state import LinkageState, link_numbers, linkage_state
from conrod.exact.motion import Array
from conrod.mechanism.mechanism import GROUND, Mechanism

LINKAGES = [
    four_bar(0.1, 0.3, 0.25, 0.3),
    four_bar(0.1, 0.3, 0.25, 0.3, branch=-1.0),
    slider_crank(0.3, 0.56),
    slider_crank(0.1, 0.3, 0.09),
    inverted_slider_crank(0.1, 0.25),
    inverted_slider_crank(0.1, 0.25, 0.03),
    example_4_10(),
    example_5_6(),
    example_6_15(),
    planetary_wheel(0.3, 0.1),
    crank_shaper(),
]
NAMES = [f"{mechanism.name} {k}" for k, mechanism in enumerate(LINKAGES)]


def at(mechanism: Mechanism, angle: float = 0.0, speed: float = 3.0) -> LinkageState:
    return linkage_state(Kinematics(mechanism), angle, speed)


def named(state: LinkageState) -> dict[str, InstantCentre]:
    return {centre.name: centre for centre in instant_centres(state)}


def place(centre: InstantCentre) -> tuple[float, float]:
    assert centre.place is not None
    return centre.place


def homogeneous(state: LinkageState) -> dict[frozenset[str], Array]:
    """Centres as points of the projective plane, places in units of the linkage's size, of length 1."""
    scale = np.array([1.0 / state.size, 1.0 / state.size, 1.0])
    found = {}
    for centre in instant_centres(state):
        assert centre.place is not None or centre.direction is not None
        point = np.array([*centre.place, 1.0]) * scale if centre.place else np.array([*centre.direction, 0.0])  # type: ignore[misc]
        found[frozenset(centre.links)] = point / np.linalg.norm(point)
    return found


def largest_miss(state: LinkageState) -> float:
    """Largest miss of Kennedy's theorem, or of a joint's own centre from that of the velocities [1]."""
    points = homogeneous(state)
    scale = np.array([1.0 / state.size, 1.0 / state.size, 1.0])
    triples = ([points[frozenset(pair)] for pair in combinations(links, 2)] for links in combinations(state.links, 3))
    misses = [abs(float(np.linalg.det(np.array(three)))) for three in triples]
    for pair, (_, joint) in primary_joints(state.mechanism).items():
        point = joint_centre(state, joint)
        assert point is not None
        own = point * scale if point[2] else point
        misses.append(float(np.linalg.norm(np.cross(own / np.linalg.norm(own), points[pair]))))
    return max(misses)


@pytest.mark.parametrize("mechanism", LINKAGES, ids=NAMES)
@pytest.mark.parametrize("angle", [0.0, 0.2])
def test_there_are_n_times_n_minus_1_over_2_centres_and_every_three_links_have_theirs_on_a_line(
    mechanism: Mechanism, angle: float
) -> None:
    state = at(mechanism, angle)
    centres = instant_centres(state)
    n = len(mechanism.bodies) + 1
    assert len(centres) == centre_count(mechanism) == n * (n - 1) // 2
    assert largest_miss(state) <= 1e-10


@pytest.mark.parametrize("name", EVERY_SCENE)
def test_the_centres_of_every_scene_are_those_of_its_joints_and_on_kennedys_lines(name: str) -> None:
    state = linkage_state(EVERY_SCENE[name].kinematics, 2.0, EVERY_SCENE[name].speed)
    assert largest_miss(state) <= 1e-10


def test_a_wrong_velocity_puts_centres_beside_the_lines() -> None:
    state = at(four_bar(0.1, 0.3, 0.25, 0.3))
    rod = state.links["coupler"]
    faster = replace(rod, angular_velocity=1.0001 * rod.angular_velocity)
    assert largest_miss(replace(state, links={**state.links, "coupler": faster})) > 1e-6


def test_pins_on_the_ground_are_fixed_pins_between_links_permanent_and_the_others_secondary() -> None:
    kinds = {name: centre.kind for name, centre in named(at(four_bar(0.1, 0.3, 0.25, 0.3))).items()}
    assert kinds == {
        "O12": "fixed",
        "O14": "fixed",
        "O23": "permanent",
        "O34": "permanent",
        "O13": "secondary",
        "O24": "secondary",
    }


def test_a_slides_centre_is_at_infinity_at_right_angles_to_it() -> None:
    centre = named(at(slider_crank(0.3, 0.56)))["O14"]
    assert (centre.kind, centre.place) == ("fixed", None)
    assert centre.direction == pytest.approx((0.0, 1.0), abs=1e-14)
    slot = named(at(inverted_slider_crank(0.1, 0.25)))["O34"]
    assert slot.kind == "permanent"
    assert slot.place is None


def test_where_a_wheel_rolls_its_centre_is_the_point_of_contact() -> None:
    centre = named(at(planetary_wheel(0.3, 0.1)))["O13"]
    assert centre.kind == "contact"
    assert place(centre) == pytest.approx((0.3 * math.cos(0.6), 0.3 * math.sin(0.6)), abs=1e-13)


def test_a_pin_of_three_links_is_the_centre_of_every_two_of_them() -> None:
    centres = named(at(example_4_10()))
    assert {centres[name].kind for name in ("O34", "O35", "O45")} == {"permanent"}
    assert place(centres["O45"]) == pytest.approx(place(centres["O34"]), abs=1e-13)


@pytest.mark.parametrize("angle", [0.3, 1.2, 2.9, 4.0])
def test_the_slider_cranks_centres_are_those_of_its_closed_form(angle: float) -> None:
    crank, rod = 0.3, 0.56
    centres = named(at(slider_crank(crank, rod, turn=0.5), angle - 0.5))
    way = crank * math.cos(angle) + math.sqrt(rod**2 - (crank * math.sin(angle)) ** 2)
    # Where the crank's line meets the upright through the slider; where the rod's line meets the one through the shaft.
    assert place(centres["O13"]) == pytest.approx((way, way * math.tan(angle)), rel=1e-12)
    slope = -crank * math.sin(angle) / math.sqrt(rod**2 - (crank * math.sin(angle)) ** 2)
    assert place(centres["O24"]) == pytest.approx((0.0, -slope * way), abs=1e-12)


def test_at_a_dead_centre_the_resting_slider_keeps_its_joints_centre() -> None:
    centres = named(at(slider_crank(0.3, 0.56, turn=0.0)))
    assert centres["O14"].direction == pytest.approx((0.0, 1.0), abs=1e-14)
    assert place(centres["O24"]) == pytest.approx((0.0, 0.0), abs=1e-14)


def test_links_that_turn_alike_have_their_centre_at_infinity() -> None:
    # A parallelogram's coupler does not turn: it moves against the ground like a slide.
    state = at(four_bar(0.1, 0.3, 0.1, 0.3))
    centres = instant_centres(state)
    by_name = {centre.name: centre for centre in centres}
    assert by_name["O13"].place is None
    assert by_name["O13"].direction is not None
    # Crank and rocker turn alike, so that their centre is at infinity along the coupler.
    assert by_name["O24"].direction == pytest.approx((1.0, 0.0), abs=1e-12)
    assert largest_miss(state) <= 1e-10


def test_numbers_of_links_do_not_depend_on_the_order_of_declaration() -> None:
    mechanism = example_6_15()
    turned = replace(mechanism, bodies=mechanism.bodies[::-1], joints=mechanism.joints[::-1])
    assert link_numbers(turned) == link_numbers(mechanism)
    assert list(link_numbers(mechanism))[:2] == [GROUND, "crank"]


# -- document 001, example 4.10 (crank 1000 rpm counter-clockwise), by instant centres ------------------------------


def distance(first: tuple[float, float], second: tuple[float, float]) -> float:
    return math.dist(first, second)


def test_the_distances_printed_in_example_4_10_are_those_between_its_centres() -> None:
    state = at(example_4_10(), 0.0, 104.72)
    centres = named(state)
    printed = {("O12", "O23"): 0.14, ("O13", "O23"): 0.67, ("O13", "O34"): 0.58, ("O12", "O25"): 0.49}
    printed |= {("O15", "O34"): 0.20, ("O15", "O56"): 0.06, ("O15", "O25"): 0.81}
    for (first, second), length in printed.items():
        assert distance(place(centres[first]), place(centres[second])) == pytest.approx(length, abs=0.005), (
            first,
            second,
        )


def test_the_speeds_printed_in_example_4_10_follow_from_its_centres() -> None:
    state = at(example_4_10(), 0.0, 104.72)
    assert state.links["three"].angular_velocity == pytest.approx(-21.88, abs=0.01)
    assert state.links["five"].angular_velocity == pytest.approx(63.45, abs=0.05)
    o25 = place(named(state)["O25"])
    for link in ("crank", "five"):
        speed = math.hypot(*state.links[link].velocity_at(state.links[link].own(np.array(o25))))
        assert speed == pytest.approx(51.31, abs=0.25)
