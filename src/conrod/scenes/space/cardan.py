"""Cardan (Hooke's) joints between shafts that meet at an angle.

An arm of the driving fork starts across the plane of both shafts, at Z. The driven arm stays perpendicular to it, so
tan(out) = cos(bend) tan(in) (Uicker, Pennock and Shigley, Theory of Machines and Mechanisms, Hooke universal joint).
"""

from __future__ import annotations

import math

import numpy as np

from conrod.exact.jet import Jet, direction, sine_cosine
from conrod.scenes.space.machine import Drives, SpatialMachine, SpatialMotion, start_pose
from conrod.scenes.space.model import ORIGIN, Joint, Link, hinge_closure
from conrod.scenes.space.vectors import DEGREE, X, Z, hinge_angle, rotated, turned

SOURCE = (
    "Uicker, Pennock, Shigley: Theory of Machines and Mechanisms, Hooke universal joint: tan(out) = cos(bend) tan(in)"
)


def driven_angle(driving: Jet, bend: float) -> Jet:
    """Angle of the driven shaft, which stays within a quarter turn of the driving one's."""
    sine, cosine = sine_cosine(driving)
    k = math.cos(bend)
    return driving + direction(cosine * cosine + k * sine * sine, (k - 1.0) * sine * cosine)


def cardan_joint(bend: float = 30.0 * DEGREE, arm: float = 0.04, shaft: float = 0.2) -> SpatialMachine:
    """A single joint: the output runs at cos(bend) to 1 / cos(bend) of the input's speed, twice a turn."""
    out = rotated(X, Z, bend)
    across = np.cross(Z, out)

    def closed_form(drives: Drives) -> SpatialMotion:
        turn = drives["input"]
        output = driven_angle(turn, bend)
        driving_arm, driven_arm = turned(Z, X, turn), turned(across, out, output)
        return SpatialMotion(
            points={"input_arm": arm * driving_arm, "output_arm": arm * driven_arm},
            joints={"input": turn, "cross": hinge_angle(driving_arm, X, driven_arm), "output": output},
        )

    pins, forks, closures = hinge_closure("cross", ORIGIN, arm * across)
    cross = Link("cross", ORIGIN, (Joint("cross", Z),), tuple(pins.values()), pins)
    links = (
        Link("input_shaft", ORIGIN, (Joint("input", X),), (-shaft * X, arm * Z), {"input_arm": arm * Z}, (cross,)),
        Link("output_shaft", ORIGIN, (Joint("output", out),), (shaft * out, *forks.values()),
             {"output_arm": arm * across, **forks}),
    )  # fmt: skip
    return SpatialMachine(
        "cardan", "Cardan joint", SOURCE, links, closures, {"input": "60rpm"}, closed_form,
        degrees_of_freedom=1, gruebler=-2,
    )  # fmt: skip


def double_cardan(
    phasing: float = 0.0, bend: float = 30.0 * DEGREE, arm: float = 0.04, shaft: float = 0.3
) -> SpatialMachine:
    """Two joints and an intermediate shaft between parallel shafts.

    Args:
        phasing: angle [rad] between the forks of the intermediate shaft. At 0 the output turns as the input does; at a
            right angle its speed fluctuates between cos^2(bend) and 1 / cos^2(bend) of the input's.
    """
    middle, out = rotated(X, Z, bend), X
    across_middle, across_out = np.cross(Z, middle), np.cross(Z, out)
    centre = shaft * middle

    def closed_form(drives: Drives) -> SpatialMotion:
        turn = drives["input"]
        between = driven_angle(turn, bend)
        driving = between + (phasing - 0.5 * math.pi)
        output = driven_angle(driving, bend)
        first, second = turned(Z, X, turn), turned(across_middle, middle, between)
        third, fourth = turned(Z, middle, driving), turned(across_out, out, output)
        return SpatialMotion(
            points={"input_arm": arm * first, "middle_arm": arm * third + centre, "output_arm": arm * fourth + centre},
            joints={"input": turn, "cross_1": hinge_angle(first, X, second),
                    "middle": -hinge_angle(second, middle, first),
                    "cross_2": hinge_angle(third, middle, fourth), "output": output},
        )  # fmt: skip

    at = start_pose(closed_form, ["input"])
    third, fourth = at["middle_arm"] - centre, at["output_arm"] - centre
    pins, forks, closures = hinge_closure("cross", centre, fourth)
    cross_2 = Link("cross_2", centre, (Joint("cross_2", third / arm),), tuple(pins.values()), pins)
    middle_shaft = Link("middle_shaft", ORIGIN, (Joint("middle", across_middle),), (centre,),
                        {"middle_arm": at["middle_arm"]}, (cross_2,))  # fmt: skip
    cross_1 = Link("cross_1", ORIGIN, (Joint("cross_1", Z),), (arm * across_middle,), {}, (middle_shaft,))
    links = (
        Link("input_shaft", ORIGIN, (Joint("input", X),), (-shaft * X,), {"input_arm": arm * Z}, (cross_1,)),
        Link("output_shaft", centre, (Joint("output", out),), (centre + shaft * out,),
             {"output_arm": at["output_arm"], **forks}),
    )  # fmt: skip
    heading = ("double-cardan", "Double Cardan joint")
    if phasing:
        heading = ("double-cardan-misphased", f"Double Cardan joint, forks {phasing / DEGREE:g} deg out of phase")
    return SpatialMachine(
        *heading, SOURCE, links, closures, {"input": "60rpm"}, closed_form, degrees_of_freedom=1, gruebler=0,
    )  # fmt: skip
