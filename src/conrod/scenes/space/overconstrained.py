"""Linkages of hinges alone that move although the count of their freedoms says that they do not: Bennett and Sarrus."""

from __future__ import annotations

import math

from conrod.exact.jet import direction, reciprocal, sine_cosine, square_root
from conrod.scenes.space.machine import Drives, SpatialMachine, SpatialMotion, start_pose
from conrod.scenes.space.model import ORIGIN, Joint, Link, hinge_closure
from conrod.scenes.space.vectors import DEGREE, X, Y, Z, cross, rotated, turned, unit

PIN = 0.02  # [m], half the length of a hinge that is closed at both ends


def bennett(
    side: float = 0.2, twist: float = 40.0 * DEGREE, other_twist: float = 75.0 * DEGREE, start: float = 60.0 * DEGREE
) -> SpatialMachine:
    """Four skew hinges; opposite links are equal, and sin(twist) / length is the same for all (Bennett's condition).

    tan(input / 2) tan(coupler / 2) = sin((other + twist) / 2) / sin((other - twist) / 2), and output = coupler.

    Args:
        side, twist: length [m] of crank and rocker, and the angle [rad] between their hinges.
        other_twist: the angle [rad] of coupler and frame, whose length follows.
        start: angle [rad] of the crank from the frame's line, produced, in the reference pose.
    """
    other = side * math.sin(other_twist) / math.sin(twist)
    k = math.sin(0.5 * (other_twist + twist)) / math.sin(0.5 * (other_twist - twist))
    pivot, out = -other * X, rotated(Z, X, -other_twist)

    def closed_form(drives: Drives) -> SpatialMotion:
        turn = drives["input"] + start
        sine, cosine = sine_cosine(0.5 * turn)
        # Twice atan2(k cosine, sine), written so that it goes on turn after turn.
        coupler = math.pi - turn - 2.0 * direction(k * cosine * cosine + sine * sine, (1.0 - k) * sine * cosine)
        crank_line = turned(X, Z, turn)
        crank_axis = math.sin(twist) * cross(crank_line, Z) + math.cos(twist) * Z
        sine, cosine = sine_cosine(coupler)
        coupler_line = cosine * crank_line + sine * cross(crank_axis, crank_line)
        crank_pin = side * crank_line
        return SpatialMotion(
            points={
                "crank_pin": crank_pin,
                "rocker_pin": side * turned(-X, out, coupler) + pivot,
                "coupler_middle": crank_pin + 0.5 * other * coupler_line + PIN * crank_axis,
            },
            joints={"input": turn, "coupler": coupler, "output": coupler},
        )

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
    source = "Bennett (1903), A new mechanism, Engineering 76; Hunt: Kinematic Geometry of Mechanisms"
    return SpatialMachine(
        "bennett", "Bennett linkage", source, links, closures, {"input": "60rpm"}, closed_form,
        degrees_of_freedom=1, gruebler=-2,
    )  # fmt: skip


def sarrus(
    lower: float = 0.15, upper: float = 0.2, other_lower: float = 0.18, other_upper: float = 0.16,
    offset: float = 0.1, start: float = 50.0 * DEGREE,
) -> SpatialMachine:  # fmt: skip
    """Two chains of three parallel hinges, in planes at a right angle, carry a plate straight up and down along Z.

    Each chain bends in its plane like a slider-crank: height = lower sin(a) + sqrt(upper^2 - lower^2 cos^2(a)).

    Args:
        lower, upper, other_lower, other_upper: lengths [m] of the links of both chains.
        offset: distance [m] of a chain's outer hinges from Z.
        start: angle [rad] of the driven link above the ground in the reference pose.
    """

    def closed_form(drives: Drives) -> SpatialMotion:
        turn = drives["input"] + start
        sine, cosine = sine_cosine(turn)
        rise = square_root(upper**2 - lower**2 * cosine * cosine)
        height = lower * sine + rise
        slope = direction(-lower * cosine, rise)
        # The other chain's lower link, from the triangle of its links and the height.
        other_sine = (height * height + (other_lower**2 - other_upper**2)) * reciprocal(2.0 * other_lower * height)
        other_cosine = square_root(1.0 - other_sine * other_sine)
        other_slope = direction(-other_lower * other_cosine, height - other_lower * other_sine)
        other_turn = direction(other_cosine, other_sine)
        return SpatialMotion(
            points={
                "knee": lower * (cosine * X + sine * Z) + offset * X,
                "other_knee": other_lower * (other_cosine * Y + other_sine * Z) + offset * Y,
                "plate": height * Z,
            },
            joints={"input": turn, "knee": slope - turn, "plate": -slope,
                    "other_lower": other_turn, "other_knee": other_slope - other_turn},
        )  # fmt: skip

    at = start_pose(closed_form, ["input"])
    plate, knee, other_knee = at["plate"], at["knee"], at["other_knee"]
    pins, eyes, closures = hinge_closure("other_plate", plate + offset * Y, PIN * X)
    corner, other_corner = plate + offset * X, plate + offset * Y
    plate_link = Link("plate", corner, (Joint("plate", -Y),), (plate, other_corner), {"plate": plate, **pins})
    upper_link = Link("upper", knee, (Joint("knee", -Y),), (corner,), {}, (plate_link,))
    other_upper_link = Link("other_upper", other_knee, (Joint("other_knee", X),), (other_corner,), eyes)
    links = (
        Link("lower", offset * X, (Joint("input", -Y),), (knee,), {"knee": knee}, (upper_link,)),
        Link("other_lower", offset * Y, (Joint("other_lower", X),), (other_knee,), {"other_knee": other_knee},
             (other_upper_link,)),
    )  # fmt: skip
    source = "Sarrus (1853), Comptes rendus 36; Hunt: Kinematic Geometry of Mechanisms"
    return SpatialMachine(
        "sarrus", "Sarrus linkage", source, links, closures, {"input": "sine:20deg,1Hz"}, closed_form,
        degrees_of_freedom=1, gruebler=0,
    )  # fmt: skip
