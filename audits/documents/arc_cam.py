"""One cam of document 004 two ways: its exact motion, and its published series; lengths in mm, angles in deg."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from audits.formulas.cam import FLANK, NOSE
from conrod.exact.motion import Array, Side
from conrod.scenes import CamFollower

MM = 1e-3
QUANTITIES = ("lift", "velocity", "acceleration", "jerk")
# Between samples of an arc an extreme is missed by some (1e-4)^2 of its size: far below six printed digits.
SAMPLES = 20001


@dataclass(frozen=True)
class ArcCam:
    """Document 004's cam with base circle R and flanks rho [mm]; the rest as in the document, 1 rad/s."""

    base: float
    flank: float

    @cached_property
    def scene(self) -> CamFollower:
        """The cam as a scene."""
        return CamFollower(base_radius=self.base * MM, flank_radius=self.flank * MM, speed=1.0)

    @property
    def joint_b(self) -> float:
        """Angle of the joint of base circle and flank [deg], the document's beta."""
        return float(np.degrees(self.scene.joint_angles[0]))

    @property
    def joint_c(self) -> float:
        """Angle of the joint of flank and nose [deg]."""
        return float(np.degrees(self.scene.joint_angles[1]))

    def exact(self, degrees: Array | float, side: Side = "right") -> Array:
        """Lift, velocity, acceleration and jerk (4, T) from the geometry; mm and s."""
        motion = self.scene.motion(np.radians(np.atleast_1d(degrees)), 1.0, side=side).point("roller")
        rows = (motion.position, motion.velocity, motion.acceleration, motion.jerk)
        values = np.array([row[:, 1] for row in rows]) / MM
        values[0] -= self.base + self.scene.roller_radius / MM
        return values

    def series(self, degrees: Array | float, arc: str) -> Array:
        """The same (4, T) from equations (8) to (22), for "flank" or "nose", whichever arc really is in contact."""
        scene = self.scene
        letters = {
            "R": self.base,
            "rho": self.flank,
            "b": scene.joint_angles[0],
            "R1": scene.nose_radius / MM,
            "C": scene.centre_distance / MM,
            "r": scene.roller_radius / MM,
            "w": 1.0,
        }
        t = np.radians(np.atleast_1d(degrees))
        return np.array([formula(t=t, **letters) for formula in (FLANK if arc == "flank" else NOSE)])

    @property
    def flank_angles(self) -> Array:
        """Angles of the rising flank [deg]."""
        return np.linspace(self.joint_b, self.joint_c, SAMPLES)

    @property
    def nose_angles(self) -> Array:
        """Angles of the nose up to its tip [deg]."""
        return np.linspace(self.joint_c, 180.0, SAMPLES)

    def rise(self) -> tuple[Array, Array]:
        """Angles of flank and nose [deg] and the exact motion there (4, 2 T), each arc with its own side of C."""
        flank, nose = self.flank_angles, self.nose_angles
        # A sample on a joint belongs to its own arc: B is seen from the right, C from the left.
        on_flank = self.exact(flank, "left")
        on_flank[:, 0] = self.exact(flank[0], "right")[:, 0]
        return np.concatenate([flank, nose]), np.hstack([on_flank, self.exact(nose, "right")])
