"""Document 004's series against the exact geometry, for every cam that it studies.

Its equations (8) to (23) cut a root after its first term. What that does to lift, velocity, acceleration and jerk on
each arc, the jumps that it leaves where the arcs meet, and the pressure angle against the document's own rule.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np

from audits.documents.arc_cam import ArcCam
from conrod.exact.motion import Array

BASE_RADII = (36.0, 46.0, 56.0, 66.0, 76.0)  # [mm]
FLANK_RADII = (88.0, 98.0, 108.0, 118.0)  # [mm], besides the least one of each base
LONGEST_FLANK = (76.0, 128.0)  # [mm], which the document has for its largest base alone
LARGEST_PRESSURE_ANGLE = 30.0  # [deg], document 004, line 62


@dataclass(frozen=True)
class CamSurvey:
    """One cam; quantities are lift, velocity, acceleration, jerk in mm and s at 1 rad/s, each array (4,).

    Attributes:
        base, flank: R and rho [mm].
        is_least: the flank is the least possible: the cam is one circle, the nose is no arc of its own.
        joint_b, joint_c: angles of the joints [deg].
        exact_peak: largest exact value on the rise, in size.
        flank_error, nose_error: largest deviation of the series from the geometry within the arc.
        jump_b, jump_c: what the series leaves between its arcs at the joints.
        exact_jump_b, exact_jump_c: what is really there: none in lift and velocity.
        pressure_angle: the largest [deg], from the geometry, and the cam's angle there.
        pressure_angle_as_printed: the largest [deg] by the document's (6) and (7), which leave out the roller's radius.
    """

    base: float
    flank: float
    is_least: bool
    joint_b: float
    joint_c: float
    exact_peak: Array
    flank_error: Array
    nose_error: Array
    jump_b: Array
    jump_c: Array
    exact_jump_b: Array
    exact_jump_c: Array
    pressure_angle: float
    pressure_angle_at: float
    pressure_angle_as_printed: float

    @property
    def keeps_the_rule(self) -> bool:
        """Whether the pressure angle stays within the document's 30 degrees."""
        return self.pressure_angle <= LARGEST_PRESSURE_ANGLE


def cams() -> tuple[ArcCam, ...]:
    """The cams that document 004 studies."""
    found = []
    for base in BASE_RADII:
        least = ArcCam(base, base + 80.0).scene.least_flank_radius / 1e-3
        found += [ArcCam(base, flank) for flank in (round(least, 9), *(f for f in FLANK_RADII if f > least))]
    return (*found, ArcCam(*LONGEST_FLANK))


@cache
def surveys() -> tuple[CamSurvey, ...]:
    """All the cams that document 004 studies, measured."""
    return tuple(survey(cam) for cam in cams())


def survey(cam: ArcCam) -> CamSurvey:
    """Measure one cam."""
    flank, nose = cam.flank_angles, cam.nose_angles
    angles, exact = cam.rise()
    on_flank, on_nose = exact[:, : len(flank)], exact[:, len(flank) :]
    b, c = cam.joint_b, cam.joint_c
    least = cam.scene.is_one_circle
    nose_error = np.zeros(4) if least else np.abs(cam.series(nose, "nose") - on_nose).max(axis=1)
    jump_c = np.zeros(4) if least else cam.series(c, "nose")[:, 0] - cam.series(c, "flank")[:, 0]
    tangent, printed = (pressure_angles(cam, exact, roller) for roller in (cam.scene.roller_radius / 1e-3, 0.0))
    worst = int(np.argmax(tangent))
    return CamSurvey(
        cam.base,
        cam.flank,
        least,
        b,
        c,
        np.abs(exact).max(axis=1),
        np.abs(cam.series(flank, "flank") - on_flank).max(axis=1),
        nose_error,
        cam.series(b, "flank")[:, 0],
        jump_c,
        cam.exact(b, "right")[:, 0] - cam.exact(b, "left")[:, 0],
        cam.exact(c, "right")[:, 0] - cam.exact(c, "left")[:, 0],
        float(tangent[worst]),
        float(angles[worst]),
        float(printed.max()),
    )


def pressure_angles(cam: ArcCam, motion: Array, roller: float) -> Array:
    """Angles (T,) [deg] of the contact's normal against the follower's axis: tan = dh/dtheta over the height.

    Args:
        motion: lift and velocity in the first rows, at 1 rad/s.
        roller: radius [mm] that is counted to the height.
    """
    lift, slope = motion[:2]
    return np.asarray(np.degrees(np.arctan2(slope, cam.base + roller + lift)))
