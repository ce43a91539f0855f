"""Links of a user's model that moves in a plane, from its bodies, joints and closures."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from conrod.exact.motion import Array
from conrod.exact.space import SpatialClosure, SpatialPoint, SpatialTree
from conrod.exact.space.forward_kinematics import forward_kinematics
from conrod.mechanism.mechanism import GROUND
from conrod.models.check.links import LinkGraph

# Sine of an angle up to which an axis is meant to be along, or across, the crank's.
AXIS_TOLERANCE = 0.1
SAME_PIN_DISTANCE = 1e-6  # of the machine's extent: two connects along one axis are one pin
PLANAR_FREE_JOINTS = ["hinge", "slide", "slide"]  # joints of a body that is free in the plane


def links_of(tree: SpatialTree, crank: str, points: Mapping[str, SpatialPoint]) -> LinkGraph | None:
    """Build the link graph of a model in the plane across its crank's axis; None if it is not planar.

    Args:
        crank: name of the hinge that is driven.
        points: observed points by name.
    """
    try:
        return _PlanarModel(tree, crank).graph(points)
    except NotPlanarError:
        return None


class NotPlanarError(ValueError):
    """A model whose joints are not pins and slides of a plane."""


class _PlanarModel:
    """A spatial tree with its closures, whose bodies are merged to links where no joint moves between them.

    Attributes:
        axis: axis (3,) of the crank in the ground's frame.
        turns: rotation matrices (3, 3) of all bodies, in the pose that the model is assembled from.
        frames: for each body the body whose frame its link uses, and the pose of the body in that frame: rotation
            (3, 3), position (3,) [m].
    """

    def __init__(self, tree: SpatialTree, crank: str) -> None:
        joint, found = (
            next(joint for joint in tree.joints if joint.name == crank),
            forward_kinematics(tree, tree.start[:, None]),
        )
        self.tree, self.crank = tree, joint.body
        self.axis = found.axes(joint)[:, 0, 0]
        self.turns = [turn[0][..., 0] for turn in found.turns]
        self.frames = {0: (0, np.eye(3), np.zeros(3))}
        for k, body in enumerate(tree.bodies[1:], 1):
            root, turn, place = self.frames[body.parent]
            self.frames[k] = (
                (k, np.eye(3), np.zeros(3)) if body.joints else (root, turn @ body.turn, place + turn @ body.place)
            )
        for closure in tree.closures:
            if closure.turn is not None:
                self._merge_welded(closure, closure.turn)

    def _merge_welded(self, weld: SpatialClosure, turn: Array) -> None:
        """Merge the two links that a weld ties, in the frame of the first."""
        (one, two) = weld.points
        root, first, place = self.frames[one.body]
        other, second, there = self.frames[two.body]
        if root == other:
            return
        # The frame of the second link's root in the first's: through both bodies and the weld between them.
        rotation = first @ turn @ second.T
        origin = place + first @ (one.offset - turn @ two.offset) - rotation @ there
        if other == 0:
            root, other, rotation, origin = 0, root, rotation.T, -rotation.T @ origin
        for k, (own, own_turn, own_place) in self.frames.items():
            if own == other:
                self.frames[k] = root, rotation @ own_turn, origin + rotation @ own_place

    def name(self, body: int) -> str:
        """Name of the link that a body belongs to."""
        root = self.frames[body][0]
        return self.tree.bodies[root].name if root else GROUND

    def in_link_plane(self, body: int, vector: Array, place: bool = True) -> Array:
        """Project a place or direction in a body's frame (3,) to the plane of its link (2,)."""
        root, turn, origin = self.frames[body]
        normal = self.turns[root].T @ self.axis
        right = np.linalg.svd(normal[None])[2][1]
        there = turn @ vector + (origin if place else 0.0)
        return np.array([right @ there, np.cross(normal, right) @ there])

    def axial_share(self, body: int, vector: Array) -> float:
        """Component of a unit vector in a body's frame (3,) along the crank's axis, from 0 to 1."""
        return abs(float(self.axis @ self.turns[body] @ vector))

    def graph(self, points: Mapping[str, SpatialPoint]) -> LinkGraph:
        """Build the graph of all links and joints; raises NotPlanarError for a joint that is not planar."""
        made = LinkGraph(self.name(self.crank))
        made.link(GROUND)
        for k, body in enumerate(self.tree.bodies):
            kinds = sorted(joint.kind for joint in body.joints)
            if not kinds or self.name(k) == self.name(body.parent) or kinds == PLANAR_FREE_JOINTS:
                continue
            if len(kinds) > 1:
                raise NotPlanarError
            (joint,) = body.joints
            names, axis = (self.name(body.parent), self.name(k)), self.axial_share(k, joint.axis)
            there = self.in_link_plane(body.parent, body.place + body.turn @ joint.anchor)
            if joint.kind == "hinge" and axis > 1.0 - AXIS_TOLERANCE:
                made.pin(joint.name, *names, (there, self.in_link_plane(k, joint.anchor)))
            elif joint.kind == "slide" and axis < AXIS_TOLERANCE:
                lines = (
                    (
                        self.in_link_plane(body.parent, body.place),
                        self.in_link_plane(body.parent, body.turn @ joint.axis, place=False),
                    ),
                    (self.in_link_plane(k, np.zeros(3)), self.in_link_plane(k, joint.axis, place=False)),
                )
                made.slide(joint.name, *names, lines)
            else:
                raise NotPlanarError
        for closure in self.tree.closures:
            self._add_connect(made, closure)
        for name, point in points.items():
            made.link(self.name(point.body)).points[name] = self.in_link_plane(point.body, point.offset)
        return made

    def _add_connect(self, made: LinkGraph, closure: SpatialClosure) -> None:
        """Add a connect as a pin, unless a pin of the same links is at its place."""
        if closure.kind == "weld":
            return
        if closure.kind != "connect":
            raise NotPlanarError
        names = [self.name(point.body) for point in closure.points]
        places = [self.in_link_plane(point.body, point.offset) for point in closure.points]
        if names[0] == names[1]:
            raise NotPlanarError
        for edge in made.edges:
            if edge.kind == "pin" and sorted(edge.links) == sorted(names):
                off = [np.abs(made.links[n].pins[edge.name] - p).max() for n, p in zip(names, places, strict=True)]
                if max(off) < SAME_PIN_DISTANCE * self.tree.extent:
                    return
        made.pin(closure.name, names[0], names[1], (places[0], places[1]))
