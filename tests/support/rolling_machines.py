"""Machines with gears, racks and sliders on moving links, each with its motion where it is known in closed form."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from linkages import example_5_6

from conrod.exact.motion import Array
from conrod.exact.reference import GenericReference
from conrod.mechanism.mechanism import (
    Body,
    Driver,
    Joint,
    Mechanism,
    ObservedPoint,
    Pose,
    Prismatic,
    Rack,
    Revolute,
    Rolling,
)

SPEED = 5.0  # [rad/s]
GRAVITY = (0.0, -9.81)
# An inverted slider-crank: a block on the crank pin slides in a link that turns about `PIVOT`.
CRANK, PIVOT = 0.1, (0.25, 0.0)
# A planetary gear: the arm is driven, the sun stands still, and the ring turns.
SUN, PLANET = 0.06, 0.02
RING = SUN + 2.0 * PLANET
TOOTH, WHEEL = 0.05, 0.08  # radii of a wheel and of the one that it drives
PIN = 0.015  # of points on wheels, from their middles


def driven(mechanism: Mechanism) -> GenericReference:
    """At the speed of these tests."""
    return GenericReference(mechanism, SPEED)


def inverted_slider_crank() -> Mechanism:
    """A crank, the block on its pin, and the rotating link."""
    lean = math.atan2(-PIVOT[1], CRANK - PIVOT[0])
    return Mechanism(
        name="inverted-slider-crank",
        bodies=(Body("crank", 1.0, 1e-3), Body("block", 0.2, 1e-4), Body("link", 1.5, 0.02, (0.1, 0.0))),
        joints=(
            Revolute("shaft", "ground", "crank", (0.0, 0.0), (0.0, 0.0)),
            Revolute("crank-pin", "crank", "block", (CRANK, 0.0), (0.0, 0.0)),
            Prismatic("slide", "link", "block", (0.0, 0.0), (0.0, 0.0), direction=0.0),
            Revolute("pivot", "ground", "link", PIVOT, (0.0, 0.0)),
        ),
        driver=Driver("shaft"),
        poses={"crank": (0.0, 0.0, 0.0), "block": (CRANK, 0.0, lean), "link": (*PIVOT, lean)},
        observed=(ObservedPoint("tip", "link", (0.3, 0.0)),),
        gravity=GRAVITY,
    )


def gear_pair(driving: float = TOOTH, following: float = WHEEL) -> Mechanism:
    """Two wheels on shafts of the ground; a negative radius is that of a ring."""
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


def planetary_gear(sun: str = "ground") -> Mechanism:
    """A driven arm carries the planet round a sun that stands still, and the planet turns the ring.

    Args:
        sun: "ground", or "sun" for one on a shaft of its own that another pair of wheels ties to the arm.
    """
    arm = SUN + PLANET
    bodies = [Body("arm", 1.0, 1e-3), Body("planet", 0.3, 1e-4), Body("ring", 2.0, 0.02)]
    joints: list[Joint] = [
        Revolute("shaft", "ground", "arm", (0.0, 0.0), (0.0, 0.0)),
        Revolute("planet-pin", "arm", "planet", (arm, 0.0), (0.0, 0.0)),
        Revolute("ring-bearing", "ground", "ring", (0.0, 0.0), (0.0, 0.0)),
        Rolling("sun-mesh", sun, "planet", (0.0, 0.0), (0.0, 0.0), SUN, PLANET),
        Rolling("ring-mesh", "ring", "planet", (0.0, 0.0), (0.0, 0.0), -RING, PLANET),
    ]
    poses = {"arm": (0.0, 0.0, 0.0), "planet": (arm, 0.0, 0.0), "ring": (0.0, 0.0, 0.0)}
    if sun == "sun":
        # Two wheels of 30 mm and 20 mm about one axle: 50 mm with the arm's own wheel of 20 mm, 30 mm with the sun's.
        bodies += [Body("sun", 1.0, 2e-3), Body("lay", 0.4, 2e-4)]
        joints += [
            Revolute("sun-bearing", "ground", "sun", (0.0, 0.0), (0.0, 0.0)),
            Revolute("lay-bearing", "ground", "lay", (0.05, 0.0), (0.0, 0.0)),
            Rolling("first", "arm", "lay", (0.0, 0.0), (0.0, 0.0), 0.02, 0.03),
            # The line from the lay shaft to the sun points backwards: half a turn of it in the offset.
            Rolling("second", "lay", "sun", (0.0, 0.0), (0.0, 0.0), 0.02, 0.03, offset=-math.pi * 0.05),
        ]
        poses |= {"sun": (0.0, 0.0, 0.0), "lay": (0.05, 0.0, 0.0)}
    return Mechanism(
        name=f"planetary-{sun}",
        bodies=tuple(bodies),
        joints=tuple(joints),
        driver=Driver("shaft"),
        poses=poses,
        observed=(ObservedPoint("planet-mark", "planet", (PIN, 0.0)), ObservedPoint("ring-mark", "ring", (RING, 0.0))),
        gravity=GRAVITY,
    )


def rack_and_wheel(span: tuple[float, float] | None = None) -> Mechanism:
    """A saw's slider is a rack, and turns a wheel above it; with a span the slider-crank's input makes one pass."""
    crank, rod, height = 0.1, 0.3, WHEEL
    bodies = (Body("crank", 1.0, 1e-3), Body("rod", 0.6, 5e-3, (0.15, 0.0)), Body("rack", 0.8, 1e-3), WHEEL_BODY)
    poses: dict[str, Pose] = {
        "crank": (0.0, 0.0, 0.0),
        "rod": (crank, 0.0, 0.0),
        "rack": (crank + rod, 0.0, 0.0),
        "wheel": (0.3, height, 0.0),
    }
    return Mechanism(
        name="rack-and-wheel",
        bodies=bodies,
        joints=(
            Revolute("shaft", "ground", "crank", (0.0, 0.0), (0.0, 0.0)),
            Revolute("crank-pin", "crank", "rod", (crank, 0.0), (0.0, 0.0)),
            Revolute("rack-pin", "rod", "rack", (rod, 0.0), (0.0, 0.0)),
            Prismatic("slide", "ground", "rack", (0.0, 0.0), (0.0, 0.0), direction=0.0),
            Revolute("axle", "ground", "wheel", (0.3, height), (0.0, 0.0)),
            Rack("teeth", "wheel", "rack", (0.0, 0.0), (0.0, 0.0), WHEEL, direction=0.0, offset=-0.1),
        ),
        driver=Driver("shaft", span=span),
        poses=poses,
        observed=(ObservedPoint("mark", "wheel", (0.0, WHEEL)), ObservedPoint("tooth", "rack")),
        gravity=GRAVITY,
    )


WHEEL_BODY = Body("wheel", 1.0, 3e-3)


def wheel_on_a_track() -> Mechanism:
    """A pinion drives a rack that carries the axle of a wheel; the wheel rolls on the ground beneath, over a span.

    The rack's teeth look down at the pinion. One turn of the crank takes the axle 2 pi TOOTH to the right or left, so
    that the poses never repeat.
    """
    return Mechanism(
        name="wheel-on-a-track",
        bodies=(Body("pinion", 0.5, 1e-3), Body("carriage", 0.7, 1e-3), WHEEL_BODY),
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
    machine = example_5_6()
    return replace(
        machine,
        name="swinging-four-bar",
        bodies=(
            Body("crank", 0.5, 1e-3),
            Body("coupler", 1.0, 4e-3, (0.1, 0.0)),
            Body("rocker", 0.7, 2e-3, (0.07, 0.0)),
        ),
        joints=tuple(replace(joint, name="shaft" if joint.name == "O12" else joint.name) for joint in machine.joints),
        driver=replace(machine.driver, joint="shaft", span=span),
        observed=(ObservedPoint("joint", "coupler", (0.21, 0.0)),),
        gravity=GRAVITY,
    )


def turned_wheel(mechanism: Mechanism, name: str, radius: float) -> Mechanism:
    """With another radius in a rolling pair: a wrong number of teeth (the shafts stay where they are)."""
    pair = next(joint for joint in mechanism.meshes if joint.name == name)
    assert isinstance(pair, Rolling)
    return replace(
        mechanism,
        joints=tuple(replace(pair, radius_b=radius) if joint is pair else joint for joint in mechanism.joints),
    )


def poses_of(machine: GenericReference, body: str, angle: Array) -> Array:
    """Exact poses (T, 3) of a body."""
    i = 3 * machine.described.body_index[body]
    return np.asarray(machine.kinematics.poses(angle)[:, i : i + 3])


PASS = (-0.4, 0.3)  # [rad], of the crank
MACHINES = {
    "inverted slider-crank": inverted_slider_crank(),
    "gears": gear_pair(),
    "ring gear": gear_pair(TOOTH, -WHEEL),
    "planetary gear": planetary_gear(),
    "planetary gear, all turn": planetary_gear("sun"),
    "rack and wheel": rack_and_wheel(),
    "wheel on a track": wheel_on_a_track(),
    "four-bar, one pass": swinging_four_bar(PASS),
    "rack and wheel, one pass": rack_and_wheel((-0.5, 0.7)),
}
