"""Gears, a wheel on a track, and an input that makes one pass."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from linkages import four_bar

from conrod.exact.kinematics import GenericReference
from conrod.exact.motion import Array
from conrod.mechanism.mechanism import Body, Driver, Mechanism, ObservedPoint, Prismatic, Rack, Revolute, Rolling

SPEED = 5.0  # [rad/s]
GRAVITY = (0.0, -9.81)
TOOTH, WHEEL = 0.05, 0.08  # radii of a wheel and of the one that it drives
PIN = 0.015  # of points on wheels, from their middles


def at_test_speed(mechanism: Mechanism) -> GenericReference:
    """At the speed of these tests."""
    return GenericReference(mechanism, SPEED)


def gear_pair(driving: float = TOOTH, following: float = WHEEL) -> Mechanism:
    """Two wheels on shafts of the ground; a ring gear has a negative radius."""
    between = abs(driving + following)
    return Mechanism(
        name="gear-pair",
        bodies=(Body("pinion", 0.5, 1e-3), Body("wheel", 1.0, 3e-3)),
        joints=(
            Revolute("shaft", "ground", "pinion", (0.0, 0.0), (0.0, 0.0)),
            Revolute("axle", "ground", "wheel", (between, 0.0), (0.0, 0.0)),
            Rolling("mesh", "pinion", "wheel", (0.0, 0.0), (0.0, 0.0), driving, following),
        ),
        driver=Driver("shaft"),
        poses={"pinion": (0.0, 0.0, 0.0), "wheel": (between, 0.0, 0.0)},
        observed=(ObservedPoint("mark", "wheel", (PIN, 0.0)),),
        gravity=GRAVITY,
    )


def wheel_on_a_track() -> Mechanism:
    """A pinion drives a rack that carries the axle of a wheel; the wheel rolls on the ground beneath, over a span.

    The rack's teeth look down at the pinion. One turn of the crank takes the axle 2 pi TOOTH to the right or left, so
    that the poses never repeat.
    """
    return Mechanism(
        name="wheel-on-a-track",
        bodies=(Body("pinion", 0.5, 1e-3), Body("carriage", 0.7, 1e-3), Body("wheel", 1.0, 3e-3)),
        joints=(
            Revolute("shaft", "ground", "pinion", (0.0, 0.0), (0.0, 0.0)),
            Prismatic("slide", "ground", "carriage", (0.0, TOOTH), (0.0, 0.0), direction=0.0),
            Rack("teeth", "pinion", "carriage", (0.0, 0.0), (0.0, 0.0), TOOTH, direction=math.pi, offset=0.2),
            Revolute("axle", "carriage", "wheel", (0.0, 0.0), (0.0, 0.0)),
            Rack("track", "wheel", "ground", (0.0, 0.0), (0.0, TOOTH - WHEEL), WHEEL, direction=0.0, offset=0.2),
        ),
        driver=Driver("shaft", sense=-1),
        poses={"pinion": (0.0, 0.0, 0.0), "carriage": (0.2, TOOTH, 0.0), "wheel": (0.2, TOOTH, 0.0)},
        observed=(ObservedPoint("rim", "wheel", (0.0, -WHEEL)),),
        gravity=GRAVITY,
    )


def swinging_four_bar(span: tuple[float, float] | None = (-0.4, 0.3)) -> Mechanism:
    """The four-bar linkage of Example 5.6, whose input cannot turn fully, from its printed instant."""
    machine = four_bar(0.11, 0.21, 0.145, 0.3397241528063615, 1.0540538523344571)
    return replace(
        machine,
        name="swinging-four-bar",
        driver=replace(machine.driver, span=span),
        observed=(ObservedPoint("joint", "coupler", (0.21, 0.0)),),
        gravity=GRAVITY,
    )


def poses_of(machine: GenericReference, body: str, angle: Array) -> Array:
    """Exact poses (T, 3) of a body."""
    i = 3 * machine.described.body_index[body]
    return np.asarray(machine.kinematics.poses(angle)[:, i : i + 3])
