"""Parallel robots: the delta, by forward kinematics, and the Stewart platform, by inverse kinematics."""

from __future__ import annotations

import numpy as np

from conrod.exact.jet import Jet, reciprocal, square_root
from conrod.scenes.space.machine import Drives, SpatialMachine, SpatialMotion, start_pose
from conrod.scenes.space.model import Closure, Joint, Link
from conrod.scenes.space.vectors import DEGREE, Vector, X, Y, Z, cross, dot, length, rod_angles, rotated, turned

PLATFORM = (Joint("platform_x", X, "slide"), Joint("platform_y", Y, "slide"), Joint("platform_z", Z, "slide"))
TILT = (Joint("platform_roll", X), Joint("platform_pitch", Y), Joint("platform_yaw", Z))


def sphere_meeting(centres: tuple[Jet, Jet, Jet], radius: float) -> Jet:
    """Point at one distance from three moving centres, on the side from which they go round clockwise.

    It is the centre of their circle, and then off along the normal.
    """
    p, q = centres[1] - centres[0], centres[2] - centres[0]
    normal = cross(p, q)
    inverse = reciprocal(dot(normal, normal))
    to_centre = 0.5 * inverse * cross(normal, dot(q, q) * p - dot(p, p) * q)
    height = square_root(radius**2 - dot(to_centre, to_centre))
    return centres[0] + to_centre - height * square_root(inverse) * normal


def delta(
    base: float = 0.164, platform: float = 0.044, arm: float = 0.524, rod: float = 1.244, half_width: float = 0.03
) -> SpatialMachine:
    """Three driven arms and three parallelograms of rods, whose platform never tilts.

    The platform's centre is at one distance, the rod's length, from the arms' ends, each shifted inwards by `platform`.
    The dimensions are those of Williams' example, an ABB FlexPicker; arms are level in the reference pose, and
    positive angles go down.

    Args:
        base, platform: distance [m] of the arms' and the rods' hinges from the centres of base and platform.
        arm, rod: lengths [m].
        half_width: of a parallelogram [m].
    """
    outward = [rotated(X, Z, angle * DEGREE) for angle in (-90.0, 30.0, 150.0)]
    axes = [np.cross(Z, radial) for radial in outward]

    def closed_form(drives: Drives) -> SpatialMotion:
        turns = [drives[f"input_{k}"] for k in (1, 2, 3)]
        elbows = [arm * turned(r, axis, turn) + base * r for r, axis, turn in zip(outward, axes, turns, strict=True)]
        first, second, third = (elbow - platform * r for elbow, r in zip(elbows, outward, strict=True))
        centre = sphere_meeting((first, second, third), rod)
        points, joints = {"platform": centre}, dict(drives)
        for k, (elbow, radial, axis, turn) in enumerate(zip(elbows, outward, axes, turns, strict=True), 1):
            bend, swing = rod_angles(centre - elbow + platform * radial, axis, -Z)
            points[f"elbow_{k}"] = elbow
            joints |= {f"elbow_{k}": bend - turn, f"swing_{k}_left": swing, f"swing_{k}_right": swing}
        joints |= {joint.name: dot(centre, joint.axis) for joint in PLATFORM}
        return SpatialMotion(points, joints | {joint.name: 0.0 * turns[0] for joint in TILT})

    drives = {"input_1": "sine:20deg,1Hz", "input_2": "sine:15deg,2Hz", "input_3": "sine:10deg,3Hz"}
    at = start_pose(closed_form, drives)
    sites, links, closures = {"platform": at["platform"]}, [], []
    for k, (radial, axis) in enumerate(zip(outward, axes, strict=True), 1):
        elbow, end = at[f"elbow_{k}"], at["platform"] + platform * radial
        rods = []
        for name, side in ((f"{k}_left", half_width * axis), (f"{k}_right", -half_width * axis)):
            swing = Joint(f"swing_{name}", np.cross(axis, end - elbow))
            rods.append(Link(f"rod_{name}", elbow + side, (swing,), (end + side,), {f"rod_{name}": end + side}))
            sites[f"platform_{name}"] = end + side
            closures.append(Closure(f"wrist_{name}", f"rod_{name}", f"platform_{name}"))
        ends = (elbow + half_width * axis, elbow - half_width * axis)
        crossbar = Link(f"crossbar_{k}", elbow, (Joint(f"elbow_{k}", axis),), ends, {}, tuple(rods))
        hinge = (Joint(f"input_{k}", axis),)
        links.append(Link(f"arm_{k}", base * radial, hinge, (elbow,), {f"elbow_{k}": elbow}, (crossbar,)))
    wrists = tuple(at["platform"] + platform * radial for radial in outward)
    links.append(Link("platform", at["platform"], PLATFORM + TILT, wrists, sites))
    source = "Williams (2016), The Delta Parallel Robot: Kinematics Solutions, forward position kinematics"
    return SpatialMachine(
        "delta", "Delta robot", source, links, closures, drives, closed_form, degrees_of_freedom=3, gruebler=0
    )


def stewart(
    base: float = 0.5, platform: float = 0.3, height: float = 0.6, base_half: float = 10.0 * DEGREE,
    platform_half: float = 50.0 * DEGREE,
) -> SpatialMachine:  # fmt: skip
    """Six legs, each of a universal joint, a slide and a ball, under a platform whose motion is prescribed.

    Length of a leg = |platform joint - base joint|, both in the world (inverse kinematics).

    Args:
        base, platform: radius [m] of the circles of joints; half angles [rad] of a pair about -90, 30 and 150 degrees.
        height: of the platform [m] in the reference pose.
    """
    pairs = [(angle * DEGREE, side) for angle in (-90.0, 30.0, 150.0) for side in (-1.0, 1.0)]
    feet = [base * rotated(X, Z, angle + side * base_half) for angle, side in pairs]
    # A leg leans outwards of its pair's middle, towards the neighbouring pair.
    arms = [platform * rotated(X, Z, angle + side * platform_half) for angle, side in pairs]
    centre = height * Z

    def closed_form(drives: Drives) -> SpatialMotion:
        position = drives["platform_x"] * X + drives["platform_y"] * Y + drives["platform_z"] * Z + centre

        def placed(arm: Vector) -> Jet:
            for joint in reversed(TILT):
                arm = turned(arm, joint.axis, drives[joint.name])
            return position + arm

        points, joints = {"platform": placed(np.zeros(3)), "tool": placed(0.1 * (X + Z))}, dict(drives)
        for k, (foot, arm) in enumerate(zip(feet, arms, strict=True), 1):
            points[f"leg_{k}_end"] = placed(arm)
            leg = points[f"leg_{k}_end"] - foot
            swing, tilt = rod_angles(leg, Y, Z)
            joints |= {f"swing_{k}": swing, f"tilt_{k}": tilt, f"leg_{k}": length(leg)}
        return SpatialMotion(points, joints)

    laws = ("sine:50mm,1Hz", "sine:40mm,2Hz", "sine:30mm,3Hz", "sine:8deg,2Hz", "sine:6deg,1Hz", "sine:10deg,1Hz")
    drives = dict(zip((joint.name for joint in PLATFORM + TILT), laws, strict=True))
    at = start_pose(closed_form, drives)
    ends = [at[f"leg_{k}_end"] for k in range(1, 7)]
    sites = {"platform": at["platform"], "tool": at["tool"]}
    links = []
    for k, (foot, end) in enumerate(zip(feet, ends, strict=True), 1):
        universal = (Joint(f"swing_{k}", Y), Joint(f"tilt_{k}", np.cross(Y, end - foot)))
        piston = Link(f"piston_{k}", 0.5 * (foot + end), (Joint(f"leg_{k}", end - foot, "slide"),), (end,),
                      {f"leg_{k}_end": end})  # fmt: skip
        links.append(Link(f"cylinder_{k}", foot, universal, (0.5 * (foot + end),), {}, (piston,)))
        sites[f"platform_joint_{k}"] = end
    links.append(Link("platform", centre, PLATFORM + TILT, tuple(ends), sites))
    closures = [Closure(f"ball_{k}", f"leg_{k}_end", f"platform_joint_{k}") for k in range(1, 7)]
    source = "Merlet: Parallel Robots, inverse kinematics of the 6-UPS platform"
    return SpatialMachine(
        "stewart", "Stewart platform", source, links, closures, drives, closed_form, degrees_of_freedom=6, gruebler=6
    )
