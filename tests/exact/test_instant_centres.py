"""Instant centres: on the lines of Kennedy's theorem with those of the joints, and where a course printed them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from functools import cache
from itertools import combinations

import numpy as np
import pytest
from linkages import four_bar, slider_crank

from conrod.exact.kinematics import Kinematics
from conrod.exact.linkage import InstantQuantities, instant_quantities
from conrod.exact.linkage.centres import InstantCentre, instant_centres
from conrod.exact.linkage.link_motion import GROUND_AT_REST, LinkMotion
from conrod.exact.motion import Array
from conrod.mechanism.mechanism import CamContact, Joint, Prismatic, Rack, Revolute, Rolling
from conrod.scenes import SCENES, Scene, catalogue_names, catalogue_scene, dynamics_names

PLANAR = [*SCENES, *catalogue_names(), *dynamics_names()]
Pair = frozenset[str]


@cache
def planar_scene(name: str) -> Scene:
    return SCENES[name] if name in SCENES else catalogue_scene(name)


def joint_centre(joint: Joint, links: dict[str, LinkMotion]) -> Array | None:
    """Centre that a joint's geometry alone gives, (x, y, 1), or (x, y, 0) at infinity; None where it gives a line."""
    a, b = links[joint.a], links[joint.b]
    match joint:
        case Revolute():
            return np.array([*a.place(joint.point_a), 1.0])
        case Prismatic():
            turn = a.pose[2] + joint.direction
            return np.array([-math.sin(turn), math.cos(turn), 0.0])
        case Rolling():
            centre, other = a.place(joint.point_a), b.place(joint.point_b)
            return np.array([*(centre + joint.radius_a / (joint.radius_a + joint.radius_b) * (other - centre)), 1.0])
        case Rack():
            turn = b.pose[2] + joint.direction
            foot = joint.radius * np.array([math.sin(turn), -math.cos(turn)])
            return np.array([*(a.place(joint.point_a) + foot), 1.0])
        case CamContact():
            return None


def homogeneous(centre: InstantCentre) -> Array:
    if centre.place is not None:
        return np.array([*centre.place, 1.0])
    # Two links that stay at rest to each other have every point for a centre: none breaks the theorem.
    return np.zeros(3) if centre.direction is None else np.array([*unit(centre.direction), 0.0])


def unit(angle: float) -> Array:
    return np.array([math.cos(angle), math.sin(angle)])


def normalised(point: Array, size: float) -> Array:
    scaled = point * [1.0 / size, 1.0 / size, 1.0]
    return np.asarray(scaled / (float(np.linalg.norm(scaled)) or 1.0))


def kennedy_miss(kinematics: Kinematics, links: Sequence[LinkMotion]) -> float:
    """How far centres miss the lines that Kennedy's theorem puts them on [1].

    Of three links, two centres are those of joints, from geometry alone, and the third is from velocities: three from
    velocities are on a line whatever the velocities are. The centre of a cam and its follower is on the common normal,
    that of wheels that roll is where they touch.
    """
    centres = {frozenset(c.links): homogeneous(c) for c in instant_centres(links, kinematics.size)}
    named = {link.link: link for link in (GROUND_AT_REST, *links)}
    joints: dict[Pair, Array] = {}
    misses = [0.0]
    poses, row = np.concatenate([link.pose for link in links])[None], 0
    for joint in kinematics.mechanism.joints:
        pair = frozenset((joint.a, joint.b))
        centre = joint_centre(joint, named)
        if centre is not None:
            joints.setdefault(pair, centre)
            if kinematics.mechanism.meshes:
                # All centres of a gear train may be on one line, whatever its speeds are: where on it is compared.
                own, found = (normalised(one, kinematics.size) for one in (centre, centres[pair]))
                misses.append(float(np.linalg.norm(np.cross(own, found))))
        elif isinstance(joint, CamContact):
            roller, column = named[joint.b].place(joint.roller_centre), 3 * kinematics.mechanism.body_index[joint.b]
            x, y = kinematics.jacobian(poses)[0, row, column : column + 2]  # along the normal of the contact
            line = [np.array([*roller, 1.0]), np.array([x, y, 0.0]), centres[pair]]
            misses.append(abs(float(np.linalg.det([normalised(one, kinematics.size) for one in line]))))
        row += kinematics.equations_of(joint)
    for (ij, first), (jk, second) in combinations(joints.items(), 2):
        if len(ij | jk) == 3:
            three = [normalised(one, kinematics.size) for one in (first, second, centres[ij ^ jk])]
            misses.append(abs(float(np.linalg.det(three))))
    return max(misses)


def telling_angle(scene: Scene, share: float) -> float:
    first, last = scene.kinematics.span
    return first + share * (last - first)


@pytest.mark.parametrize("name", PLANAR)
def test_centres_lie_on_kennedys_lines(name: str) -> None:
    scene = planar_scene(name)
    for share in (0.13, 0.4, 0.77):
        found = instant_quantities(scene.kinematics, telling_angle(scene, share), scene.speed)
        n = len(found.links) + 1
        assert len({frozenset(c.links) for c in found.centres}) == len(found.centres) == n * (n - 1) // 2
        assert kennedy_miss(scene.kinematics, found.links) <= 1e-9


@pytest.mark.parametrize("name", [name for name in PLANAR if name != "pendulum"])  # two links have one centre
def test_wrong_angular_velocity_breaks_kennedys_theorem(name: str) -> None:
    scene = planar_scene(name)
    links = list(instant_quantities(scene.kinematics, telling_angle(scene, 0.77), scene.speed).links)
    fastest = max(abs(link.rate[2]) for link in links)
    for k, link in enumerate(links[:6]):
        planted = replace(link, rate=link.rate + np.array([0.0, 0.0, 1e-3 * fastest]))
        assert kennedy_miss(scene.kinematics, [*links[:k], planted, *links[k + 1 :]]) > 1e-5


# -- closed forms, and centres at infinity -----------------------------------------------------------------------------


def centre_of(found: InstantQuantities, *links: str) -> InstantCentre:
    return next(centre for centre in found.centres if set(centre.links) == set(links))


@pytest.mark.parametrize("angle", [0.3, 1.2, 2.9, 4.0])
def test_slider_crank_centres_match_closed_form(angle: float) -> None:
    crank, rod = 0.3, 0.56
    found = instant_quantities(Kinematics(slider_crank(crank, rod, turn=0.5)), angle - 0.5, -7.0)
    down = math.sqrt(rod**2 - (crank * math.sin(angle)) ** 2)
    reach = crank * math.cos(angle) + down
    # Where the crank's line meets the upright through the slider; where the rod's line meets the one through the shaft.
    upright, shaft = centre_of(found, "ground", "rod").place, centre_of(found, "crank", "slider").place
    assert upright == pytest.approx((reach, reach * math.tan(angle)), rel=1e-12)
    assert shaft == pytest.approx((0.0, crank * math.sin(angle) / down * reach), abs=1e-12)
    slide = centre_of(found, "ground", "slider")
    assert (slide.place, slide.direction) == (None, pytest.approx(0.5 * math.pi, abs=1e-14))
    # Negative control: with a rod 1 % longer.
    longer = instant_quantities(Kinematics(slider_crank(crank, 1.01 * rod, turn=0.5)), angle - 0.5, -7.0)
    assert centre_of(longer, "ground", "rod").place != pytest.approx(upright, rel=1e-4)


def test_centres_at_a_dead_centre_are_limits() -> None:
    kinematics = Kinematics(slider_crank(0.3, 0.56, turn=0.0))
    here, after = (instant_quantities(kinematics, angle, 3.0) for angle in (0.0, 1e-6))
    assert here.links[2].rate == pytest.approx(np.zeros(3), abs=1e-15)  # the slider rests
    assert centre_of(here, "ground", "slider").direction == pytest.approx(0.5 * math.pi, abs=1e-12)
    limit = centre_of(after, "crank", "slider").place
    assert centre_of(here, "crank", "slider").place == pytest.approx(limit, abs=1e-6)
    assert kennedy_miss(kinematics, here.links) <= 1e-12


def test_links_that_turn_alike_have_their_centre_at_infinity() -> None:
    angle = 0.7
    found = instant_quantities(Kinematics(four_bar(0.1, 0.3, 0.1, 0.3, turn=angle)), 0.0, 3.0)
    # A parallelogram's coupler moves against the ground along the crank's path, its rocker as its crank does.
    assert centre_of(found, "ground", "coupler").place is None
    assert centre_of(found, "ground", "coupler").direction == pytest.approx(angle, abs=1e-12)
    assert centre_of(found, "crank", "rocker").direction == pytest.approx(0.0, abs=1e-12)
    # Negative control: in a linkage that is none, coupler and rocker turn.
    assert (
        centre_of(instant_quantities(Kinematics(four_bar(0.1, 0.3, 0.11, 0.3)), 0.0, 3.0), "ground", "coupler").place
        is not None
    )


def test_resting_follower_and_ground_have_no_centre() -> None:
    scene = planar_scene("cam-follower")
    found = instant_quantities(scene.kinematics, math.radians(60.0), scene.speed)
    assert centre_of(found, "ground", "follower") == InstantCentre(("ground", "follower"), None, None)
    moving = instant_quantities(scene.kinematics, math.radians(150.0), scene.speed)
    assert centre_of(moving, "ground", "follower").direction == pytest.approx(0.0, abs=1e-12)


# -- document 001, Example 4.10: crank angle 0 is the printed instant --------------------------------------------------

DISTANCES = {
    "O12 A": ("ground crank", "crank rod-3", "0.14"),
    "O13 A": ("ground rod-3", "crank rod-3", "0.67"),
    "O13 B": ("ground rod-3", "rod-3 slider-4", "0.58"),
    "O12 O25": ("ground crank", "crank rod-5", "0.49"),
    "O15 B": ("ground rod-5", "rod-3 rod-5", "0.20"),
    "O15 C": ("ground rod-5", "rod-5 slider-6", "0.06"),
    "O15 O25": ("ground rod-5", "crank rod-5", "0.81"),
}


def distance(scene: Scene, first: str, second: str) -> float:
    found = instant_quantities(scene.kinematics, 0.0, scene.speed)
    places = [centre_of(found, *pair.split()).place for pair in (first, second)]
    assert places[0] is not None
    assert places[1] is not None
    return math.dist(places[0], places[1])


@pytest.mark.parametrize("name", DISTANCES)
def test_centres_of_example_4_10_have_printed_distances(name: str) -> None:
    first, second, printed = DISTANCES[name]
    scene = planar_scene("two-slider-linkage")
    assert f"{distance(scene, first, second):.2f}" == printed
    # Negative control: a rod a tenth of a link off.
    other = scene.with_parameters(**{"bodies.rod-3.points.B.y": 0.25, "bodies.crank.points.A.x": 0.15})
    assert abs(distance(other, first, second) - distance(scene, first, second)) > 0.004


def test_speeds_of_example_4_10_follow_from_its_centres() -> None:
    scene = planar_scene("two-slider-linkage")
    rates = {link.link: abs(link.rate[2]) for link in instant_quantities(scene.kinematics, 0.0, scene.speed).links}
    v_a = rates["crank"] * distance(scene, "ground crank", "crank rod-3")
    v_b = rates["rod-3"] * distance(scene, "ground rod-3", "rod-3 slider-4")
    v_c = rates["rod-5"] * distance(scene, "ground rod-5", "rod-5 slider-6")
    assert (f"{v_a:.2f}", f"{v_b:.2f}", f"{v_c:.1f}") == ("14.66", "12.69", "3.8")
    assert f"{v_a / distance(scene, 'ground rod-3', 'crank rod-3'):.2f}" == f"{rates['rod-3']:.2f}" == "21.88"
    # Printed 63.45, computed there from V_B = 12.69 and 0.2 as printed.
    assert rates["rod-5"] == pytest.approx(63.457, abs=5e-4)
    assert f"{12.69 / 0.2:.2f}" == "63.45"
    # Printed 51.31 and 63.34: the document takes 0.49 for the 0.4921 between O12 and O25.
    v_o25 = [rates[link] * distance(scene, f"ground {link}", "crank rod-5") for link in ("crank", "rod-5")]
    assert v_o25 == pytest.approx([51.535, 51.535], abs=5e-4)
    assert (f"{rates['crank'] * 0.49:.2f}", f"{51.31 / 0.81:.3f}") == ("51.31", "63.346")
