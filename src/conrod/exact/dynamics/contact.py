"""Contact of a follower in a motion without a prescribed drive: the exact motion keeps it on the cam."""

from __future__ import annotations

import numpy as np

from conrod.errors import InvalidInput
from conrod.exact.dynamics.forward import FreeMotion
from conrod.exact.dynamics.inverse import joint_forces_of_motion
from conrod.exact.kinematics import Kinematics
from conrod.mechanism.mechanism import Mechanism

# A contact pulls if its force is below minus this share of its largest push; less may be rounding.
MAX_ROUNDING_PULL = 1e-9


def check_contact(name: str, mechanism: Mechanism, motion: FreeMotion) -> None:
    """Refuse a motion that would lift a follower off its cam.

    Raises:
        InvalidInput: the cam would have to pull, since the exact motion keeps the follower on it; names the time.
    """
    if not mechanism.cam_contacts:
        return
    forces = joint_forces_of_motion(
        Kinematics(mechanism), motion.poses, motion.rates, motion.accelerations, motion.times
    )
    for joint in mechanism.cam_contacts:
        push = forces.components[joint.name]["contact"]
        pulls = push < -MAX_ROUNDING_PULL * np.abs(push).max()
        if pulls.any():
            raise InvalidInput(
                f"{name}: the follower leaves the cam at t = {motion.times[int(np.argmax(pulls))]:.4g} s, and the "
                "exact motion keeps it there: start it slower, or press it on by a spring or a force"
            )
