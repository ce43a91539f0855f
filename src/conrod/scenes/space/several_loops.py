"""Machines in space with several loops: double Cardan joint, Sarrus linkage, delta robot and Stewart platform."""

from __future__ import annotations

import math

import numpy as np

from conrod.exact.jet import Jet, reciprocal, sine_cosine, square_root
from conrod.scenes.space.machine import (
    DEGREE,
    ORIGIN,
    Drives,
    LinkJoint,
    LoopClosure,
    ModelLink,
    SpatialMachine,
    Vector,
    X,
    Y,
    Z,
    cross,
    dot,
    hinge_closure,
    reference_pose,
    rotate,
    rotate_fixed,
)
from conrod.scenes.space.single_loop import HINGE_HALF_LENGTH, cardan_output_angle

PLATFORM_SLIDES = (
    LinkJoint("platform_x", X, "slide"),
    LinkJoint("platform_y", Y, "slide"),
    LinkJoint("platform_z", Z, "slide"),
)
PLATFORM_HINGES = (LinkJoint("platform_roll", X), LinkJoint("platform_pitch", Y), LinkJoint("platform_yaw", Z))


def double_cardan(
    phasing: float = 0.0, bend: float = 30.0 * DEGREE, arm: float = 0.04, shaft: float = 0.3
) -> SpatialMachine:
    """Double Cardan joint: two joints and an intermediate shaft between parallel shafts.

    Args:
        phasing: angle [rad] between the forks of the intermediate shaft. At 0 the output turns as the input does; at a
            right angle its speed fluctuates between cos^2(bend) and 1 / cos^2(bend) of the input's.
        bend: angle [rad] between the intermediate shaft and both others.
        arm, shaft: length [m] of a cross's arm, and of each shaft.
    """
    middle, out = rotate_fixed(X, Z, bend), X
    across_middle, across_out = np.cross(Z, middle), np.cross(Z, out)
    centre = shaft * middle

    def closed_form(drives: Drives) -> dict[str, Jet]:
        turn = drives["input"]
        driving = cardan_output_angle(turn, bend) + (phasing - 0.5 * math.pi)
        return {
            "input_arm": arm * rotate(Z, X, turn),
            "middle_arm": arm * rotate(Z, middle, driving) + centre,
            "output_arm": arm * rotate(across_out, out, cardan_output_angle(driving, bend)) + centre,
        }

    at = reference_pose(closed_form, ["input"])
    third, fourth = at["middle_arm"] - centre, at["output_arm"] - centre
    pins, forks, closures = hinge_closure("cross", centre, fourth)
    cross_2 = ModelLink("cross_2", centre, (LinkJoint("cross_2", third / arm),), tuple(pins.values()), pins)
    middle_shaft = ModelLink("middle_shaft", ORIGIN, (LinkJoint("middle", across_middle),), (centre,),
                        {"middle_arm": at["middle_arm"]}, (cross_2,))  # fmt: skip
    cross_1 = ModelLink("cross_1", ORIGIN, (LinkJoint("cross_1", Z),), (arm * across_middle,), {}, (middle_shaft,))
    links = (
        ModelLink("input_shaft", ORIGIN, (LinkJoint("input", X),), (-shaft * X,), {"input_arm": arm * Z}, (cross_1,)),
        ModelLink("output_shaft", centre, (LinkJoint("output", out),), (centre + shaft * out,),
             {"output_arm": at["output_arm"], **forks}),
    )  # fmt: skip
    heading = ("double-cardan", "Double Cardan joint")
    if phasing:
        heading = ("double-cardan-misphased", f"Double Cardan joint, forks {phasing / DEGREE:g} deg out of phase")
    return SpatialMachine(*heading, links, closures, {"input": "60rpm"}, closed_form)


def sarrus(
    lower: float = 0.15, upper: float = 0.2, other_lower: float = 0.18, other_upper: float = 0.16,
    offset: float = 0.1, start: float = 50.0 * DEGREE,
) -> SpatialMachine:  # fmt: skip
    """Sarrus linkage: two chains of three parallel hinges, in planes at a right angle, move a plate straight along Z.

    Each chain bends in its plane like a slider-crank: height = lower sin(a) + sqrt(upper^2 - lower^2 cos^2(a))
    (Sarrus, Comptes rendus 36, 1853; Hunt, Kinematic Geometry of Mechanisms).

    Args:
        lower, upper, other_lower, other_upper: lengths [m] of the links of both chains.
        offset: distance [m] of a chain's outer hinges from Z.
        start: angle [rad] of the driven link above the ground in the reference pose.
    """

    def closed_form(drives: Drives) -> dict[str, Jet]:
        sine, cosine = sine_cosine(drives["input"] + start)
        height = lower * sine + square_root(upper**2 - lower**2 * cosine * cosine)
        # Angle of the other chain's lower link, from the triangle of its links and the height.
        other_sine = (height * height + (other_lower**2 - other_upper**2)) * reciprocal(2.0 * other_lower * height)
        other_cosine = square_root(1.0 - other_sine * other_sine)
        return {
            "knee": lower * (cosine * X + sine * Z) + offset * X,
            "other_knee": other_lower * (other_cosine * Y + other_sine * Z) + offset * Y,
            "plate": height * Z,
        }

    at = reference_pose(closed_form, ["input"])
    plate, knee, other_knee = at["plate"], at["knee"], at["other_knee"]
    pins, eyes, closures = hinge_closure("other_plate", plate + offset * Y, HINGE_HALF_LENGTH * X)
    corner, other_corner = plate + offset * X, plate + offset * Y
    plate_link = ModelLink("plate", corner, (LinkJoint("plate", -Y),), (plate, other_corner), {"plate": plate, **pins})
    upper_link = ModelLink("upper", knee, (LinkJoint("knee", -Y),), (corner,), {}, (plate_link,))
    other_upper_link = ModelLink("other_upper", other_knee, (LinkJoint("other_knee", X),), (other_corner,), eyes)
    links = (
        ModelLink("lower", offset * X, (LinkJoint("input", -Y),), (knee,), {"knee": knee}, (upper_link,)),
        ModelLink("other_lower", offset * Y, (LinkJoint("other_lower", X),), (other_knee,), {"other_knee": other_knee},
             (other_upper_link,)),
    )  # fmt: skip
    return SpatialMachine("sarrus", "Sarrus linkage", links, closures, {"input": "sine:20deg,1Hz"}, closed_form)


def sphere_intersection(centres: tuple[Jet, Jet, Jet], radius: float) -> Jet:
    """Point at one distance from three moving centres, on the side that sees them in clockwise order.

    It lies on the normal through the centre of the circle through the three.

    Args:
        centres: (T, 3) [m] each.
        radius: distance [m].
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
    """Delta robot: three driven arms and three parallelograms of rods, whose platform never tilts.

    The platform's centre is at the rods' length from the arms' ends, each shifted inwards by `platform`
    (Williams, The Delta Parallel Robot: Kinematics Solutions, 2016, forward position kinematics). The dimensions are
    those of his example, an ABB FlexPicker; arms are level in the reference pose, and positive angles go down.

    Args:
        base, platform: distance [m] of the arms' and the rods' hinges from the centres of base and platform.
        arm, rod: lengths [m].
        half_width: half the width of a parallelogram [m].
    """
    outward = [rotate_fixed(X, Z, angle * DEGREE) for angle in (-90.0, 30.0, 150.0)]
    axes = [np.cross(Z, radial) for radial in outward]

    def closed_form(drives: Drives) -> dict[str, Jet]:
        turns = [drives[f"input_{k}"] for k in (1, 2, 3)]
        elbows = [arm * rotate(r, axis, turn) + base * r for r, axis, turn in zip(outward, axes, turns, strict=True)]
        first, second, third = (elbow - platform * r for elbow, r in zip(elbows, outward, strict=True))
        return {
            "platform": sphere_intersection((first, second, third), rod),
            **{f"elbow_{k}": elbow for k, elbow in enumerate(elbows, 1)},
        }

    drives = {"input_1": "sine:20deg,1Hz", "input_2": "sine:15deg,2Hz", "input_3": "sine:10deg,3Hz"}
    at = reference_pose(closed_form, drives)
    sites, links, closures = {"platform": at["platform"]}, [], []
    for k, (radial, axis) in enumerate(zip(outward, axes, strict=True), 1):
        elbow, end = at[f"elbow_{k}"], at["platform"] + platform * radial
        rods = []
        for name, side in ((f"{k}_left", half_width * axis), (f"{k}_right", -half_width * axis)):
            swing = LinkJoint(f"swing_{name}", np.cross(axis, end - elbow))
            rods.append(ModelLink(f"rod_{name}", elbow + side, (swing,), (end + side,), {f"rod_{name}": end + side}))
            sites[f"platform_{name}"] = end + side
            closures.append(LoopClosure(f"wrist_{name}", f"rod_{name}", f"platform_{name}"))
        ends = (elbow + half_width * axis, elbow - half_width * axis)
        crossbar = ModelLink(f"crossbar_{k}", elbow, (LinkJoint(f"elbow_{k}", axis),), ends, {}, tuple(rods))
        hinge = (LinkJoint(f"input_{k}", axis),)
        links.append(ModelLink(f"arm_{k}", base * radial, hinge, (elbow,), {f"elbow_{k}": elbow}, (crossbar,)))
    wrists = tuple(at["platform"] + platform * radial for radial in outward)
    links.append(ModelLink("platform", at["platform"], PLATFORM_SLIDES + PLATFORM_HINGES, wrists, sites))
    return SpatialMachine("delta", "Delta robot", links, closures, drives, closed_form)


def stewart(
    base: float = 0.5, platform: float = 0.3, height: float = 0.6, base_half: float = 10.0 * DEGREE,
    platform_half: float = 50.0 * DEGREE,
) -> SpatialMachine:  # fmt: skip
    """Stewart platform on six legs, each of a universal joint, a slide and a ball; its platform is driven.

    The legs' motion follows from inverse kinematics (Merlet, Parallel Robots, 6-UPS platform).

    Args:
        base, platform: radius [m] of the circles of joints; half angles [rad] of a pair about -90, 30 and 150 degrees.
        height: height of the platform [m] in the reference pose.
    """
    pairs = [(angle * DEGREE, side) for angle in (-90.0, 30.0, 150.0) for side in (-1.0, 1.0)]
    feet = [base * rotate_fixed(X, Z, angle + side * base_half) for angle, side in pairs]
    # Legs of a pair diverge: each leans towards the neighbouring pair.
    arms = [platform * rotate_fixed(X, Z, angle + side * platform_half) for angle, side in pairs]
    centre = height * Z

    def closed_form(drives: Drives) -> dict[str, Jet]:
        position = drives["platform_x"] * X + drives["platform_y"] * Y + drives["platform_z"] * Z + centre

        def place_on_platform(arm: Vector) -> Jet:
            for joint in reversed(PLATFORM_HINGES):
                arm = rotate(arm, joint.axis, drives[joint.name])
            return position + arm

        ends = {f"leg_{k}_end": place_on_platform(arm) for k, arm in enumerate(arms, 1)}
        return {"platform": place_on_platform(np.zeros(3)), "tool": place_on_platform(0.1 * (X + Z)), **ends}

    laws = ("sine:50mm,1Hz", "sine:40mm,2Hz", "sine:30mm,3Hz", "sine:8deg,2Hz", "sine:6deg,1Hz", "sine:10deg,1Hz")
    drives = dict(zip((joint.name for joint in PLATFORM_SLIDES + PLATFORM_HINGES), laws, strict=True))
    at = reference_pose(closed_form, drives)
    ends = [at[f"leg_{k}_end"] for k in range(1, 7)]
    sites = {"platform": at["platform"], "tool": at["tool"]}
    links = []
    for k, (foot, end) in enumerate(zip(feet, ends, strict=True), 1):
        universal = (LinkJoint(f"swing_{k}", Y), LinkJoint(f"tilt_{k}", np.cross(Y, end - foot)))
        piston = ModelLink(f"piston_{k}", 0.5 * (foot + end), (LinkJoint(f"leg_{k}", end - foot, "slide"),), (end,),
                      {f"leg_{k}_end": end})  # fmt: skip
        links.append(ModelLink(f"cylinder_{k}", foot, universal, (0.5 * (foot + end),), {}, (piston,)))
        sites[f"platform_joint_{k}"] = end
    links.append(ModelLink("platform", centre, PLATFORM_SLIDES + PLATFORM_HINGES, tuple(ends), sites))
    closures = [LoopClosure(f"ball_{k}", f"leg_{k}_end", f"platform_joint_{k}") for k in range(1, 7)]
    return SpatialMachine("stewart", "Stewart platform", links, closures, drives, closed_form)
