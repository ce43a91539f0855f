"""Machines in space with one loop: Cardan joint, spherical four-bar, RSSR, Bennett, and a tilted slider-crank."""

from __future__ import annotations

import math
from typing import Literal

import numpy as np

from conrod.exact.jet import Jet, direction, reciprocal, sine_cosine, square_root
from conrod.exact.motion import Array
from conrod.scenes.space.machine import (
    DEGREE,
    ORIGIN,
    Closure,
    Drives,
    Joint,
    Link,
    SpatialMachine,
    X,
    Y,
    Z,
    cross,
    dot,
    hinge_closure,
    rotated,
    start_pose,
    turned,
    unit,
)

PIN = 0.02  # [m], half the length of a hinge that is closed at both ends
AXIS, SHAFT = (X + 2.0 * Y - Z) / np.linalg.norm(X + 2.0 * Y - Z), 0.1 * (X - Y + 2.0 * Z)


def driven_angle(driving: Jet, bend: float) -> Jet:
    """Angle of a Cardan joint's driven shaft, within a quarter turn of the driving one's: tan(out) = cos(bend) tan(in).

    An arm of the driving fork starts across the plane of both shafts, at Z; the driven arm stays perpendicular to it
    (Uicker, Pennock and Shigley, Theory of Machines and Mechanisms, Hooke universal joint).
    """
    sine, cosine = sine_cosine(driving)
    k = math.cos(bend)
    return driving + direction(cosine * cosine + k * sine * sine, (k - 1.0) * sine * cosine)


def cardan_joint(bend: float = 30.0 * DEGREE, arm: float = 0.04, shaft: float = 0.2) -> SpatialMachine:
    """A single joint: the output runs at cos(bend) to 1 / cos(bend) of the input's speed, twice a turn."""
    out = rotated(X, Z, bend)
    across = np.cross(Z, out)

    def closed_form(drives: Drives) -> dict[str, Jet]:
        turn = drives["input"]
        return {
            "input_arm": arm * turned(Z, X, turn),
            "output_arm": arm * turned(across, out, driven_angle(turn, bend)),
        }

    pins, forks, closures = hinge_closure("cross", ORIGIN, arm * across)
    cross_link = Link("cross", ORIGIN, (Joint("cross", Z),), tuple(pins.values()), pins)
    links = (
        Link("input_shaft", ORIGIN, (Joint("input", X),), (-shaft * X, arm * Z), {"input_arm": arm * Z}, (cross_link,)),
        Link("output_shaft", ORIGIN, (Joint("output", out),), (shaft * out, *forks.values()),
             {"output_arm": arm * across, **forks}),
    )  # fmt: skip
    return SpatialMachine("cardan", "Cardan joint", links, closures, {"input": "60rpm"}, closed_form)


def harmonic_root(a: Jet, b: Jet, c: Jet, branch: float) -> tuple[Jet, Jet]:
    """Cosine and sine of the angle with a cos + b sin = c; the branch, +1 or -1, is the side of (a, b) that it is on.

    The output angle of a four-bar obeys such an equation (McCarthy and Soh, Geometric Design of Linkages).
    """
    square = a * a + b * b
    root = branch * square_root(square - c * c)
    inverse = reciprocal(square)
    return (a * c - b * root) * inverse, (b * c + a * root) * inverse


def spherical_four_bar(
    crank: float = 30.0 * DEGREE, coupler: float = 60.0 * DEGREE, rocker: float = 70.0 * DEGREE,
    frame: float = 80.0 * DEGREE, radius: float = 0.2,
) -> SpatialMachine:  # fmt: skip
    """Four hinges whose axes meet in a point; the links are arcs [rad] of a sphere.

    The moving axes keep the coupler's arc between them, crank_axis . rocker_axis = cos(coupler).
    """
    out = rotated(Z, Y, frame)
    crank_start = rotated(Z, Y, crank)
    toward = np.cross(Y, out)  # across the output axis, in the plane of the frame

    def closed_form(drives: Drives) -> dict[str, Jet]:
        crank_axis = turned(crank_start, Z, drives["input"])
        along = dot(crank_axis, out)
        a, b = math.sin(rocker) * dot(crank_axis, toward), math.sin(rocker) * dot(crank_axis, Y)
        cosine, sine = harmonic_root(a, b, math.cos(coupler) - math.cos(rocker) * along, -1.0)
        rocker_axis = math.sin(rocker) * (cosine * toward + sine * Y) + math.cos(rocker) * out
        return {
            "crank_pin": radius * crank_axis,
            "rocker_pin": radius * rocker_axis,
            "coupler_middle": 0.5 * radius * (crank_axis + rocker_axis),
        }

    at = start_pose(closed_form, ["input"])
    pin, rocker_pin = at["crank_pin"], at["rocker_pin"]
    coupler_link = Link("coupler", pin, (Joint("coupler", crank_start),), (rocker_pin,),
                        {"coupler_pin": rocker_pin, "coupler_middle": at["coupler_middle"]})  # fmt: skip
    links = (
        Link("crank", ORIGIN, (Joint("input", Z),), (pin,), {"crank_pin": pin}, (coupler_link,)),
        Link("rocker", ORIGIN, (Joint("output", out),), (rocker_pin,), {"rocker_pin": rocker_pin}),
    )
    closures = [Closure("rocker_pin", "coupler_pin", "rocker_pin")]
    drives = {"input": "60rpm"}
    return SpatialMachine("spherical-four-bar", "Spherical four-bar", links, closures, drives, closed_form)


def rssr(
    rod_joint: Literal["universal", "ball"] = "universal", crank: float = 0.08, rocker: float = 0.25, rod: float = 0.42,
    branch: float = 1.0,
) -> SpatialMachine:  # fmt: skip
    """Crank and rocker on skew axes at a right angle, and a rod between their pins, |rocker_pin - crank_pin| = rod.

    Args:
        branch: +1 or -1, the rocker's side on which the rod is assembled.
        rod_joint: what holds the rod at the crank. With a ball there, as at the rocker, it spins idly about itself.
    """
    pivot = np.array([0.3, 0.15, 0.05])

    def closed_form(drives: Drives) -> dict[str, Jet]:
        crank_pin = crank * turned(X, Z, drives["input"])
        reach = -crank_pin + pivot  # and then on to the rocker's pin, across X
        a, b = 2.0 * rocker * dot(reach, Y), 2.0 * rocker * dot(reach, Z)
        cosine, sine = harmonic_root(a, b, -dot(reach, reach) + (rod**2 - rocker**2), branch)
        rocker_pin = rocker * (cosine * Y + sine * Z) + pivot
        return {"crank_pin": crank_pin, "rocker_pin": rocker_pin, "rod_middle": 0.5 * (crank_pin + rocker_pin)}

    at = start_pose(closed_form, ["input"])
    pin, rocker_pin = at["crank_pin"], at["rocker_pin"]
    sites = {"rod_end": rocker_pin, "rod_middle": at["rod_middle"]}
    universal = (Joint("rod_swing", Z), Joint("rod_pitch", np.cross(Z, rocker_pin - pin)))
    rod_joints = universal if rod_joint == "universal" else (Joint("rod", Z, "ball"),)
    rod_link = Link("rod", pin, rod_joints, (rocker_pin,), sites)
    links = (
        Link("crank", ORIGIN, (Joint("input", Z),), (pin,), {"crank_pin": pin}, (rod_link,)),
        Link("rocker", pivot, (Joint("output", X),), (rocker_pin,), {"rocker_pin": rocker_pin}),
    )
    heading = {
        "universal": ("rssr", "RSSR, its rod held against idle spin"),
        "ball": ("rssr-idle-spin", "RSSR, its rod free to spin"),
    }[rod_joint]
    closures = [Closure("rocker_pin", "rod_end", "rocker_pin")]
    return SpatialMachine(*heading, links, closures, {"input": "60rpm"}, closed_form)


def bennett(
    side: float = 0.2, twist: float = 40.0 * DEGREE, other_twist: float = 75.0 * DEGREE, start: float = 60.0 * DEGREE
) -> SpatialMachine:
    """Four skew hinges; opposite links are equal, and sin(twist) / length is the same for all (Bennett's condition).

    tan(input / 2) tan(coupler / 2) = sin((other + twist) / 2) / sin((other - twist) / 2), and output = coupler
    (Bennett, A new mechanism, Engineering 76, 1903; Hunt, Kinematic Geometry of Mechanisms).

    Args:
        side, twist: length [m] of crank and rocker, and the angle [rad] between their hinges.
        other_twist: the angle [rad] of coupler and frame, whose length follows.
        start: angle [rad] of the crank from the frame's line, produced, in the reference pose.
    """
    other = side * math.sin(other_twist) / math.sin(twist)
    k = math.sin(0.5 * (other_twist + twist)) / math.sin(0.5 * (other_twist - twist))
    pivot, out = -other * X, rotated(Z, X, -other_twist)

    def closed_form(drives: Drives) -> dict[str, Jet]:
        turn = drives["input"] + start
        sine, cosine = sine_cosine(0.5 * turn)
        # Twice atan2(k cosine, sine), written so that it goes on turn after turn.
        coupler = math.pi - turn - 2.0 * direction(k * cosine * cosine + sine * sine, (1.0 - k) * sine * cosine)
        crank_line = turned(X, Z, turn)
        crank_axis = math.sin(twist) * cross(crank_line, Z) + math.cos(twist) * Z
        sine, cosine = sine_cosine(coupler)
        coupler_line = cosine * crank_line + sine * cross(crank_axis, crank_line)
        crank_pin = side * crank_line
        return {
            "crank_pin": crank_pin,
            "rocker_pin": side * turned(-X, out, coupler) + pivot,
            "coupler_middle": crank_pin + 0.5 * other * coupler_line + PIN * crank_axis,
        }

    at = start_pose(closed_form, ["input"])
    crank_pin, rocker_pin = at["crank_pin"], at["rocker_pin"]
    crank_axis = rotated(Z, unit(crank_pin), twist)
    rocker_axis = rotated(crank_axis, unit(rocker_pin - crank_pin), other_twist)
    pins, eyes, closures = hinge_closure("rocker", rocker_pin, PIN * rocker_axis)
    coupler_link = Link("coupler", crank_pin, (Joint("coupler", crank_axis),), (rocker_pin,),
                        {"coupler_middle": at["coupler_middle"], **pins})  # fmt: skip
    links = (
        Link("crank", ORIGIN, (Joint("input", Z),), (crank_pin,), {"crank_pin": crank_pin}, (coupler_link,)),
        Link("rocker", pivot, (Joint("output", out),), (rocker_pin,), {"rocker_pin": rocker_pin, **eyes}),
    )
    return SpatialMachine("bennett", "Bennett linkage", links, closures, {"input": "60rpm"}, closed_form)


def tilted_slider_crank(
    crank: float = 0.1, rod: float = 0.3, offset: float = 0.02, tilt: float = 50.0 * DEGREE, axis: Array = AXIS,
    origin: Array = SHAFT,
) -> SpatialMachine:  # fmt: skip
    """An offset slider-crank in a plane that stands at any angle, its loop closed with more than it takes.

    Slide = crank cos(input) + sqrt(rod^2 - (crank sin(input) - offset)^2), along the slide's line (Uicker, Pennock and
    Shigley, Theory of Machines and Mechanisms). The rod is cut in the middle and welded: six equations where the plane
    leaves three.

    Args:
        crank, rod, offset: lengths [m], and the slide's distance from the shaft.
        tilt, axis: the plane is XY turned by an angle [rad] about a unit axis.
        origin: the shaft's place in the world [m].
    """
    along, across, shaft = (rotated(v, axis, tilt) for v in (X, Y, Z))

    def closed_form(drives: Drives) -> dict[str, Jet]:
        sine, cosine = sine_cosine(drives["input"])
        drop = offset - crank * sine
        slide = crank * cosine + square_root(rod**2 - drop * drop)
        crank_pin = crank * (cosine * along + sine * across) + origin
        slider = slide * along + (offset * across + origin)
        return {"crank_pin": crank_pin, "slider": slider, "rod_middle": 0.5 * (crank_pin + slider)}

    at = start_pose(closed_form, ["input"])
    pin, slider, middle = at["crank_pin"], at["slider"], at["rod_middle"]
    rod_link = Link("rod", pin, (Joint("rod", shaft),), (middle,), {"rod_middle": middle})
    wrist_link = Link("rod_end", slider, (Joint("wrist", shaft),), (middle,))
    links = (
        Link("crank", origin, (Joint("input", shaft),), (pin,), {"crank_pin": pin}, (rod_link,)),
        Link("slider", slider, (Joint("output", along, "slide"),), (), {"slider": slider}, (wrist_link,)),
    )
    closures, drives = [Closure("rod_weld", "rod", "rod_end", "weld")], {"input": "60rpm"}
    return SpatialMachine("tilted-slider-crank", "Slider-crank turned in space", links, closures, drives, closed_form)
