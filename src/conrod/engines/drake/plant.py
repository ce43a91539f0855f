"""A tree of links as a Drake `MultibodyPlant`: bodies, joints, loops, drives, and its state at the start."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import (
    BallRpyJoint,
    FixedOffsetFrame,
    LinearBushingRollPitchYaw,
    PrismaticJoint,
    RevoluteJoint,
    RotationalInertia,
    SpatialInertia,
)

from conrod.engines.drake import DISCRETE, DrakeSettings
from conrod.exact.motion import Array
from conrod.exact.space import SpatialBody, SpatialClosure, SpatialJoint, SpatialTree
from conrod.exact.space.forward_kinematics import forward_kinematics, rotation_matrices

JOINTS = {"hinge": RevoluteJoint, "slide": PrismaticJoint, "ball": BallRpyJoint}
CLOSURES = ("connect", "weld")


@dataclass(frozen=True, eq=False)
class DrakeJoint:
    """A joint of a plant.

    Attributes:
        joint: Drake's joint.
        turn: rotation (3, 3) of its frame in the body's.
        reference: the tree's coordinate where Drake's is 0.
    """

    joint: Any
    turn: Array
    reference: float


@dataclass(frozen=True, eq=False)
class DrakePlant:
    """A plant with the bodies of a tree.

    Attributes:
        bodies: Drake's bodies in the order of the tree's, the world first.
        joints: the joints by name.
        flywheels: rotor inertia [kg m^2, kg] of each driven joint, by its name.
    """

    plant: MultibodyPlant
    bodies: tuple[Any, ...]
    joints: Mapping[str, DrakeJoint]
    flywheels: Mapping[str, float]

    def place(self, tree: SpatialTree, context: Any, coordinates: Array, rates: Array) -> None:
        """Write coordinates (nq,) and rates (nv,) of the tree into a context; balls are where the plant was built."""
        q, v = np.zeros(self.plant.num_positions()), np.zeros(self.plant.num_velocities())
        for joint in tree.joints:
            made = self.joints[joint.name]
            at = made.joint.velocity_start()
            if joint.kind == "ball":
                v[at : at + 3] = made.turn.T @ rates[joint.rates]
            else:
                q[made.joint.position_start()] = coordinates[joint.coordinate] - made.reference
                v[at] = rates[joint.rate]
        self.plant.SetPositions(context, q)
        self.plant.SetVelocities(context, v)

    def body_states(self, context: Any, numbers: Iterable[int]) -> Array:
        """Read the motion (B, 8, 3) of some bodies, in the ground's directions.

        Rows: position, the three axes of its frame, velocity, angular velocity, acceleration, angular acceleration.
        """
        found, plant = [], self.plant
        for number in numbers:
            body = self.bodies[number]
            pose, rate = plant.EvalBodyPoseInWorld(context, body), plant.EvalBodySpatialVelocityInWorld(context, body)
            bend = plant.EvalBodySpatialAccelerationInWorld(context, body)
            turn = pose.rotation().matrix()
            moved = [pose.translation(), *turn.T, rate.translational(), rate.rotational()]
            found.append([*moved, bend.translational(), bend.rotational()])
        return np.array(found)


def build_plant(
    tree: SpatialTree, driven: Collection[str], coordinates: Array, step: float, settings: DrakeSettings
) -> DrakePlant:
    """Build the plant of a tree whose driven joints have flywheels.

    Args:
        driven: names of the driven joints.
        coordinates: (nq,) at the start; a ball's angles are 0 there.
        step: time step [s].
    """
    plant = MultibodyPlant(step if settings.integrator == DISCRETE else 0.0)
    if settings.integrator == DISCRETE:
        # Accelerations are then those of the state in the context, not of the step before.
        plant.SetUseSampledOutputPorts(False)
    bodies, joints = [plant.world_body()], dict[str, DrakeJoint]()
    for body in tree.bodies[1:]:
        bodies.append(_add_body(plant, bodies[body.parent], body, coordinates, joints))
    mass, start = sum(body.mass for body in tree.bodies), forward_kinematics(tree, coordinates[:, None])
    for closure in tree.closures:
        if settings.integrator == DISCRETE:
            _add_constraint(plant, bodies, closure)
        else:
            ends = _bushing_frames(tree, closure, [turn[0][:, :, 0] for turn in start.turns])
            frames = [
                plant.AddFrame(FixedOffsetFrame(f"{closure.name} end {k}", bodies[end].body_frame(), place))
                for k, (end, place) in enumerate(ends, 1)
            ]
            _add_bushing(plant, frames, closure, settings.bushing_stiffness * mass / step**2, tree.extent)
    flywheels = {}
    for joint in tree.joints:
        if joint.name in driven:
            arm = 1.0 if joint.kind == "slide" else tree.extent
            flywheels[joint.name] = settings.flywheel_ratio * mass * arm**2
            actuator = plant.AddJointActuator(joint.name, joints[joint.name].joint)
            actuator.set_default_rotor_inertia(flywheels[joint.name])
            actuator.set_default_gear_ratio(1.0)
    plant.mutable_gravity_field().set_gravity_vector(tree.gravity)
    plant.Finalize()
    return DrakePlant(plant, tuple(bodies), joints, flywheels)


def _add_body(
    plant: MultibodyPlant, parent: Any, body: SpatialBody, coordinates: Array, joints: dict[str, DrakeJoint]
) -> Any:
    """Add a body with its joints, as a chain of bodies without mass that ends in it; return it."""
    inertia = SpatialInertia.MakeFromCentralInertia(
        body.mass, body.centre, RotationalInertia(*np.diag(body.inertia), *body.inertia[[0, 0, 1], [1, 2, 2]])
    )
    pose = RigidTransform(RotationMatrix(body.turn), body.place)
    if not body.joints:
        made = plant.AddRigidBody(body.name, inertia)
        plant.WeldFrames(parent.body_frame(), made.body_frame(), pose)
        return made
    for joint in body.joints:
        last = joint is body.joints[-1]
        name = body.name if last else f"{body.name} before {joint.name}"
        made = plant.AddRigidBody(name, inertia if last else SpatialInertia.Zero())
        turn, start = _joint_frame(joint, body, coordinates)
        on_parent = pose @ RigidTransform(RotationMatrix(start @ turn), joint.anchor)
        on_body = RigidTransform(RotationMatrix(turn), joint.anchor)
        frames = [
            plant.AddFrame(FixedOffsetFrame(f"{joint.name} on {side}", one.body_frame(), place))
            for side, one, place in (("parent", parent, on_parent), ("body", made, on_body))
        ]
        axis = () if joint.kind == "ball" else (joint.axis,)
        own = plant.AddJoint(JOINTS[joint.kind](joint.name, *frames, *axis))
        joints[joint.name] = DrakeJoint(own, turn, joint.reference)
        parent, pose = made, RigidTransform()
    return made


def _joint_frame(joint: SpatialJoint, body: SpatialBody, coordinates: Array) -> tuple[Array, Array]:
    """Rotation (3, 3) of a joint's frame in its body's, and the body's own rotation (3, 3) by a ball at the start."""
    if joint.kind != "ball":
        return np.eye(3), np.eye(3)
    return slender_axes(body), rotation_matrices(coordinates[joint.coordinates, None])[:, :, 0]


def slender_axes(body: SpatialBody) -> Array:
    """Axes (3, 3) of a body's inertia as columns, that of the least first.

    Drake's angles roll, pitch and yaw are singular at a pitch of a right angle. A rod that spins freely about its axis
    rolls about the first: no spin is singular.
    """
    axes = np.linalg.eigh(body.inertia)[1]
    axes[:, 0] *= np.sign(np.linalg.det(axes))
    return np.asarray(axes)


def _bushing_frames(
    tree: SpatialTree, closure: SpatialClosure, turns: Sequence[Array]
) -> list[tuple[int, RigidTransform]]:
    """Frames of a bushing's ends, each with its body's number: at the start without roll, pitch and yaw.

    Args:
        turns: rotation (3, 3) of each body at the start.
    """
    ends = list(closure.points)
    if closure.turn is not None:
        first, second = RotationMatrix(closure.turn), RotationMatrix()
        return [(end.body, RigidTransform(turn, end.offset)) for end, turn in zip(ends, (first, second), strict=True)]
    ends.sort(key=lambda end: -_slenderness(tree.bodies[end.body]))  # the more slender body is the one that may spin
    axes = slender_axes(tree.bodies[ends[1].body])
    aligned = turns[ends[0].body].T @ turns[ends[1].body] @ axes
    return [
        (end.body, RigidTransform(RotationMatrix(turn), end.offset))
        for end, turn in zip(ends, (aligned, axes), strict=True)
    ]


def _slenderness(body: SpatialBody) -> float:
    """Least over middle moment of inertia of a body: 1 for a ball or the ground, near 0 for a rod."""
    least, middle, _ = np.linalg.eigvalsh(body.inertia)
    return float(least / middle) if middle > 0.0 else 1.0


def _add_constraint(plant: MultibodyPlant, bodies: list[Any], closure: SpatialClosure) -> None:
    """Close a loop by a ball or weld constraint of the solver SAP."""
    (first, second), turn = closure.points, closure.turn
    one, other = bodies[first.body], bodies[second.body]
    if turn is None:
        plant.AddBallConstraint(one, first.offset, other, second.offset)
        return
    frame = RigidTransform(RotationMatrix(turn), first.offset)
    plant.AddWeldConstraint(one, frame, other, RigidTransform(second.offset))


def _add_bushing(
    plant: MultibodyPlant, frames: Sequence[Any], closure: SpatialClosure, stiffness: float, extent: float
) -> None:
    """Close a loop by a bushing of a stiffness [N/m] without damping, in the rotations of a weld too."""
    none, ones = np.zeros(3), np.ones(3)
    turning = none if closure.turn is None else stiffness * extent**2 * ones
    plant.AddForceElement(LinearBushingRollPitchYaw(*frames, turning, none, stiffness * ones, none))
