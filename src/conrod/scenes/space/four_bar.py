"""Four-bars in space whose output angle obeys a cos + b sin = c: the spherical four-bar and the RSSR."""

from __future__ import annotations

import math
from typing import Literal

import numpy as np

from conrod.exact.jet import direction
from conrod.scenes.space.machine import Drives, SpatialMachine, SpatialMotion, start_pose
from conrod.scenes.space.model import ORIGIN, Closure, Joint, Link
from conrod.scenes.space.vectors import DEGREE, X, Y, Z, dot, harmonic_root, hinge_angle, rod_angles, rotated, turned


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

    def closed_form(drives: Drives) -> SpatialMotion:
        turn = drives["input"]
        crank_axis = turned(crank_start, Z, turn)
        along = dot(crank_axis, out)
        a, b = math.sin(rocker) * dot(crank_axis, toward), math.sin(rocker) * dot(crank_axis, Y)
        cosine, sine = harmonic_root(a, b, math.cos(coupler) - math.cos(rocker) * along, -1.0)
        rocker_axis = math.sin(rocker) * (cosine * toward + sine * Y) + math.cos(rocker) * out
        return SpatialMotion(
            points={"crank_pin": radius * crank_axis, "rocker_pin": radius * rocker_axis,
                    "coupler_middle": 0.5 * radius * (crank_axis + rocker_axis)},
            joints={"input": turn, "coupler": hinge_angle(crank_axis, Z, rocker_axis),
                    "output": direction(cosine, sine)},
        )  # fmt: skip

    at = start_pose(closed_form, ["input"])
    pin, rocker_pin = at["crank_pin"], at["rocker_pin"]
    coupler_link = Link("coupler", pin, (Joint("coupler", crank_start),), (rocker_pin,),
                        {"coupler_pin": rocker_pin, "coupler_middle": at["coupler_middle"]})  # fmt: skip
    links = (
        Link("crank", ORIGIN, (Joint("input", Z),), (pin,), {"crank_pin": pin}, (coupler_link,)),
        Link("rocker", ORIGIN, (Joint("output", out),), (rocker_pin,), {"rocker_pin": rocker_pin}),
    )
    closures = [Closure("rocker_pin", "coupler_pin", "rocker_pin")]
    source = "McCarthy, Soh: Geometric Design of Linkages, spherical 4R linkage: a cos + b sin = c for the output angle"
    return SpatialMachine(
        "spherical-four-bar", "Spherical four-bar", source, links, closures, {"input": "60rpm"}, closed_form,
        degrees_of_freedom=1, gruebler=-2,
    )  # fmt: skip


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

    def closed_form(drives: Drives) -> SpatialMotion:
        turn = drives["input"]
        crank_pin = crank * turned(X, Z, turn)
        reach = -crank_pin + pivot  # and then on to the rocker's pin, across X
        a, b = 2.0 * rocker * dot(reach, Y), 2.0 * rocker * dot(reach, Z)
        cosine, sine = harmonic_root(a, b, -dot(reach, reach) + (rod**2 - rocker**2), branch)
        rocker_pin = rocker * (cosine * Y + sine * Z) + pivot
        swing, pitch = rod_angles(rocker_pin - crank_pin, Z, X)
        rod_turns = {"rod_swing": swing - turn, "rod_pitch": pitch} if rod_joint == "universal" else {}
        return SpatialMotion(
            points={"crank_pin": crank_pin, "rocker_pin": rocker_pin, "rod_middle": 0.5 * (crank_pin + rocker_pin)},
            joints={"input": turn, **rod_turns, "output": direction(cosine, sine)},
        )

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
    name, title, mobility = {
        "universal": ("rssr", "RSSR, its rod held against idle spin", 1),
        "ball": ("rssr-idle-spin", "RSSR, its rod free to spin", 2),
    }[rod_joint]
    closures = [Closure("rocker_pin", "rod_end", "rocker_pin")]
    source = "McCarthy, Soh: Geometric Design of Linkages, RSSR linkage: a cos + b sin = c for the output angle"
    return SpatialMachine(
        name, title, source, links, closures, {"input": "60rpm"}, closed_form,
        degrees_of_freedom=mobility, gruebler=mobility,
    )  # fmt: skip
