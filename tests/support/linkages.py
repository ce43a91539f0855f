"""Linkages for tests of their classic quantities, from the places of their pins."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np

from conrod.mechanism.mechanism import GROUND, Body, Driver, Joint, Mechanism, Point, Pose, Prismatic, Revolute

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
    return assemble_mechanism(
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
    return assemble_mechanism(
        "slider-crank",
        {"crank": ((0.0, 0.0), a), "rod": (a, b), "slider": (b, (b[0] + 1.0, b[1]))},
        [
            ("O12", GROUND, "crank", (0.0, 0.0)),
            ("A", "crank", "rod", a),
            ("B", "rod", "slider", b),
        ],
        [Prismatic("slide", GROUND, "slider", (0.0, offset), (0.0, 0.0), 0.0)],
    )


def assemble_mechanism(
    name: str,
    links: dict[str, tuple[Place, Place]],
    pins: Iterable[tuple[str, str, str, Place]],
    slides: Iterable[Prismatic] = (),
) -> Mechanism:
    """A mechanism from where its pins are at crank angle 0; the first pin is driven.

    Args:
        links: of each, the place of its frame's origin and of a point on its x axis [m].
        pins: name, two links and place [m] of each.
    """
    poses: dict[str, Pose] = {
        link: (*start, math.atan2(stop[1] - start[1], stop[0] - start[0])) for link, (start, stop) in links.items()
    }
    poses_with_ground = {**poses, GROUND: (0.0, 0.0, 0.0)}

    def local_point(link: str, place: Place) -> Point:
        x, y, phi = poses_with_ground[link]
        dx, dy = place[0] - x, place[1] - y
        return (math.cos(phi) * dx + math.sin(phi) * dy, math.cos(phi) * dy - math.sin(phi) * dx)

    joints: list[Joint] = [
        Revolute(pin, a, b, local_point(a, place), local_point(b, place)) for pin, a, b, place in pins
    ]
    driven = joints[0]
    return Mechanism(
        name,
        tuple(Body(link, 1.0, 0.01) for link in links),
        (*joints, *slides),
        Driver(driven.name, 1, poses[driven.b][2]),
        poses,
        (),
    )
