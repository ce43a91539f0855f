"""A spanning tree of a mechanism: the joint coordinates that engines with reduced coordinates use.

All slides go into the tree and pins are cut where a loop closes, because a cut pin is what engines close best. Every
joint coordinate is zero in the start pose.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from conrod.engines.engine import Machine
from conrod.errors import InvalidInput
from conrod.exact.motion import Array, turned
from conrod.mechanism.mechanism import GROUND, HigherPair, Mechanism, Mesh, Point, Prismatic, Rack, Revolute, Rolling


@dataclass(frozen=True)
class Branch:
    """A body with the joint that carries it."""

    joint: Revolute | Prismatic
    parent: str
    child: str
    sense: int  # +1: the coordinate grows as the child turns counter-clockwise (moves along the slide's direction)


@dataclass(frozen=True)
class Tree:
    """Branches, parents first, and the pins that close the loops."""

    mechanism: Mechanism
    branches: tuple[Branch, ...]
    cuts: tuple[Revolute, ...]
    start: Array  # (3 n,) exact poses at crank angle 0

    def coordinates(self, poses: Array) -> Array:
        """Joint coordinates (T, nv) of poses (T, 3 n)."""
        columns = []
        for branch in self.branches:
            turn, along = self._relative(branch, poses)
            turn0, along0 = self._relative(branch, self.start[None])
            value = turn - turn0 if isinstance(branch.joint, Revolute) else along - along0
            columns.append(branch.sense * value)
        return np.column_stack(columns)

    def _relative(self, branch: Branch, poses: Array) -> tuple[Array, Array]:
        """Turn of the child against its parent, and the way along the slide."""
        parent, child = self._pose(branch.parent, poses), self._pose(branch.child, poses)
        turn = child[:, 2] - parent[:, 2]
        if isinstance(branch.joint, Revolute):
            return turn, np.zeros(len(poses))
        direction = self.slide_direction(branch) + parent[:, 2]
        way = child[:, :2] - parent[:, :2]
        return turn, way[:, 0] * np.cos(direction) + way[:, 1] * np.sin(direction)

    def slide_direction(self, branch: Branch) -> float:
        """Direction [rad] of a slide in the frame of the parent."""
        joint = branch.joint
        assert isinstance(joint, Prismatic)
        return joint.direction if branch.child == joint.b else joint.direction + math.pi - joint.angle

    def _pose(self, body: str, poses: Array) -> Array:
        if body == GROUND:
            return np.zeros((len(poses), 3))
        i = self.mechanism.body_index[body]
        return np.asarray(poses[:, 3 * i : 3 * i + 3])

    def rates(self, poses: Array, rates: Array) -> Array:
        """Joint rates (T, nv) of rates (T, 3 n) of the poses (T, 3 n)."""
        columns = []
        for branch in self.branches:
            parent, child = self._pose(branch.parent, poses), self._pose(branch.child, poses)
            parent_rate, child_rate = self._pose(branch.parent, rates), self._pose(branch.child, rates)
            if isinstance(branch.joint, Revolute):
                value = child_rate[:, 2] - parent_rate[:, 2]
            else:
                direction = self.slide_direction(branch) + parent[:, 2]
                carried = _cross(parent_rate[:, 2], child[:, :2] - parent[:, :2])
                sliding = child_rate[:, :2] - parent_rate[:, :2] - carried
                value = sliding[:, 0] * np.cos(direction) + sliding[:, 1] * np.sin(direction)
            columns.append(branch.sense * value)
        return np.column_stack(columns)

    def accelerations(self, poses: Array, rates: Array, accelerations: Array) -> Array:
        """Joint accelerations (T, nv) of rates and accelerations (T, 3 n) of the poses (T, 3 n)."""
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

    def forward(self, coordinates: Array, rates: Array) -> tuple[Array, Array]:
        """Poses and their rates (T, 3 n) from joint coordinates and joint rates (T, nv)."""
        samples = len(coordinates)
        poses, speeds = np.zeros((samples, len(self.start))), np.zeros((samples, len(self.start)))
        for k, branch in enumerate(self.branches):
            i = self.mechanism.body_index[branch.child]
            pose, speed = self._carried(branch, poses, speeds, coordinates[:, k], rates[:, k])
            poses[:, 3 * i : 3 * i + 3], speeds[:, 3 * i : 3 * i + 3] = pose, speed
        return poses, speeds

    def _carried(self, branch: Branch, poses: Array, speeds: Array, q: Array, v: Array) -> tuple[Array, Array]:
        """Pose and rates of a branch's child, from those of its parent and the joint's coordinate."""
        parent, rate = self._pose(branch.parent, poses), self._pose(branch.parent, speeds)
        first, second = self.start_pose(branch.parent), self.start_pose(branch.child)
        q, v = branch.sense * q, branch.sense * v
        if isinstance(branch.joint, Revolute):
            on_parent, on_child = self.pin_points(branch)
            phi = second[2] - first[2] + parent[:, 2] + q
            arm, out = (np.column_stack(turned(pin, at)) for pin, at in ((on_parent, parent[:, 2]), (on_child, phi)))
            spin = rate[:, 2] + v
            place = parent[:, :2] + arm - out
            drift = rate[:, :2] + _cross(rate[:, 2], arm) - _cross(spin, out)
            return np.column_stack([place, phi]), np.column_stack([drift, spin])
        direction = self.slide_direction(branch)
        offset = _turned_back(second[:2] - first[:2], first[2])
        away = offset + q[:, None] * np.array([math.cos(direction), math.sin(direction)])
        arm = np.column_stack(turned((away[:, 0], away[:, 1]), parent[:, 2]))
        along = np.column_stack([np.cos(direction + parent[:, 2]), np.sin(direction + parent[:, 2])])
        place = parent[:, :2] + arm
        drift = rate[:, :2] + _cross(rate[:, 2], arm) + v[:, None] * along
        return np.column_stack([place, parent[:, 2] + second[2] - first[2]]), np.column_stack([drift, rate[:, 2]])

    def start_pose(self, body: str) -> Array:
        """Pose (3,) of a body at crank angle 0."""
        return np.asarray(self._pose(body, self.start[None])[0])

    def pin_points(self, branch: Branch) -> tuple[tuple[float, float], tuple[float, float]]:
        """The pin's point on the parent and on the child."""
        joint = branch.joint
        assert isinstance(joint, Revolute)
        return (joint.point_a, joint.point_b) if branch.child == joint.b else (joint.point_b, joint.point_a)


def tree_of(machine: Machine) -> Tree:
    """The tree of a machine."""
    return spanning_tree(machine.kinematics.mechanism, machine.kinematics.start[0])


def spanning_tree(mechanism: Mechanism, start: Array) -> Tree:
    """The tree of a mechanism, grown from the ground; slides first, then the driven pin, then the others as declared.

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
    return Tree(mechanism, tuple(branches), tuple(cuts), start)


def _turned_back(world: Array, angle: float) -> Array:
    c, s = math.cos(angle), math.sin(angle)
    return np.array([c * world[0] + s * world[1], c * world[1] - s * world[0]])


def _cross(spin: Array, arm: Array) -> Array:
    return np.column_stack([-spin * arm[:, 1], spin * arm[:, 0]])


SAME_PLACE = 1e-12  # of the largest coordinate of a point on a body


def mesh_row(tree: Tree, mesh: Mesh) -> Array:
    """Share of each joint coordinate of a tree in what rolls off a pair: (nv,) [m/rad] of pins, [m/m] of slides.

    Raises:
        InvalidInput: the pair's equation is not linear in them; says why.
    """
    turn_a, turn_b = turn_row(tree, mesh.a), turn_row(tree, mesh.b)
    if isinstance(mesh, Rolling):
        carrier = carrier_of(tree.mechanism, mesh)
        if carrier is None:
            raise InvalidInput(f"{mesh.name}: no one body carries the pins of both {mesh.a} and {mesh.b}")
        line = (mesh.radius_a + mesh.radius_b) * turn_row(tree, carrier)
        return np.asarray(mesh.radius_a * turn_a + mesh.radius_b * turn_b - line)
    return np.asarray(_way_row(tree, mesh) + mesh.radius * (turn_a - turn_b))


def tree_refusal(tree: Tree) -> str | None:
    """None, or the reason why an engine that ties joint coordinates linearly cannot have the rolling pairs."""
    for mesh in tree.mechanism.meshes:
        try:
            mesh_row(tree, mesh)
        except InvalidInput as reason:
            return f"{reason}: what rolls off is then not linear in the joints' coordinates"
    return None


def carrier_of(mechanism: Mechanism, mesh: Rolling) -> str | None:
    """The body that both centres of a rolling pair are pinned to, or are points of; the ground before any other."""
    first = holders(mechanism, mesh.a, mesh.point_a)
    second = holders(mechanism, mesh.b, mesh.point_b)
    common = [body for body in first if body in second]
    return min(common, key=lambda body: body != GROUND, default=None)


def holders(mechanism: Mechanism, body: str, point: Point) -> dict[str, Point]:
    """Bodies that a point of a body does not move on, itself among them, each with the place where it is on them."""
    found, waiting = {body: point}, [body]
    while waiting:
        here = waiting.pop()
        for joint in mechanism.joints:
            if not isinstance(joint, Revolute) or here not in (joint.a, joint.b):
                continue
            ends = [(joint.a, joint.point_a), (joint.b, joint.point_b)]
            (_, own), (other, there) = ends if joint.a == here else ends[::-1]
            if other not in found and _same(own, found[here]):
                found[other] = there
                waiting.append(other)
    return found


def _same(first: Point, second: Point) -> bool:
    size = max(1e-3, *(abs(v) for v in (*first, *second)))
    return math.dist(first, second) <= SAME_PLACE * size


def _path(tree: Tree, body: str) -> list[int]:
    """Branches from a body down to the ground, by number."""
    carried = {branch.child: k for k, branch in enumerate(tree.branches)}
    path = []
    while body != GROUND:
        path.append(carried[body])
        body = tree.branches[path[-1]].parent
    return path


def turn_row(tree: Tree, body: str) -> Array:
    """Share of each joint coordinate of a tree in the turn of a body (nv,)."""
    row = np.zeros(len(tree.branches))
    for k in _path(tree, body):
        if isinstance(tree.branches[k].joint, Revolute):
            row[k] = tree.branches[k].sense
    return row


def _way_row(tree: Tree, mesh: Rack) -> Array:
    """Of the way of the wheel's centre along the rack, against the rack."""
    for body in holders(tree.mechanism, mesh.a, mesh.point_a):
        to_centre, to_rack = set(_path(tree, body)), set(_path(tree, mesh.b))
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
