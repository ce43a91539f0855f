"""The exact motion that engines are held against, and the step that they are run with."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from conrod.dynamics.forward import ForwardDynamics, FreeMotion
from conrod.dynamics.inverse import InverseDynamics
from conrod.errors import InvalidInput
from conrod.joint_equations import pose_jets
from conrod.kinematics import Kinematics
from conrod.mechanism import Mechanism
from conrod.motion import Array
from conrod.scenes import Scene
from conrod.studies.free_motion.plan import Grid, MotionPlan, chosen, instants

# Of the largest push of a contact, what rounding may make of one that is none.
NO_PULL = 1e-9


@dataclass(frozen=True)
class ExactCourse:
    """A scene's exact motion from its start, and what is to be run against it.

    Attributes:
        mechanism: with the loads that act.
        grid: instants of `motion`, and the engines' step.
        lengths: L of each observed point [m].
    """

    mechanism: Mechanism
    grid: Grid
    motion: FreeMotion
    lengths: Mapping[str, float]


def exact_course(name: str, scene: Scene, plan: MotionPlan) -> ExactCourse:
    """The exact motion of a scene.

    Raises:
        InvalidInput: the start contradicts the joints or is a rest that nothing ends, a force is not finite, what moves
            has no inertia, the follower would fly, or there would be too many steps.
    """
    mechanism = plan.mechanism(scene.kinematics.mechanism, name)
    grid = instants(plan)
    times = np.asarray(grid.step * grid.every * np.arange(grid.count + 1), dtype=float)
    motion = ForwardDynamics(mechanism).motion(times, rates=scene.start_rates)
    _check_contact(name, mechanism, motion)
    return ExactCourse(mechanism, chosen(plan, grid, mechanism, motion), motion, scene.lengths)


def _check_contact(name: str, mechanism: Mechanism, motion: FreeMotion) -> None:
    """Refuse a motion in which a cam would have to pull: the exact motion does not know flight."""
    if not mechanism.cam_contacts:
        return
    forces = InverseDynamics(Kinematics(mechanism)).forces_in(
        motion.poses, motion.rates, motion.accelerations, motion.times
    )
    for joint in mechanism.cam_contacts:
        push = forces.components[joint.name]["contact"]
        pulls = push < -NO_PULL * np.abs(push).max()
        if pulls.any():
            raise InvalidInput(
                f"{name}: the follower leaves the cam at t = {motion.times[int(np.argmax(pulls))]:.4g} s, and the "
                "exact motion keeps it there: start it slower, or press it on by a spring or a force"
            )


def crank_angle(mechanism: Mechanism, poses: Array) -> Array:
    """The crank angle (T,) [rad] in poses (T, 3 n), from 0 at the first."""
    turn = poses[:, 3 * mechanism.body_index[mechanism.crank] + 2]
    return np.asarray(mechanism.driver.sense * (turn - turn[0]))


def places(mechanism: Mechanism, poses: Array) -> dict[str, Array]:
    """Positions (T, 2) [m] of the observed points in poses (T, 3 n)."""
    bodies = pose_jets(mechanism, [poses])
    return {
        point.name: np.column_stack([np.asarray(jet.coefficients[0]) for jet in bodies[point.body].point(point.point)])
        for point in mechanism.observed
    }
