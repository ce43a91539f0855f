"""Linkages for tests of their classic quantities, with the printed values of a course module's worked examples.

The drawings of that module are lost. Where printed lengths and velocities fix a mechanism, its geometry was recovered
from them; what had to be assumed is said with each.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from conrod.mechanism.mechanism import (
    GROUND,
    Body,
    Driver,
    Joint,
    Mechanism,
    ObservedPoint,
    Point,
    Pose,
    Prismatic,
    Revolute,
    Rolling,
)

RPM = 2.0 * math.pi / 60.0

Place = tuple[float, float]


def four_bar(
    crank: float, coupler: float, rocker: float, ground: float, turn: float = 0.7, branch: float = 1.0
) -> Mechanism:
    """O12 at the origin, O14 at (ground, 0); `branch` +1 puts B on the left of the way from A to O14."""
    a, pivot = np.array([crank * math.cos(turn), crank * math.sin(turn)]), np.array([ground, 0.0])
    way = pivot - a
    distance = math.hypot(*way)
    along = (distance**2 + coupler**2 - rocker**2) / (2.0 * distance)
    aside = branch * math.sqrt(coupler**2 - along**2)
    b = a + (along * way + aside * np.array([-way[1], way[0]])) / distance
    return assembled(
        "four-bar",
        {"crank": ((0.0, 0.0), tuple(a)), "coupler": (tuple(a), tuple(b)), "rocker": (tuple(pivot), tuple(b))},
        [
            ("O12", GROUND, "crank", (0.0, 0.0)),
            ("A", "crank", "coupler", tuple(a)),
            ("B", "coupler", "rocker", tuple(b)),
            ("O14", GROUND, "rocker", tuple(pivot)),
        ],
    )


def slider_crank(crank: float, rod: float, offset: float = 0.0, turn: float = 0.5) -> Mechanism:
    """Shaft at the origin; the slider B moves along x at the height `offset`."""
    a = (crank * math.cos(turn), crank * math.sin(turn))
    b = (a[0] + math.sqrt(rod**2 - (a[1] - offset) ** 2), offset)
    return assembled(
        "slider-crank",
        {"crank": ((0.0, 0.0), a), "rod": (a, b), "slider": (b, (b[0] + 1.0, b[1]))},
        [
            ("O12", GROUND, "crank", (0.0, 0.0)),
            ("A", "crank", "rod", a),
            ("B", "rod", "slider", b),
        ],
        [Prismatic("slide", GROUND, "slider", (0.0, offset), (0.0, 0.0), 0.0)],
    )


def inverted_slider_crank(crank: float, ground: float, offset: float = 0.0, turn: float = 0.8) -> Mechanism:
    """A block on the crank pin A slides in a link that turns about (ground, 0), `offset` beside that pivot."""
    a = (crank * math.cos(turn), crank * math.sin(turn))
    way = (a[0] - ground, a[1])
    phi = math.atan2(way[1], way[0]) - math.asin(offset / math.hypot(*way))
    ahead = (math.cos(phi), math.sin(phi))
    return assembled(
        "inverted slider-crank",
        {
            "crank": ((0.0, 0.0), a),
            "block": (a, (a[0] + ahead[0], a[1] + ahead[1])),
            "slotted": ((ground, 0.0), (ground + ahead[0], ahead[1])),
        },
        [
            ("O12", GROUND, "crank", (0.0, 0.0)),
            ("A", "crank", "block", a),
            ("O14", GROUND, "slotted", (ground, 0.0)),
        ],
        [Prismatic("slot", "slotted", "block", (0.0, offset), (0.0, 0.0), 0.0)],
    )


def crank_shaper() -> Mechanism:
    """A block on the crank pin swings a slotted lever about O14, which drives a ram by a rod; O12 .25 m above O14."""
    shaft, turn, reach, rod, height = (0.0, 0.25), 0.4, 0.45, 0.2, 0.47
    a = (shaft[0] + 0.1 * math.cos(turn), shaft[1] + 0.1 * math.sin(turn))
    lever = math.atan2(a[1], a[0])
    b = (reach * math.cos(lever), reach * math.sin(lever))
    c = (b[0] + math.sqrt(rod**2 - (height - b[1]) ** 2), height)
    return assembled(
        "crank shaper",
        {
            "crank": (shaft, a),
            "block": (a, (a[0] + math.cos(lever), a[1] + math.sin(lever))),
            "lever": ((0.0, 0.0), b),
            "rod": (b, c),
            "ram": (c, (c[0] + 1.0, c[1])),
        },
        [
            ("O12", GROUND, "crank", shaft),
            ("A", "crank", "block", a),
            ("O14", GROUND, "lever", (0.0, 0.0)),
            ("B", "lever", "rod", b),
            ("C", "rod", "ram", c),
        ],
        [
            Prismatic("slot", "lever", "block", (0.0, 0.0), (0.0, 0.0), 0.0),
            Prismatic("guide", GROUND, "ram", (0.0, height), (0.0, 0.0), 0.0),
        ],
    )


def example_5_6() -> Mechanism:
    """Four-bar linkage of example 5.6: O12A .11, AB .21, O14B .145 m; ground and crank angle recovered, uncrossed."""
    return four_bar(0.11, 0.21, 0.145, 0.3397241528063615, 1.0540538523344571)


def example_4_10() -> Mechanism:
    """Machine of example 4.10: O12A .14 m; sliders at B and C, which move at right angles to O13B and O15C, assumed."""
    o13, o15 = (0.81, 0.0), (0.09265432098765439, 0.30629263262820533)
    a, b = (0.14, 0.0), (0.2765891104779995, 0.2277560601594347)
    c = (0.15265432098765438, 0.30629263262820533)
    across = [math.atan2(p[1] - o[1], p[0] - o[0]) + 0.5 * math.pi for p, o in ((b, o13), (c, o15))]
    return assembled(
        "example 4.10",
        {
            "crank": ((0.0, 0.0), a),
            "three": (a, b),
            "four": (b, (b[0] + 1.0, b[1])),
            "five": (b, c),
            "six": (c, (c[0] + 1.0, c[1])),
        },
        [
            ("O12", GROUND, "crank", (0.0, 0.0)),
            ("A", "crank", "three", a),
            ("B", "three", "four", b),
            ("B5", "three", "five", b),
            ("C", "five", "six", c),
        ],
        [
            Prismatic("slide at B", GROUND, "four", b, (0.0, 0.0), across[0]),
            Prismatic("slide at C", GROUND, "six", c, (0.0, 0.0), across[1]),
        ],
    )


def example_6_15() -> Mechanism:
    """Six-bar of example 6.15 in the frame of its link 4 at the printed instant; two angles fitted, 600 rpm clockwise.

    O12A .2, AB .53, BC .29, CD .45, DB .53, O15C .49, AE .53, BE .19 m.
    """
    o12, o15 = (0.1321876681663548, -0.5962326718926764), (-0.3337894419168863, 0.19285692639131724)
    a, b = (0.273047619047619, -0.45425213013526566), (0.0, 0.0)
    c, d = (0.15330188679245285, 0.24616768980894704), (0.53, 0.0)
    slide = math.atan2(0.01215932914046104, 0.9999260726247986)
    mechanism = assembled(
        "example 6.15",
        {"crank": (o12, a), "three": (a, b), "four": (b, d), "five": (o15, c), "six": (d, (d[0] + 1.0, d[1]))},
        [
            ("O12", GROUND, "crank", o12),
            ("A", "crank", "three", a),
            ("B", "three", "four", b),
            ("C", "four", "five", c),
            ("D", "four", "six", d),
            ("O15", GROUND, "five", o15),
        ],
        [Prismatic("slide", GROUND, "six", d, (0.0, 0.0), slide)],
    )
    return mechanism


def example_6_18() -> Mechanism:
    """Four-bar of example 6.18, O14B .3, BC .25, O12C .13 m, driven at O14; ground and input angle recovered.

    The rack and wheel that turn the input at 20 rad/s are left out: B is called A here, C is B.
    """
    return four_bar(0.3, 0.25, 0.13, 0.475, -0.7843461981647769)


def assembled(
    name: str,
    links: dict[str, tuple[Place, Place]],
    pins: Iterable[tuple[str, str, str, Place]],
    slides: Iterable[Prismatic] = (),
    observed: tuple[ObservedPoint, ...] = (),
) -> Mechanism:
    """A mechanism from where its pins are at crank angle 0; the first pin is driven.

    Args:
        name: of the mechanism.
        links: of each, the place of its frame's origin and of a point on its x axis [m].
        pins: name, two links and place [m] of each.
        slides: as they are.
        observed: points.
    """
    poses: dict[str, Pose] = {
        link: (*start, math.atan2(stop[1] - start[1], stop[0] - start[0])) for link, (start, stop) in links.items()
    }
    poses_with_ground = {**poses, GROUND: (0.0, 0.0, 0.0)}

    def own(link: str, place: Place) -> Point:
        x, y, phi = poses_with_ground[link]
        dx, dy = place[0] - x, place[1] - y
        return (math.cos(phi) * dx + math.sin(phi) * dy, math.cos(phi) * dy - math.sin(phi) * dx)

    joints: list[Joint] = [Revolute(pin, a, b, own(a, place), own(b, place)) for pin, a, b, place in pins]
    driven = joints[0]
    return Mechanism(
        name,
        tuple(Body(link, 1.0, 0.01) for link in links),
        (*joints, *slides),
        Driver(driven.name, 1, poses[driven.b][2]),
        poses,
        observed,
    )


def planetary_wheel(track: float, wheel: float, turn: float = 0.6) -> Mechanism:
    """A wheel on an arm about the origin rolls on a round track, on its outside, or in it where `track` is negative."""
    arm = abs(track + wheel)
    centre = (arm * math.cos(turn), arm * math.sin(turn))
    carried = assembled(
        "planetary wheel",
        {"arm": ((0.0, 0.0), centre), "wheel": (centre, (centre[0] + 1.0, centre[1]))},
        [
            ("O12", GROUND, "arm", (0.0, 0.0)),
            ("A", "arm", "wheel", centre),
        ],
    )
    # What is rolled off in the start pose: the wheel's turn is 0 there, the line of centres is at `turn`.
    offset = -(track + wheel) * turn
    rolling = Rolling("mesh", GROUND, "wheel", (0.0, 0.0), (0.0, 0.0), track, wheel, offset)
    return replace(carried, joints=(*carried.joints, rolling))
