"""Short flights of a follower: see `conrod.studies.limits.exact_flight`."""

from __future__ import annotations

from conrod.scenes import CamFollower


def short_flight(scene: CamFollower) -> tuple[float, float]:
    """A, the largest downward y'' [m], and k = y''' / A [1/rad] just after the joint of flank and nose: see above."""
    motion = scene.motion(scene.joint_angles[1], 1.0).point("roller")
    least = -float(motion.acceleration[0, 1])
    return least, float(motion.jerk[0, 1]) / least
