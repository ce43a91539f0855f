"""Spanning tree of a mechanism: the joint coordinates of engines with reduced coordinates, such as MuJoCo.

All slides go into the tree, and pins are cut where a loop closes, because engines close a cut pin best. Every joint
coordinate is zero in the start pose.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from conrod.engines.engine import Machine
from conrod.errors import InvalidInput
from conrod.exact.motion import Array, rotate_planar
from conrod.mechanism.mechanism import GROUND, HigherPair, Mechanism, Mesh, Point, Prismatic, Rack, Revolute, Rolling


@dataclass(frozen=True)
class Branch:
    """A branch of the spanning tree: a body with the joint that connects it to its parent."""

    joint: Revolute | Prismatic
    parent: str
    child: str
    sense: int  # +1: the coordinate grows as the child turns counter-clockwise (moves along the slide's direction)


@dataclass(frozen=True)
class SpanningTree:
    """Branches from the ground up, parents first, and the pins that are cut to open the loops."""

    mechanism: Mechanism
    branches: tuple[Branch, ...]
    cuts: tuple[Revolute, ...]
    start: Array  # (3 n,) exact poses at crank angle 0

    def coordinates(self, poses: Array) -> Array:
        """Joint coordinates (T, nv) of poses (T, 3 n)."""
        columns = []
        for branch in self.branches:
            turn, along = self._relative_displacement(branch, poses)
            turn0, along0 = self._relative_displacement(branch, self.start[None])
            value = turn - turn0 if isinstance(branch.joint, Revolute) else along - along0
            columns.append(branch.sense * value)
        return np.column_stack(columns)

    def _relative_displacement(self, branch: Branch, poses: Array) -> tuple[Array, Array]:
        """Rotation (T,) of the child against its parent, and its displacement (T,) along the slide."""
        parent, child = self._pose(branch.parent, poses), self._pose(branch.child, poses)
        turn = child[:, 2] - parent[:, 2]
        if isinstance(branch.joint, Revolute):
            return turn, np.zeros(len(poses))
        direction = self.slide_direction(branch) + parent[:, 2]
        way = child[:, :2] - parent[:, :2]
        return turn, way[:, 0] * np.cos(direction) + way[:, 1] * np.sin(direction)

    def slide_direction(self, branch: Branch) -> float:
        """Direction [rad] of a slide in its parent's frame."""
        joint = branch.joint
        assert isinstance(joint, Prismatic)
        return joint.direction if branch.child == joint.b else joint.direction + math.pi - joint.angle

    def _pose(self, body: str, poses: Array) -> Array:
        """Columns (T, 3) of one body in values of all bodies (T, 3 n); zeros for the ground."""
        if body == GROUND:
            return np.zeros((len(poses), 3))
        i = self.mechanism.body_index[body]
        return np.asarray(poses[:, 3 * i : 3 * i + 3])

    def rates(self, poses: Array, rates: Array) -> Array:
        """Joint rates (T, nv) from poses and rates of the bodies (T, 3 n)."""
        columns = []
        for branch in self.branches:
            parent, child = self._pose(branch.parent, poses), self._pose(branch.child, poses)
            parent_rate, child_rate = self._pose(branch.parent, rates), self._pose(branch.child, rates)
            if isinstance(branch.joint, Revolute):
                value = child_rate[:, 2] - parent_rate[:, 2]
            else:
                direction = self.slide_direction(branch) + parent[:, 2]
                carried = _rotational_velocity(parent_rate[:, 2], child[:, :2] - parent[:, :2])
                sliding = child_rate[:, :2] - parent_rate[:, :2] - carried
                value = sliding[:, 0] * np.cos(direction) + sliding[:, 1] * np.sin(direction)
            columns.append(branch.sense * value)
        return np.column_stack(columns)

    def accelerations(self, poses: Array, rates: Array, accelerations: Array) -> Array:
        """Joint accelerations (T, nv) from poses, rates and accelerations of the bodies (T, 3 n)."""
        columns = []
        for branch in self.branches:
            place, rate, bend = (
                self._pose(branch.child, values) - self._pose(branch.parent, values)
                for values in (poses, rates, accelerations)
            )
            value = bend[:, 2]
            if isinstance(branch.joint, Prismatic):
                turn, spin, turning = (self._pose(branch.parent, x)[:, 2] for x in (poses, rates, accelerations))
                direction = self.slide_direction(branch) + turn
                along = np.column_stack([np.cos(direction), np.sin(direction)])
                # The direction turns with the parent, and so does its normal.
                normal = np.column_stack([-along[:, 1], along[:, 0]])
                value = ((bend[:, :2] - spin[:, None] ** 2 * place[:, :2]) * along).sum(axis=1)
                value += ((2.0 * spin[:, None] * rate[:, :2] + turning[:, None] * place[:, :2]) * normal).sum(axis=1)
            columns.append(branch.sense * value)
        return np.column_stack(columns)

    def forward_kinematics(
        self, coordinates: Array, rates: Array, known: Mapping[str, tuple[Array, Array]] | None = None
    ) -> tuple[Array, Array]:
        """Poses and rates of the bodies (T, 3 n) from joint coordinates and rates (T, nv).

        Args:
            known: poses and rates (T, 3) of bodies that are known without their joints, by name.
        """
        samples = len(coordinates)
        poses, speeds = np.zeros((samples, len(self.start))), np.zeros((samples, len(self.start)))
        for k, branch in enumerate(self.branches):
            i = self.mechanism.body_index[branch.child]
            pose, speed = (known or {}).get(branch.child) or self._child_state(
                branch, poses, speeds, coordinates[:, k], rates[:, k]
            )
            poses[:, 3 * i : 3 * i + 3], speeds[:, 3 * i : 3 * i + 3] = pose, speed
        return poses, speeds

    def _child_state(self, branch: Branch, poses: Array, speeds: Array, q: Array, v: Array) -> tuple[Array, Array]:
        """Pose and rates (T, 3) of a branch's child from its parent's, joint coordinate q and rate v (T,)."""
        parent, rate = self._pose(branch.parent, poses), self._pose(branch.parent, speeds)
        first, second = self.start_pose(branch.parent), self.start_pose(branch.child)
        q, v = branch.sense * q, branch.sense * v
        if isinstance(branch.joint, Revolute):
            on_parent, on_child = self.pin_points(branch)
            phi = second[2] - first[2] + parent[:, 2] + q
            arm, out = (
                np.column_stack(rotate_planar(pin, at)) for pin, at in ((on_parent, parent[:, 2]), (on_child, phi))
            )
            spin = rate[:, 2] + v
            place = parent[:, :2] + arm - out
            drift = rate[:, :2] + _rotational_velocity(rate[:, 2], arm) - _rotational_velocity(spin, out)
            return np.column_stack([place, phi]), np.column_stack([drift, spin])
        direction = self.slide_direction(branch)
        offset = _rotate_back(second[:2] - first[:2], first[2])
        away = offset + q[:, None] * np.array([math.cos(direction), math.sin(direction)])
        arm = np.column_stack(rotate_planar((away[:, 0], away[:, 1]), parent[:, 2]))
        along = np.column_stack([np.cos(direction + parent[:, 2]), np.sin(direction + parent[:, 2])])
        place = parent[:, :2] + arm
        drift = rate[:, :2] + _rotational_velocity(rate[:, 2], arm) + v[:, None] * along
        return np.column_stack([place, parent[:, 2] + second[2] - first[2]]), np.column_stack([drift, rate[:, 2]])

    def start_pose(self, body: str) -> Array:
        """Pose (3,) of a body in the start pose."""
        return np.asarray(self._pose(body, self.start[None])[0])

    def pin_points(self, branch: Branch) -> tuple[tuple[float, float], tuple[float, float]]:
        """The pin's point on the parent and on the child, in their frames [m]."""
        joint = branch.joint
        assert isinstance(joint, Revolute)
        return (joint.point_a, joint.point_b) if branch.child == joint.b else (joint.point_b, joint.point_a)


def machine_tree(machine: Machine) -> SpanningTree:
    """Spanning tree of a machine, with coordinates that are zero at crank angle 0."""
    return grow_spanning_tree(machine.kinematics.mechanism, machine.kinematics.start[0])


def grow_spanning_tree(mechanism: Mechanism, start: Array) -> SpanningTree:
    """Grow the tree from the ground: slides first, then the driven pin, then pins as declared.

    Raises:
        InvalidInput: slides alone close a loop, or a body hangs on nothing.
    """
    branches: list[Branch] = []
    cuts: list[Revolute] = []
    waiting: list[Revolute | Prismatic] = [j for j in mechanism.joints if not isinstance(j, HigherPair)]
    # The driven pin is never cut, wherever it is declared: its coordinate is the crank's angle.
    waiting.sort(key=lambda joint: (isinstance(joint, Revolute), joint.name != mechanism.driver.joint))
    held = {GROUND}
    while waiting:
        joint = next((j for j in waiting if j.a in held or j.b in held), None)
        if joint is None:
            raise InvalidInput(f"{mechanism.name}: joint {waiting[0].name!r} is not connected to the ground")
        waiting.remove(joint)
        if joint.a in held and joint.b in held:
            if isinstance(joint, Prismatic):
                raise InvalidInput(
                    f"{mechanism.name}: slide {joint.name!r} closes a loop of slides alone, which holds the turns of "
                    "its links twice over; a loop needs a pin"
                )
            cuts.append(joint)
            continue
        parent, child = (joint.a, joint.b) if joint.a in held else (joint.b, joint.a)
        sense = mechanism.driver.sense if joint.name == mechanism.driver.joint else 1
        branches.append(Branch(joint, parent, child, sense))
        held.add(child)
    return SpanningTree(mechanism, tuple(branches), tuple(cuts), start)


def _rotate_back(world: Array, angle: float) -> Array:
    """Components (2,) of a vector in a frame that is rotated by an angle [rad]."""
    c, s = math.cos(angle), math.sin(angle)
    return np.array([c * world[0] + s * world[1], c * world[1] - s * world[0]])


def _rotational_velocity(spin: Array, arm: Array) -> Array:
    """Velocity (T, 2) of the end of an arm (T, 2) that rotates at a rate (T,) [rad/s]."""
    return np.column_stack([-spin * arm[:, 1], spin * arm[:, 0]])


COINCIDENCE_TOLERANCE = 1e-12  # of the largest coordinate of a point on a body


def rolling_coefficients(tree: SpanningTree, mesh: Mesh) -> Array:
    """Coefficients (nv,) of the joint coordinates in a rolling pair's equation: [m/rad] for pins, 1 for slides.

    Raises:
        InvalidInput: the pair's equation is not linear in the coordinates; says why.
    """
    turn_a, turn_b = rotation_coefficients(tree, mesh.a), rotation_coefficients(tree, mesh.b)
    if isinstance(mesh, Rolling):
        carrier = carrier_body(tree.mechanism, mesh)
        if carrier is None:
            raise InvalidInput(f"{mesh.name}: no one body carries the pins of both {mesh.a} and {mesh.b}")
        line = (mesh.radius_a + mesh.radius_b) * rotation_coefficients(tree, carrier)
        return np.asarray(mesh.radius_a * turn_a + mesh.radius_b * turn_b - line)
    return np.asarray(_displacement_coefficients(tree, mesh) + mesh.radius * (turn_a - turn_b))


def tree_refusal(tree: SpanningTree) -> str | None:
    """Return the reason why a rolling pair is not linear in the joint coordinates, else None."""
    for mesh in tree.mechanism.meshes:
        try:
            rolling_coefficients(tree, mesh)
        except InvalidInput as reason:
            return f"{reason}: what rolls off is then not linear in the joints' coordinates"
    return None


def carrier_body(mechanism: Mechanism, mesh: Rolling) -> str | None:
    """The body on which both centres of a rolling pair are fixed, preferably the ground; or None."""
    first = bodies_at_point(mechanism, mesh.a, mesh.point_a)
    second = bodies_at_point(mechanism, mesh.b, mesh.point_b)
    common = [body for body in first if body in second]
    return min(common, key=lambda body: body != GROUND, default=None)


def bodies_at_point(mechanism: Mechanism, body: str, point: Point) -> dict[str, Point]:
    """Bodies on which a point of a body is fixed, through pins at that point, with its place on each."""
    found, waiting = {body: point}, [body]
    while waiting:
        here = waiting.pop()
        for joint in mechanism.joints:
            if not isinstance(joint, Revolute) or here not in (joint.a, joint.b):
                continue
            ends = [(joint.a, joint.point_a), (joint.b, joint.point_b)]
            (_, own), (other, there) = ends if joint.a == here else ends[::-1]
            if other not in found and _coincide(own, found[here]):
                found[other] = there
                waiting.append(other)
    return found


def _coincide(first: Point, second: Point) -> bool:
    """Return True if two points coincide but for rounding."""
    size = max(1e-3, *(abs(v) for v in (*first, *second)))
    return math.dist(first, second) <= COINCIDENCE_TOLERANCE * size


def _branches_to_ground(tree: SpanningTree, body: str) -> list[int]:
    """Indices of the branches from a body to the ground."""
    carried = {branch.child: k for k, branch in enumerate(tree.branches)}
    path = []
    while body != GROUND:
        path.append(carried[body])
        body = tree.branches[path[-1]].parent
    return path


def rotation_coefficients(tree: SpanningTree, body: str) -> Array:
    """Coefficients (nv,) of the joint coordinates in the rotation of a body."""
    row = np.zeros(len(tree.branches))
    for k in _branches_to_ground(tree, body):
        if isinstance(tree.branches[k].joint, Revolute):
            row[k] = tree.branches[k].sense
    return row


def _displacement_coefficients(tree: SpanningTree, mesh: Rack) -> Array:
    """Coefficients (nv,) of joint coordinates in the displacement of the wheel's centre along its rack."""
    for body in bodies_at_point(tree.mechanism, mesh.a, mesh.point_a):
        to_centre, to_rack = set(_branches_to_ground(tree, body)), set(_branches_to_ground(tree, mesh.b))
        between = to_centre ^ to_rack
        if all(isinstance(tree.branches[k].joint, Prismatic) for k in between):
            line = tree.start_pose(mesh.b)[2] + mesh.direction
            row = np.zeros(len(tree.branches))
            for k in between:
                branch = tree.branches[k]
                # In which its coordinate grows, in the start pose.
                against = 0.0 if branch.sense > 0 else math.pi
                direction = float(tree.slide_direction(branch) + tree.start_pose(branch.parent)[2] + against)
                row[k] = (1.0 if k in to_centre else -1.0) * math.cos(direction - line)
            return row
    raise InvalidInput(f"{mesh.name}: more than slides lies between the centre of {mesh.a} and {mesh.b}")
