"""Linkages for tests of their classic quantities, with the printed values of a course module's worked examples.

The drawings of that module are lost. Where printed lengths and velocities fix a mechanism, its geometry was recovered
from them; what had to be assumed is said with each.
"""

from __future__ import annotations

import math
from collections.abc import Iterable

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
)

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
