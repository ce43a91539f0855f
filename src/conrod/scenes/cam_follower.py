"""The cam-follower of document 004: a symmetric disc cam with a translating radial roller follower."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from conrod.errors import InvalidInput
from conrod.exact.motion import BREAK_WIDTH, Array, Derivatives, PointDerivatives, Side
from conrod.mechanism import units as parameters
from conrod.mechanism.cam import symmetric_cam
from conrod.mechanism.mechanism import (
    GROUND,
    Body,
    CamContact,
    ConstantForce,
    Driver,
    Mechanism,
    ObservedPoint,
    Prismatic,
    Revolute,
)
from conrod.mechanism.units import REVOLUTION
from conrod.scenes.scene import Scene, circular, combine, constant, projection

FLANK_RADIUS_ROUNDING = 1e-9  # [m], above the least flank radius, which document 004 uses: taken for the least
MAX_FLANK_RATIO = 100.0  # flank radius over the cam's size; a larger one is a straight line, and costs digits


@dataclass(frozen=True)
class CamFollower(Scene):
    """Symmetric disc cam of tangent circular arcs with a translating radial roller follower.

    Frame: shaft at the origin, x right, y up; the roller moves on x = 0 above the shaft, at
    (0, base + roller + lift).

    Signs: the crank angle is the document's theta, 0 in the middle of the dwell and pi with the nose up; the cam turns
    counter-clockwise. Lift is positive away from the shaft.

    Units: SI.

    Source: document 004, Figure 5 and equations (8) to (11). Masses and preload are conrod's.

    The preload is the constant force that holds the follower down, as a multiple of
    (follower mass x largest downward acceleration): above 1 the exact motion never parts. It acts in place of
    gravity, and is the same for both engines and all presets.
    """

    kind = "cam-follower"
    title = "Cam with roller follower (by contact)"
    source = "document 004 (flank radius and base radius of a symmetric cam), Figure 5"
    drawn_at = 120.0
    output = "roller"
    description = (
        "A symmetric disc cam with a translating radial roller follower: base circle {base_radius}, two "
        "flanks of {flank_radius} and a nose of {nose_radius} at {centre_distance} from the shaft, all "
        "tangent to each other; roller {roller_radius}; {speed}. In both engines the cam drives the follower "
        "**by contact**: cam and roller really collide. The exact motion is the geometry, with the roller's "
        "centre at a known distance from the centre of the active arc, and not the document's truncated "
        "series."
    )
    frame = (
        "shaft at the origin, x right, y up; the roller's centre moves on x = 0 at (0, base + roller + lift)."
        " The crank angle t is the document's theta: 0 in the middle of the dwell, 180 deg with the nose up; "
        "the cam turns counter-clockwise."
    )

    base_radius: float = parameters.length(0.036, "base circle")
    flank_radius: float = parameters.length(0.118, "flanks")
    nose_radius: float = parameters.length(0.029, "nose")
    centre_distance: float = parameters.length(0.080, "shaft to centre of the nose")
    roller_radius: float = parameters.length(0.009, "roller")
    speed: float = parameters.speed(1.0)
    cam_mass: float = parameters.mass(3.0, "cam")
    cam_inertia: float = parameters.inertia(0.003, "cam, about the shaft")
    follower_mass: float = parameters.mass(0.5, "follower with roller")
    preload: float = parameters.factor(25.0, "preload as a multiple of mass x least acceleration")

    # -- geometry ----------------------------------------------------------------------------------------------

    @property
    def least_flank_radius(self) -> float:
        """(R + R1 + C) / 2 [m], where the centres of base, flank and nose are in line."""
        return 0.5 * (self.base_radius + self.nose_radius + self.centre_distance)

    @property
    def is_one_circle(self) -> bool:
        """True at the least flank radius, where the cam is one circle about (C + R1 - R) / 2 without dwell."""
        return abs(self.flank_radius - self.least_flank_radius) <= FLANK_RADIUS_ROUNDING

    @property
    def flank(self) -> float:
        """Flank radius used [m]: the given one, or the least one within rounding of it."""
        return self.least_flank_radius if self.is_one_circle else self.flank_radius

    @property
    def full_lift(self) -> float:
        """Lift at the nose [m], C + R1 - R."""
        return self.centre_distance + self.nose_radius - self.base_radius

    def _check_geometry(self) -> None:
        r, r1, c = self.base_radius, self.nose_radius, self.centre_distance
        if not abs(r1 - r) < c:
            raise InvalidInput(
                f"centre_distance = {c:g} m gives no cam: it must exceed |base_radius - nose_radius| = "
                f"{abs(r1 - r):g} m"
            )
        least, longest = self.least_flank_radius, MAX_FLANK_RATIO * (r + r1 + c)
        if not least - FLANK_RADIUS_ROUNDING <= self.flank_radius <= longest:
            raise InvalidInput(
                f"flank_radius = {self.flank_radius:g} m is out of range: (base_radius + nose_radius + centre_distance)"
                f" / 2 = {least:g} m <= flank_radius <= {longest:g} m"
            )

    @cached_property
    def joint_angles(self) -> tuple[float, float]:
        """Crank angles [rad] of joint B (base to flank) and joint C (flank to nose), document 004, Figure 5.

        Both follow from the triangle of the centres O, O1, O2. At B the flank's centre is straight below the shaft, so
        the angle is the triangle's at O; at C the roller's centre lies on the line from O2 through O1.
        """
        if self.is_one_circle:
            return 0.0, math.pi
        c, to_base, to_nose = self.centre_distance, self.flank - self.base_radius, self.flank - self.nose_radius
        # tan^2 of half the angle = (s - b)(s - c) / (s (s - a)), with s the half perimeter: it keeps its digits near
        # the least flank radius, where the triangle is flat.
        half = 0.5 * (c + to_base + to_nose)
        at_shaft = 2.0 * math.atan2(
            math.sqrt((self.flank - self.least_flank_radius) * (half - to_base)), math.sqrt(half * (half - to_nose))
        )
        normal = math.atan2(to_base * math.sin(at_shaft), c - to_base * math.cos(at_shaft))
        reach = self.nose_radius + self.roller_radius
        return at_shaft, math.pi - math.atan2(reach * math.sin(normal), c + reach * math.cos(normal))

    def break_angles(self) -> tuple[float, ...]:
        """Crank angles [rad] of the four joints of arcs; empty if the cam is one circle."""
        if self.is_one_circle:
            return ()
        base_joint, nose_joint = self.joint_angles
        return (base_joint, nose_joint, REVOLUTION - nose_joint, REVOLUTION - base_joint)

    # -- motion ------------------------------------------------------------------------------------------------

    def _angle_derivatives(self, angle: Array, side: Side) -> Mapping[str, PointDerivatives]:
        return {"roller": (constant(0.0), self._height(angle, side))}

    def _height(self, angle: Array, side: Side) -> Derivatives:
        """Height of the roller's centre with three derivatives, at crank angles (T,).

        The roller's centre keeps the distance R_arc + r from the active arc's centre, which lies at d from the shaft,
        straight
        below it at crank angle b: h = -d cos(t - b) + sqrt((R_arc + r)^2 - d^2 sin^2(t - b)). Document 004's equations
        (8) to (11) are this, with the root cut after its first term.
        """
        piece = self._active_arc(angle, side)
        base_joint, _ = self.joint_angles
        to_base, c, r = self.flank - self.base_radius, self.centre_distance, self.roller_radius
        distance = np.array([0.0, to_base, c, to_base, 0.0])[piece]
        lowest = np.array([0.0, base_joint, 0.0, -base_joint, 0.0])[piece]
        arc = np.array([self.base_radius, self.flank, self.nose_radius, self.flank, self.base_radius])[piece]
        down, across = circular(distance, np.sin(angle - lowest), np.cos(angle - lowest))
        return combine((-1.0, down), (1.0, projection(arc + r, across)))

    def _active_arc(self, angle: Array, side: Side) -> np.ndarray[tuple[int, ...], np.dtype[np.intp]]:
        """Index of the arc in contact: 0 base, 1 rising flank, 2 nose, 3 falling flank, 4 base."""
        if self.is_one_circle:
            return np.ones(np.shape(angle), dtype=np.intp)
        wrapped = np.remainder(angle, REVOLUTION)
        nudge = BREAK_WIDTH if side == "right" else -BREAK_WIDTH
        return np.searchsorted(np.array(self.break_angles()), wrapped + nudge)

    @cached_property
    def least_acceleration(self) -> float:
        """The follower's largest downward acceleration at constant speed [m/s^2], negative.

        It stands just after the joint of flank and nose, not at the tip; on one circle, within the arc.
        """
        _, nose_joint = self.joint_angles
        angles = np.linspace(0.0 if self.is_one_circle else nose_joint, math.pi, 1801)
        return float(np.min(self._height(angles, "right")[2])) * self.speed**2

    @property
    def preload_force(self) -> float:
        """Constant force [N] that holds the follower down."""
        return self.preload * self.follower_mass * -self.least_acceleration

    def mechanism(self) -> Mechanism:
        """Build ground, cam and follower; the roller rests on the cam by contact."""
        r = self.roller_radius
        profile = symmetric_cam(self.base_radius, self.flank, self.nose_radius, self.centre_distance)
        return Mechanism(
            name=self.kind,
            bodies=(
                Body("cam", self.cam_mass, self.cam_inertia),
                Body("follower", self.follower_mass, 1e-4 * self.follower_mass),  # any inertia: it cannot turn
            ),
            joints=(
                Revolute("shaft", GROUND, "cam", (0.0, 0.0), (0.0, 0.0)),
                Prismatic("guide", GROUND, "follower", (0.0, 0.0), (0.0, 0.0), direction=math.pi / 2),
                CamContact("contact", "cam", "follower", profile, (0.0, 0.0), r),
            ),
            driver=Driver("shaft", start=-math.pi / 2),
            poses={"cam": (0.0, 0.0, -math.pi / 2), "follower": (0.0, self.base_radius + r, 0.0)},
            observed=(ObservedPoint("roller", "follower"),),
            forces=(ConstantForce("follower", (0.0, -self.preload_force)),),
        )
