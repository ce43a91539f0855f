"""Rapier on machines in space: bodies in maximal coordinates, impulse joints, and kinematic bodies along the laws."""

from __future__ import annotations

from typing import Any

import numpy as np
import rapier3d

from conrod.comparison.outcome import MAX_JOINT_GAP
from conrod.engines.body_readings import BodyReadings, joint_openings, motion_of_points
from conrod.engines.capabilities import TIMED_REFERENCE
from conrod.engines.rapier import RAPIER_PRESETS
from conrod.engines.space import SpatialRun, SpatialStart
from conrod.exact.motion import Array
from conrod.exact.space import SpatialBody, SpatialJoint
from conrod.exact.space.forward_kinematics import forward_kinematics, rotation_matrices

MASK = rapier3d.JointAxesMask
# Axes that a joint holds; its own axis is x of its frames.
HELD = {
    "hinge": MASK.LOCKED_REVOLUTE_AXES, "slide": MASK.LOCKED_PRISMATIC_AXES, "ball": MASK.LOCKED_SPHERICAL_AXES,
    "connect": MASK.LOCKED_SPHERICAL_AXES, "weld": MASK.LOCKED_FIXED_AXES,
}  # fmt: skip
BLOCK_STEPS = 256  # whose laws are evaluated at once


def refusal_in_space(start: SpatialStart, preset: str) -> str | None:
    """Return the reason why Rapier is not given a machine in space, or None."""
    driven = {joint.name for joint in start.machine.driven}
    for body in start.tree.bodies[1:]:
        if len(body.joints) != 1 or body.joints[0].kind not in HELD:
            return f"rapier is given bodies with one hinge, slide or ball, not {body.name}"
        if body.joints[0].name in driven and body.parent:
            return f"rapier drives bodies on the ground, not {body.name}"
    if other := sorted({closure.kind for closure in start.tree.closures} - {*HELD}):
        return f"rapier is given loops closed by a connect or a weld, no {' or '.join(other)}"
    return None


def frame_along(axis: Array) -> Array:
    """A rotation (3, 3) whose first column is along an axis."""
    along = axis / np.linalg.norm(axis)
    aside = np.cross(along, np.eye(3)[int(np.argmin(np.abs(along)))])
    aside /= np.linalg.norm(aside)
    return np.column_stack([along, aside, np.cross(along, aside)])


def isometry(place: Array, turn: Array) -> Any:
    """Rapier's pose of a place (3,) [m] and a rotation (3, 3)."""
    return rapier3d.Isometry3(tuple(map(float, place)), rotation(turn))


def rotation(turn: Array) -> Any:
    """Rapier's rotation of a matrix (3, 3)."""
    return rapier3d.Rotation3.from_quaternion(*quaternion(turn).tolist())


def quaternion(turn: Array) -> Array:
    """The quaternion (4,) w, x, y, z of a rotation (3, 3), by the eigenvector of Bar-Itzhack's symmetric matrix."""
    a = np.empty((4, 4))
    a[:3, :3] = turn + turn.T - np.trace(turn) * np.eye(3)
    a[3, :3] = a[:3, 3] = [turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]]
    a[3, 3] = np.trace(turn)
    x, y, z, w = np.linalg.eigh(a)[1][:, -1]
    return np.array([w, x, y, z])


class RapierStepper:
    """A machine in space in Rapier that starts in its exact state; a call advances it by some steps.

    Attributes:
        done: number of steps made.
    """

    def __init__(self, start: SpatialStart, preset: str) -> None:
        settings = RAPIER_PRESETS[preset](TIMED_REFERENCE, 1000)  # of a machine in the plane, whose step is another
        self.start, self.done = start, 0
        self.world = rapier3d.PhysicsWorld(gravity=tuple(start.tree.gravity.tolist()))
        parameters = self.world.integration_parameters
        parameters.dt = start.step
        parameters.num_solver_iterations = settings.num_solver_iterations
        parameters.num_internal_pgs_iterations = settings.num_internal_pgs_iterations
        poses = forward_kinematics(start.tree, start.exact.coordinates, start.exact.rates[:1])
        driven = {joint.name for joint in start.machine.driven}
        self.handles = [self.world.add_body(rapier3d.RigidBody.fixed())]
        for number, body in enumerate(start.tree.bodies[1:], 1):
            joint = body.joints[0]
            place, turn = poses.places[number][0][:, 0], poses.turns[number][0][:, :, 0]
            velocity, turning = (
                one[number][1][..., 0] if len(one[number]) > 1 else 0.0 * one[number][0][..., 0]
                for one in (poses.places, poses.turns)
            )
            spin = (turning @ turn.T)[[2, 0, 1], [1, 2, 0]]
            pose = isometry(place, turn)
            if joint.name in driven:
                (pose,) = driven_poses(start, joint, start.exact.coordinates[joint.coordinates, 0])
            self.handles.append(self._add_body(body, pose, velocity + np.cross(spin, turn @ body.centre), spin, driven))
            if joint.name not in driven:
                along = frame_along(joint.axis)
                above = body.place + body.turn @ joint.anchor
                frames = isometry(above, body.turn @ along), isometry(joint.anchor, along)
                self._add_joint(joint.kind, (body.parent, number), frames)
        for closure in start.tree.closures:
            one, two = closure.points
            frames = (
                isometry(one.offset, np.eye(3) if closure.turn is None else closure.turn),
                isometry(two.offset, np.eye(3)),
            )
            self._add_joint(closure.kind, (one.body, two.body), frames)
        self.bodies = [self.world.rigid_bodies.get(handle) for handle in self.handles[1:]]

    def _add_body(self, body: SpatialBody, pose: Any, velocity: Array, spin: Array, driven: set[str]) -> Any:
        kinematic = body.joints[0].name in driven
        make = rapier3d.RigidBody.kinematic_position_based if kinematic else rapier3d.RigidBody.dynamic
        moments, axes = np.linalg.eigh(body.inertia)
        axes[:, 0] *= np.sign(np.linalg.det(axes))
        mass = rapier3d.MassProperties(tuple(body.centre.tolist()), body.mass, tuple(moments.tolist()), rotation(axes))
        made = make().position(pose).additional_mass_properties(mass).can_sleep(False)
        return self.world.add_body(made.linvel(tuple(velocity.tolist())).angvel(tuple(spin.tolist())))

    def _add_joint(self, kind: str, bodies: tuple[int, int], frames: tuple[Any, Any]) -> None:
        """Add an impulse joint between two bodies, by a frame in each."""
        made = rapier3d.GenericJointBuilder(HELD[kind]).local_frame1(frames[0]).local_frame2(frames[1])
        self.world.impulse_joints.insert(*(self.handles[k] for k in bodies), made.contacts_enabled(False).build())

    def __call__(self, steps: int) -> None:
        for first in range(0, steps, BLOCK_STEPS):
            ends = self.done + 1.0 + np.arange(min(BLOCK_STEPS, steps - first))
            times = np.asarray(self.start.step * ends, dtype=float)
            moved = [
                (self.bodies[joint.body - 1], driven_poses(self.start, joint, law.derivatives(times)[0]))
                for joint, law in zip(self.start.machine.driven, self.start.machine.laws.values(), strict=True)
            ]
            for k in range(len(times)):
                for body, poses in moved:
                    body.set_next_kinematic_position(poses[k])
                self.world.step()
            self.done += len(times)

    def readings(self) -> BodyReadings:
        """Poses and rates of all bodies."""
        turns = [one.rotation for one in self.bodies]
        poses = [[*one.translation, q.i, q.j, q.k, q.w] for one, q in zip(self.bodies, turns, strict=True)]
        return BodyReadings(np.array(poses), np.array([[*one.linvel, *one.angvel] for one in self.bodies]), None)


def driven_poses(start: SpatialStart, joint: SpatialJoint, coordinates: Array) -> list[Any]:
    """Rapier's poses of a body whose joint to the ground has some coordinates (T,) [rad, m].

    A quaternion goes on over whole turns: Rapier takes one that changes its sign as a turn back.
    """
    body, moved = start.tree.bodies[joint.body], coordinates - joint.reference
    w, x, y, z = quaternion(body.turn)
    half = 0.5 * moved * (joint.kind == "hinge")
    about = np.vstack([np.cos(half), np.sin(half) * joint.axis[:, None]])
    turns = np.array([[w, -x, -y, -z], [x, w, -z, y], [y, z, w, -x], [z, -y, x, w]]) @ about
    anchor = (body.place + body.turn @ joint.anchor)[:, None]
    if joint.kind == "slide":
        anchor = anchor + np.outer(body.turn @ joint.axis, moved)
    places = anchor - np.einsum("ijt,j->it", rotation_matrices(np.asarray(turns)), joint.anchor)
    return [
        rapier3d.Isometry3(tuple(place), rapier3d.Rotation3.from_quaternion(*turn))
        for place, turn in zip(places.T.tolist(), turns.T.tolist(), strict=True)
    ]


def run_in_space(start: SpatialStart, preset: str, steps: int, every: int = 1) -> SpatialRun:
    """Run a machine from its exact state, and record its points at the start and after each `every` steps.

    Accelerations are central differences of velocities. A run whose joints come apart is ended.
    """
    stepper, read, failure = RapierStepper(start, preset), dict[int, BodyReadings](), ""
    read[0] = stepper.readings()
    for k in sorted({k + d for k in range(0, steps + 1, every) for d in (-1, 0, 1) if k + d > 0} | {2}):
        stepper(k - stepper.done)
        read[k] = stepper.readings()
        openings = joint_openings(start.tree, read[k]) if k % every == 0 else {"": 0.0}
        name = max(openings, key=openings.__getitem__)
        if not openings[name] <= MAX_JOINT_GAP * start.tree.extent:
            failure = f"the joint {name} is open by {1e3 * openings[name]:.3g} mm at {k * start.step:.4g} s"
            break
    samples = [k for k in range(0, steps + 1, every) if k in read and k + 1 in read]
    times = start.step * np.array(samples, dtype=float)
    return SpatialRun(times, motion_of_points(start, read, samples, own=False), failure)
