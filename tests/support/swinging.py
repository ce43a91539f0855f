"""Mechanisms that swing by themselves, for tests of free motion."""

from __future__ import annotations

import math

from conrod.mechanism.mechanism import GROUND, Body, Driver, Mechanism, ObservedPoint, Prismatic, Revolute

GRAVITY = (0.0, -9.81)


def four_bar(crank: float = 0.1, rocker: float = 0.1, start: float = 0.6) -> Mechanism:
    """A parallelogram 0.3 m long, or nearly one where the rocker has another length [m]."""
    mechanism, _, _ = chain(1, start)
    joints = tuple(
        Revolute(j.name, j.a, j.b, j.point_a, (rocker, 0.0)) if isinstance(j, Revolute) and j.name == "q0" else j
        for j in mechanism.joints
    )
    return Mechanism(
        "four-bar", mechanism.bodies, joints, mechanism.driver, mechanism.poses, mechanism.observed, GRAVITY
    )


def chain(count: int, start: float = 0.6) -> tuple[Mechanism, float, float]:
    """Parallelograms in a row; with them inertia [kg m^2] and moment [kg m] about the pins of all that swings."""
    a, w = 0.1, 0.3
    x, y = a * math.cos(start), a * math.sin(start)
    bodies, joints = [Body("r0", 1.0, 0.002, (a / 2, 0.0))], [Revolute("s", GROUND, "r0", (0.0, 0.0), (0.0, 0.0))]
    poses = {"r0": (0.0, 0.0, start)}
    for k in range(count):
        left, right = f"r{k}", f"r{k + 1}"
        bodies += [Body(f"c{k}", 2.0, 0.01, (w / 2, 0.0)), Body(right, 1.0, 0.002, (a / 2, 0.0))]
        joints += [
            Revolute(f"p{k}", left, f"c{k}", (a, 0.0), (0.0, 0.0)),
            Revolute(f"q{k}", f"c{k}", right, (w, 0.0), (a, 0.0)),
            Revolute(f"g{k}", GROUND, right, ((k + 1) * w, 0.0), (0.0, 0.0)),
        ]
        poses |= {f"c{k}": (k * w + x, y, 0.0), right: ((k + 1) * w, 0.0, start)}
    driver, seen = Driver("s", 1, start), (ObservedPoint("P", "c0", (w / 2, 0.0)),)
    inertia = (count + 1) * (0.002 + 1.0 * (a / 2) ** 2) + count * 2.0 * a**2
    moment = (count + 1) * 1.0 * a / 2 + count * 2.0 * a
    return Mechanism("chain", tuple(bodies), tuple(joints), driver, poses, seen, GRAVITY), inertia, moment


def pendulum(released: float) -> tuple[Mechanism, float]:
    """A pendulum that is let go at an angle [rad] from hanging down; with it the square of small swings' frequency."""
    bob = Body("bob", 2.0, 0.03, (0.4, 0.0))
    start = released - math.pi / 2.0
    mechanism = Mechanism(
        "pendulum", (bob,), (Revolute("pin", GROUND, "bob", (0.0, 0.0), (0.0, 0.0)),), Driver("pin", 1, start),
        {"bob": (0.0, 0.0, start)}, (ObservedPoint("end", "bob", (0.8, 0.0)),), GRAVITY,
    )  # fmt: skip
    return mechanism, 2.0 * 9.81 * 0.4 / (0.03 + 2.0 * 0.4**2)


def slider_crank(start: float = 0.3) -> Mechanism:
    """A slider-crank of 0.1 m and 0.3 m."""
    a, b = 0.1, 0.3
    turn = -math.asin(a * math.sin(start) / b)
    bodies = (
        Body("crank", 1.0, 0.004, (0.02, 0.01)),
        Body("rod", 0.8, 0.006, (0.12, -0.01)),
        Body("slider", 1.5, 0.002, (0.01, 0.02)),
    )
    joints = (
        Revolute("shaft", GROUND, "crank", (0.0, 0.0), (0.0, 0.0)),
        Revolute("crank-pin", "crank", "rod", (a, 0.0), (0.0, 0.0)),
        Revolute("slider-pin", "rod", "slider", (b, 0.0), (0.0, 0.0)),
        Prismatic("slide", GROUND, "slider", (0.0, 0.0), (0.0, 0.0), 0.0),
    )
    x, y = a * math.cos(start), a * math.sin(start)
    poses = {"crank": (0.0, 0.0, start), "rod": (x, y, turn), "slider": (x + b * math.cos(turn), 0.0, 0.0)}
    return Mechanism(
        "slider-crank", bodies, joints, Driver("shaft", 1, start), poses, (ObservedPoint("B", "slider"),), GRAVITY
    )
