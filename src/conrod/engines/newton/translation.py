"""A machine in space as a model of Newton: links, joints of the tree, loop joints, and the exact start.

A joint's frame has its x axis along the joint's first axis, as SolverXPBD loses a hinge whose axis is oblique to its
frame (docs/findings). Of several joints of a body Newton makes one of six degrees of freedom (D6). A closure is a joint
outside the articulation; two points that join the same two bodies are a hinge through both.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import newton
import numpy as np
import warp

from conrod.engines.newton import XPBD, NewtonSettings
from conrod.engines.space import SpatialStart
from conrod.exact.motion import Array
from conrod.exact.space import SpatialBody, SpatialClosure, SpatialJoint, SpatialTree
from conrod.exact.space.forward_kinematics import rotation_matrices

CLOSURES = ("connect", "weld")
TREE_JOINTS = ("hinge", "slide", "ball")
FLYWHEEL_RATIO = 1e12  # armature of a driven joint over the inertia that all bodies together could have about it
SQUARE = 1e-9  # cosine of the angle between two axes that count as perpendicular


def translation_refusal(tree: SpatialTree) -> str:
    """Return the reason why Newton has no joints for a machine, or an empty text."""
    if other := sorted({joint.kind for joint in tree.joints} - {*TREE_JOINTS}):
        return f"newton is given hinges, slides and balls, no {' or '.join(other)} joints"
    if other := sorted({closure.kind for closure in tree.closures} - {*CLOSURES}):
        return f"newton is given loops closed by a connect or a weld, no {' or '.join(other)}"
    for body in tree.bodies[1:]:
        if not body.joints:
            return f"newton is given no body without a joint, as {body.name} is"
        if _mixed_joints(body.joints):
            return (
                f"newton is given several joints of a body only at one place, slides first, with perpendicular axes: "
                f"not {body.name}"
            )
    for (one, other_end), closures in closures_by_bodies(tree).items():
        if len(closures) > 2 or (len(closures) == 2 and any(c.kind == "weld" for c in closures)):
            names = f"{tree.bodies[one].name} and {tree.bodies[other_end].name}"
            return f"newton is given one joint of a loop between two bodies, not {len(closures)} between {names}"
    return ""


def _mixed_joints(joints: Sequence[SpatialJoint]) -> bool:
    """True if a body's joints are not one joint of Newton's."""
    kinds = [joint.kind for joint in joints]
    if len(joints) == 1:
        return False
    if "ball" in kinds or kinds != sorted(kinds, reverse=True) or max(map(kinds.count, kinds)) > 3:
        return True
    if any(not np.array_equal(joint.anchor, joints[0].anchor) for joint in joints):
        return True
    alike = [(a, b) for a in joints for b in joints if a is not b and a.kind == b.kind]
    return any(abs(float(a.axis @ b.axis)) > SQUARE for a, b in alike)


def closures_by_bodies(tree: SpatialTree) -> dict[tuple[int, int], list[SpatialClosure]]:
    """Closures by the numbers of the two bodies that they join."""
    found = dict[tuple[int, int], list[SpatialClosure]]()
    for closure in tree.closures:
        one, other = (point.body for point in closure.points)
        found.setdefault((one, other), []).append(closure)
    return found


@dataclass(frozen=True)
class TranslatedMachine:
    """A model of Newton, with the numbers of a machine's parts in it; a body's number in Newton is one less.

    Attributes:
        model: Newton's model, in the exact state at the start.
        driven: numbers of the driven joints' coordinates and rates, in the order of the laws.
        kinematic: numbers of the bodies in Newton whose poses are prescribed, in SolverXPBD.
    """

    model: Any
    driven: tuple[tuple[int, int], ...]
    kinematic: tuple[int, ...]


def translate(start: SpatialStart, settings: NewtonSettings, device: str) -> TranslatedMachine:
    """Build Newton's model of a machine in its exact state; flywheels or prescribed poses drive it."""
    tree, builder, maximal = start.tree, newton.ModelBuilder(), settings.solver == XPBD
    newton.solvers.SolverMuJoCo.register_custom_attributes(builder)
    driven = [joint.name for joint in start.machine.driven]
    flywheel = 0.0 if maximal else FLYWHEEL_RATIO * sum(body.mass for body in tree.bodies) * tree.extent**2
    kinematic = [maximal and any(joint.name in driven for joint in body.joints) for body in tree.bodies]
    for body, prescribed in zip(tree.bodies[1:], kinematic[1:], strict=True):
        builder.add_link(
            com=_vector(body.centre), mass=body.mass, inertia=_matrix(body.inertia), label=body.name,
            is_kinematic=prescribed,
        )  # fmt: skip
    # A joint's axes with their armatures. Newton's default limits and gains are none.
    articulated = [
        _add_joint(builder, number, body, {joint.name: flywheel for joint in body.joints if joint.name in driven})
        for number, body in enumerate(tree.bodies[1:])
    ]
    builder.add_articulation(articulated)
    for closures in closures_by_bodies(tree).values():
        _add_closure(builder, closures, maximal)
    with warp.ScopedDevice(device):
        model = builder.finalize(device=device, skip_validation_joints=True)
        model.set_gravity(tree.gravity.tolist())
        places = _write_start(model, articulated, start)
    numbers = tuple(number - 1 for number, prescribed in enumerate(kinematic) if prescribed)
    return TranslatedMachine(model, tuple(places[name] for name in driven), numbers)


def _vector(values: Array) -> Any:
    return warp.vec3(*map(float, values))


def _matrix(values: Array) -> Any:
    return warp.mat33(*np.asarray(values, dtype=float).ravel().tolist())


def _transform(place: Array, turn: Array) -> Any:
    """Warp's transform of a place (3,) [m] and a rotation (3, 3)."""
    return warp.transform(_vector(place), warp.quat_from_matrix(_matrix(turn)))


def joint_frame(along: Array, aside: Array | None = None) -> Array:
    """A rotation (3, 3) with its first column along an axis, and its second along a perpendicular one if given."""
    first = along / np.linalg.norm(along)
    second = np.eye(3)[int(np.argmin(np.abs(first)))] if aside is None else aside
    second = second - (second @ first) * first
    second /= np.linalg.norm(second)
    return np.column_stack([first, second, np.cross(first, second)])


def _axis(direction: Array, armature: float = 0.0) -> Any:
    """An axis of a joint of Newton's, without limits."""
    return newton.ModelBuilder.JointDofConfig(
        axis=_vector(direction), armature=armature, limit_lower=-math.inf, limit_upper=math.inf
    )


def _add_joint(builder: Any, link: int, body: SpatialBody, armatures: dict[str, float]) -> int:
    """Add the joint between a body and its parent; return its number."""
    joints, first = body.joints, body.joints[0]
    hinges = [joint for joint in joints if joint.kind == "hinge"]
    leading = hinges or list(joints)
    frame = np.eye(3)
    if first.kind != "ball":
        frame = joint_frame(leading[0].axis, leading[1].axis if len(leading) > 1 else None)
    where = {
        "parent_xform": _transform(body.place + body.turn @ first.anchor, body.turn @ frame),
        "child_xform": _transform(first.anchor, frame),
        "label": first.name,
    }
    ends = (body.parent - 1, link)
    if first.kind == "ball":
        return int(builder.add_joint_ball(*ends, armature=first.armature, **where))
    axes = {j.kind: list[Any]() for j in joints}
    for joint in joints:
        axes[joint.kind].append(_axis(frame.T @ joint.axis, armatures.get(joint.name, joint.armature)))
    if len(joints) > 1:
        linear, angular = axes.get("slide", []), axes.get("hinge", [])
        return int(builder.add_joint_d6(*ends, linear_axes=linear, angular_axes=angular, **where))
    add = builder.add_joint_revolute if first.kind == "hinge" else builder.add_joint_prismatic
    return int(add(*ends, axis=axes[first.kind][0], **where))


def _add_closure(builder: Any, closures: Sequence[SpatialClosure], maximal: bool) -> None:
    """Add the joint that closes a loop between two bodies: a ball, a hinge through two points, or a weld."""
    first, *second = closures
    one, other = first.points
    links = [one.body - 1, other.body - 1]
    if first.kind == "weld":
        ends = [
            _transform(one.offset, np.eye(3) if first.turn is None else first.turn),
            _transform(other.offset, np.eye(3)),
        ]
        if maximal:
            builder.add_joint_fixed(*links, parent_xform=ends[0], child_xform=ends[1])
            return
        # Of a fixed joint SolverMuJoCo takes the pose from the model's reference pose; here it is given.
        held = ends[0] * warp.transform_inverse(ends[1])
        newton.solvers.mujoco.add_equality_weld(builder, *links, relpose=held)
        return
    places, frames = [one.offset, other.offset], [np.eye(3), np.eye(3)]
    add, options = builder.add_joint_ball, {}
    if second:
        far = [point.offset for point in second[0].points]
        frames = [joint_frame(end - place) for end, place in zip(far, places, strict=True)]
        places = [0.5 * (end + place) for end, place in zip(far, places, strict=True)]
        add, options = builder.add_joint_revolute, {"axis": _axis(np.array([1.0, 0.0, 0.0]))}
    ends = [_transform(place, frame) for place, frame in zip(places, frames, strict=True)]
    if links[1] < 0:  # a joint's child is no ground
        links, ends = links[::-1], ends[::-1]
    add(*links, parent_xform=ends[0], child_xform=ends[1], **options)


def _write_start(model: Any, articulated: Sequence[int], start: SpatialStart) -> dict[str, tuple[int, int]]:
    """Write the exact coordinates and rates into a model; return the numbers of both for each hinge and slide."""
    coordinates, rates = model.joint_q.numpy(), model.joint_qd.numpy()
    first_coordinate, first_rate = model.joint_q_start.numpy(), model.joint_qd_start.numpy()
    places, exact = dict[str, tuple[int, int]](), start.exact
    for number, body in zip(articulated, start.tree.bodies[1:], strict=True):
        q, v = int(first_coordinate[number]), int(first_rate[number])
        if body.joints[0].kind == "ball":
            ball = body.joints[0]
            w, *xyz = exact.coordinates[ball.coordinates, 0]
            coordinates[q : q + 4] = *xyz, w
            # Newton's rates of a ball are along the axes of the joint's frame of its parent.
            turn = rotation_matrices(exact.coordinates[ball.coordinates, :1])[:, :, 0]
            rates[v : v + 3] = turn @ exact.rates[0, ball.rates, 0]
            continue
        for k, joint in enumerate(body.joints):
            places[joint.name] = (q + k, v + k)
            coordinates[q + k] = exact.coordinates[joint.coordinate, 0] - joint.reference
            rates[v + k] = exact.rates[0, joint.rate, 0]
    model.joint_q.assign(coordinates)
    model.joint_qd.assign(rates)
    return places
