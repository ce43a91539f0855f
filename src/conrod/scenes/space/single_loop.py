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
    Drives,
    LinkJoint,
    LoopClosure,
    ModelLink,
    SpatialMachine,
    X,
    Y,
    Z,
    cross,
    dot,
    hinge_closure,
    reference_pose,
    rotate,
    rotate_fixed,
    unit,
)

HINGE_HALF_LENGTH = 0.02  # [m], of a hinge that is closed at both ends
TILT_AXIS, SHAFT_PLACE = (X + 2.0 * Y - Z) / np.linalg.norm(X + 2.0 * Y - Z), 0.1 * (X - Y + 2.0 * Z)


def cardan_output_angle(driving: Jet, bend: float) -> Jet:
    """Angle of a Cardan joint's driven shaft, continuous with the driving one's: tan(out) = cos(bend) tan(in).

    An arm of the driving fork starts across the plane of both shafts, at Z; the driven arm stays perpendicular to it
    (Uicker, Pennock and Shigley, Theory of Machines and Mechanisms, Hooke universal joint).
    """
    sine, cosine = sine_cosine(driving)
    k = math.cos(bend)
    return driving + direction(cosine * cosine + k * sine * sine, (k - 1.0) * sine * cosine)


def cardan_joint(bend: float = 30.0 * DEGREE, arm: float = 0.04, shaft: float = 0.2) -> SpatialMachine:
    """Cardan joint: its output runs at cos(bend) to 1 / cos(bend) of the input's speed, twice per revolution."""
    out = rotate_fixed(X, Z, bend)
    across = np.cross(Z, out)

    def closed_form(drives: Drives) -> dict[str, Jet]:
        turn = drives["input"]
        return {
            "input_arm": arm * rotate(Z, X, turn),
            "output_arm": arm * rotate(across, out, cardan_output_angle(turn, bend)),
        }

    pins, forks, closures = hinge_closure("cross", ORIGIN, arm * across)
    cross_link = ModelLink("cross", ORIGIN, (LinkJoint("cross", Z),), tuple(pins.values()), pins)
    links = (
        ModelLink("input_shaft", ORIGIN, (LinkJoint("input", X),), (-shaft * X, arm * Z), {"input_arm": arm * Z},
        (cross_link,)), ModelLink("output_shaft", ORIGIN, (LinkJoint("output", out),), (shaft * out, *forks.values()),
             {"output_arm": arm * across, **forks}),
    )  # fmt: skip
    return SpatialMachine("cardan", "Cardan joint", links, closures, {"input": "60rpm"}, closed_form)


def solve_harmonic_equation(a: Jet, b: Jet, c: Jet, branch: float) -> tuple[Jet, Jet]:
    """Cosine and sine of the angle that solves a cos + b sin = c, on one side of the direction (a, b).

    The output angle of a four-bar obeys such an equation (McCarthy and Soh, Geometric Design of Linkages).

    Args:
        branch: +1 or -1, the side of (a, b).
    """
    square = a * a + b * b
    root = branch * square_root(square - c * c)
    inverse = reciprocal(square)
    return (a * c - b * root) * inverse, (b * c + a * root) * inverse


def spherical_four_bar(
    crank: float = 30.0 * DEGREE, coupler: float = 60.0 * DEGREE, rocker: float = 70.0 * DEGREE,
    frame: float = 80.0 * DEGREE, radius: float = 0.2,
) -> SpatialMachine:  # fmt: skip
    """Spherical four-bar: four hinges whose axes meet in a point; the links are arcs [rad] of a sphere.

    The moving axes keep the coupler's arc between them, crank_axis . rocker_axis = cos(coupler).
    """
    out = rotate_fixed(Z, Y, frame)
    crank_start = rotate_fixed(Z, Y, crank)
    toward = np.cross(Y, out)  # across the output axis, in the plane of the frame

    def closed_form(drives: Drives) -> dict[str, Jet]:
        crank_axis = rotate(crank_start, Z, drives["input"])
        along = dot(crank_axis, out)
        a, b = math.sin(rocker) * dot(crank_axis, toward), math.sin(rocker) * dot(crank_axis, Y)
        cosine, sine = solve_harmonic_equation(a, b, math.cos(coupler) - math.cos(rocker) * along, -1.0)
        rocker_axis = math.sin(rocker) * (cosine * toward + sine * Y) + math.cos(rocker) * out
        return {
            "crank_pin": radius * crank_axis,
            "rocker_pin": radius * rocker_axis,
            "coupler_middle": 0.5 * radius * (crank_axis + rocker_axis),
        }

    at = reference_pose(closed_form, ["input"])
    pin, rocker_pin = at["crank_pin"], at["rocker_pin"]
    coupler_link = ModelLink("coupler", pin, (LinkJoint("coupler", crank_start),), (rocker_pin,),
                        {"coupler_pin": rocker_pin, "coupler_middle": at["coupler_middle"]})  # fmt: skip
    links = (
        ModelLink("crank", ORIGIN, (LinkJoint("input", Z),), (pin,), {"crank_pin": pin}, (coupler_link,)),
        ModelLink("rocker", ORIGIN, (LinkJoint("output", out),), (rocker_pin,), {"rocker_pin": rocker_pin}),
    )
    closures = [LoopClosure("rocker_pin", "coupler_pin", "rocker_pin")]
    drives = {"input": "60rpm"}
    return SpatialMachine("spherical-four-bar", "Spherical four-bar", links, closures, drives, closed_form)


def rssr(
    rod_joint: Literal["universal", "ball"] = "universal", crank: float = 0.08, rocker: float = 0.25, rod: float = 0.42,
    branch: float = 1.0,
) -> SpatialMachine:  # fmt: skip
    """RSSR linkage: crank and rocker on skew axes at a right angle, with a rod between their pins.

    The rod keeps its length, |rocker_pin - crank_pin| = rod.

    Args:
        branch: +1 or -1, the rocker's side on which the rod is assembled.
        rod_joint: joint of the rod at the crank. With a ball there, as at the rocker, it spins idly about its axis.
    """
    pivot = np.array([0.3, 0.15, 0.05])

    def closed_form(drives: Drives) -> dict[str, Jet]:
        crank_pin = crank * rotate(X, Z, drives["input"])
        reach = -crank_pin + pivot  # from the crank pin to the rocker's pivot
        a, b = 2.0 * rocker * dot(reach, Y), 2.0 * rocker * dot(reach, Z)
        cosine, sine = solve_harmonic_equation(a, b, -dot(reach, reach) + (rod**2 - rocker**2), branch)
        rocker_pin = rocker * (cosine * Y + sine * Z) + pivot
        return {"crank_pin": crank_pin, "rocker_pin": rocker_pin, "rod_middle": 0.5 * (crank_pin + rocker_pin)}

    at = reference_pose(closed_form, ["input"])
    pin, rocker_pin = at["crank_pin"], at["rocker_pin"]
    sites = {"rod_end": rocker_pin, "rod_middle": at["rod_middle"]}
    universal = (LinkJoint("rod_swing", Z), LinkJoint("rod_pitch", np.cross(Z, rocker_pin - pin)))
    rod_joints = universal if rod_joint == "universal" else (LinkJoint("rod", Z, "ball"),)
    rod_link = ModelLink("rod", pin, rod_joints, (rocker_pin,), sites)
    links = (
        ModelLink("crank", ORIGIN, (LinkJoint("input", Z),), (pin,), {"crank_pin": pin}, (rod_link,)),
        ModelLink("rocker", pivot, (LinkJoint("output", X),), (rocker_pin,), {"rocker_pin": rocker_pin}),
    )
    heading = {
        "universal": ("rssr", "RSSR, its rod held against idle spin"),
        "ball": ("rssr-idle-spin", "RSSR, its rod free to spin"),
    }[rod_joint]
    closures = [LoopClosure("rocker_pin", "rod_end", "rocker_pin")]
    return SpatialMachine(*heading, links, closures, {"input": "60rpm"}, closed_form)


def bennett(
    side: float = 0.2, twist: float = 40.0 * DEGREE, other_twist: float = 75.0 * DEGREE, start: float = 60.0 * DEGREE
) -> SpatialMachine:
    """Bennett linkage: four skew hinges; opposite links are equal, and sin(twist) / length is the same for all.

    tan(input / 2) tan(coupler / 2) = sin((other + twist) / 2) / sin((other - twist) / 2), and output = coupler
    (Bennett, A new mechanism, Engineering 76, 1903; Hunt, Kinematic Geometry of Mechanisms).

    Args:
        side, twist: length [m] of crank and rocker, and the angle [rad] between their hinges.
        other_twist: the angle [rad] of coupler and frame, whose length follows.
        start: angle [rad] of the crank from the extended line of the frame, in the reference pose.
    """
    other = side * math.sin(other_twist) / math.sin(twist)
    k = math.sin(0.5 * (other_twist + twist)) / math.sin(0.5 * (other_twist - twist))
    pivot, out = -other * X, rotate_fixed(Z, X, -other_twist)

    def closed_form(drives: Drives) -> dict[str, Jet]:
        turn = drives["input"] + start
        sine, cosine = sine_cosine(0.5 * turn)
        # Twice atan2(k cosine, sine), written so that it is continuous over many turns.
        coupler = math.pi - turn - 2.0 * direction(k * cosine * cosine + sine * sine, (1.0 - k) * sine * cosine)
        crank_line = rotate(X, Z, turn)
        crank_axis = math.sin(twist) * cross(crank_line, Z) + math.cos(twist) * Z
        sine, cosine = sine_cosine(coupler)
        coupler_line = cosine * crank_line + sine * cross(crank_axis, crank_line)
        crank_pin = side * crank_line
        return {
            "crank_pin": crank_pin,
            "rocker_pin": side * rotate(-X, out, coupler) + pivot,
            "coupler_middle": crank_pin + 0.5 * other * coupler_line + HINGE_HALF_LENGTH * crank_axis,
        }

    at = reference_pose(closed_form, ["input"])
    crank_pin, rocker_pin = at["crank_pin"], at["rocker_pin"]
    crank_axis = rotate_fixed(Z, unit(crank_pin), twist)
    rocker_axis = rotate_fixed(crank_axis, unit(rocker_pin - crank_pin), other_twist)
    pins, eyes, closures = hinge_closure("rocker", rocker_pin, HINGE_HALF_LENGTH * rocker_axis)
    coupler_link = ModelLink("coupler", crank_pin, (LinkJoint("coupler", crank_axis),), (rocker_pin,),
                        {"coupler_middle": at["coupler_middle"], **pins})  # fmt: skip
    links = (
        ModelLink("crank", ORIGIN, (LinkJoint("input", Z),), (crank_pin,), {"crank_pin": crank_pin}, (coupler_link,)),
        ModelLink("rocker", pivot, (LinkJoint("output", out),), (rocker_pin,), {"rocker_pin": rocker_pin, **eyes}),
    )
    return SpatialMachine("bennett", "Bennett linkage", links, closures, {"input": "60rpm"}, closed_form)


def tilted_slider_crank(
    crank: float = 0.1, rod: float = 0.3, offset: float = 0.02, tilt: float = 50.0 * DEGREE, axis: Array = TILT_AXIS,
    origin: Array = SHAFT_PLACE,
) -> SpatialMachine:  # fmt: skip
    """Offset slider-crank in a tilted plane, its loop closed with three redundant equations.

    Slide = crank cos(input) + sqrt(rod^2 - (crank sin(input) - offset)^2), along the slide's line (Uicker, Pennock and
    Shigley, Theory of Machines and Mechanisms). The rod is cut in the middle and welded: six equations where the plane
    leaves three.

    Args:
        crank, rod, offset: lengths [m], and the slide's distance from the shaft.
        tilt, axis: the plane is XY turned by an angle [rad] about a unit axis.
        origin: the shaft's place in the world [m].
    """
    along, across, shaft = (rotate_fixed(v, axis, tilt) for v in (X, Y, Z))

    def closed_form(drives: Drives) -> dict[str, Jet]:
        sine, cosine = sine_cosine(drives["input"])
        drop = offset - crank * sine
        slide = crank * cosine + square_root(rod**2 - drop * drop)
        crank_pin = crank * (cosine * along + sine * across) + origin
        slider = slide * along + (offset * across + origin)
        return {"crank_pin": crank_pin, "slider": slider, "rod_middle": 0.5 * (crank_pin + slider)}

    at = reference_pose(closed_form, ["input"])
    pin, slider, middle = at["crank_pin"], at["slider"], at["rod_middle"]
    rod_link = ModelLink("rod", pin, (LinkJoint("rod", shaft),), (middle,), {"rod_middle": middle})
    wrist_link = ModelLink("rod_end", slider, (LinkJoint("wrist", shaft),), (middle,))
    links = (
        ModelLink("crank", origin, (LinkJoint("input", shaft),), (pin,), {"crank_pin": pin}, (rod_link,)),
        ModelLink("slider", slider, (LinkJoint("output", along, "slide"),), (), {"slider": slider}, (wrist_link,)),
    )
    closures, drives = [LoopClosure("rod_weld", "rod", "rod_end", "weld")], {"input": "60rpm"}
    return SpatialMachine("tilted-slider-crank", "Slider-crank turned in space", links, closures, drives, closed_form)
