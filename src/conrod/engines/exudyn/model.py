"""Mechanism -> Exudyn `MainSystem`."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import exudyn
from exudyn.itemInterface import (
    LoadForceVector,
    MarkerBodyRigid,
    MarkerNodeCoordinate,
    NodePointGround,
    NodeRigidBody2D,
    ObjectConnectorCoordinate,
    ObjectGround,
    ObjectJointPrismatic2D,
    ObjectJointRevolute2D,
    ObjectRigidBody2D,
)

from conrod.engines.engine import Machine
from conrod.engines.exudyn.settings import ExudynSettings
from conrod.exact.motion import Array
from conrod.mechanism.mechanism import GROUND, Body, Joint, Mechanism, Point, Prismatic, Revolute

GIVEN = (Revolute, Prismatic)


@dataclass(frozen=True)
class Build:
    """A system of planar bodies, whose coordinates are the poses (3 n,) of `Mechanism.bodies`.

    Attributes:
        container: of the system, which must outlive it.
        drive: number of the constraint on the crank's turn.
    """

    container: Any
    system: Any
    drive: int


def refusal(machine: Machine, settings: ExudynSettings) -> str | None:
    """None, or the reason why these settings cannot be used on this machine."""
    mechanism = machine.kinematics.mechanism
    if mechanism.loads:
        return "exudyn is given gravity and constant forces, no loads that follow a law"
    if not all(isinstance(joint, GIVEN) for joint in mechanism.joints):
        return "exudyn is given pins and slides, no cams that act by contact and no wheels that roll"
    return None


@contextmanager
def silent() -> Iterator[None]:
    """Nothing is printed by Exudyn, which explains at length why a solver has failed."""
    printing = exudyn.config.printToConsole
    exudyn.config.printToConsole = False
    try:
        yield
    finally:
        exudyn.config.printToConsole = printing


def build(mechanism: Mechanism, poses: Array, rates: Array, rate: float | None) -> Build:
    """Translate, with the bodies in poses (3 n,) at rates (3 n,).

    Args:
        rate: that a constraint holds the crank's turn at [rad/s]. Exudyn needs no user function for it, of which its
            initial accelerations would take no account. None for a constraint on the turn itself, which is set later.
    """
    container = exudyn.SystemContainer()
    system = container.AddSystem()
    numbers, nodes = {GROUND: system.AddObject(ObjectGround())}, {}
    for body, pose, start in zip(mechanism.bodies, poses.reshape(-1, 3), rates.reshape(-1, 3), strict=True):
        # Reference coordinates are left at 0: displacements from them, which are what is integrated, are the pose.
        node = NodeRigidBody2D(initialCoordinates=pose.tolist(), initialVelocities=start.tolist())
        nodes[body.name] = system.AddNode(node)
        numbers[body.name] = _add_body(system, mechanism, body, nodes[body.name])
    for joint in mechanism.joints:
        _add_joint(system, numbers, joint)
    still = system.AddNode(NodePointGround())
    turns = [
        system.AddMarker(MarkerNodeCoordinate(nodeNumber=node, coordinate=k))
        for node, k in ((still, 0), (nodes[mechanism.crank], 2))
    ]
    held = {"offset": float(poses[3 * mechanism.body_index[mechanism.crank] + 2])}
    if rate is not None:
        held = {"offset": rate, "velocityLevel": True}
    drive = system.AddObject(ObjectConnectorCoordinate(markerNumbers=turns, **held))
    system.Assemble()
    return Build(container, system, drive)


def _add_body(system: Any, mechanism: Mechanism, body: Body, node: int) -> int:
    x, y = body.centre_of_gravity
    inertia = body.inertia + body.mass * (x * x + y * y)  # about the reference point
    rigid = ObjectRigidBody2D(nodeNumber=node, mass=body.mass, inertia=inertia, centerOfMass=[x, y])
    number: int = system.AddObject(rigid)
    push, (along, up) = mechanism.push_on(body.name), mechanism.gravity
    force = [push[0] + body.mass * along, push[1] + body.mass * up, 0.0]
    system.AddLoad(LoadForceVector(markerNumber=_marker(system, number, (x, y)), loadVector=force))
    return number


def _marker(system: Any, number: int, point: Point) -> Any:
    return system.AddMarker(MarkerBodyRigid(bodyNumber=number, localPosition=[*point, 0.0]))


def _add_joint(system: Any, numbers: Mapping[str, int], joint: Joint) -> None:
    assert isinstance(joint, GIVEN)  # or the machine is refused
    ends = ((joint.a, joint.point_a), (joint.b, joint.point_b))
    markers = [_marker(system, numbers[name], point) for name, point in ends]
    if isinstance(joint, Revolute):
        system.AddObject(ObjectJointRevolute2D(markerNumbers=markers))
        return
    across = joint.direction - joint.angle + 0.5 * math.pi
    slide = ObjectJointPrismatic2D(
        markerNumbers=markers,
        axisMarker0=[math.cos(joint.direction), math.sin(joint.direction), 0.0],
        normalMarker1=[math.cos(across), math.sin(across), 0.0],
    )
    system.AddObject(slide)
