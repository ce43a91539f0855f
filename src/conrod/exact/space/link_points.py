"""Points to observe on the links of a machine in space where those that have a name show nothing of its loops."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace

import numpy as np

from conrod.exact.motion import Array
from conrod.exact.space import SpatialBody, SpatialPoint, SpatialTree
from conrod.exact.space.forward_kinematics import forward_kinematics
from conrod.exact.space.mobility import Mobility, rigid_points
from conrod.exact.space.motion import DrivenTree

STILL = 1e-9  # of the extent: displacement of a point that stands still


def telling_points(machine: DrivenTree, freedom: Mobility) -> set[str]:
    """Names of points that loops move along a tracked motion, and that the drives determine."""
    return _moved_by_loops(machine, machine.tree.points) - set(freedom.undetermined)


def with_telling_points(machine: DrivenTree, telling: set[str]) -> SpatialTree:
    """The tree of a tracked machine with the points that tell of its loops alone, or with points of its links.

    Args:
        telling: names of `telling_points`; where there is none, points of links take their place, if any tells of them.
    """
    tree = machine.tree
    points = {name: tree.points[name] for name in tree.points if name in telling} or link_points(machine)
    return replace(tree, points=points or tree.points)


def link_points(machine: DrivenTree) -> dict[str, SpatialPoint]:
    """One point, by name, of each link that the loops of a tracked machine move.

    It is the centre of gravity; where no loop moves that, as of a gear, it is a point off the link's axis.
    """
    tree, found = machine.tree, dict[str, SpatialPoint]()
    for k, body in enumerate(tree.bodies):
        if body.joints and set(tree.joints_above[k]) & set(tree.loop_joints):
            points = {name: SpatialPoint(k, offset) for name, offset in _candidates(body)}
            moved = _moved_by_loops(machine, points)
            found |= dict([(name, point) for name, point in points.items() if name in moved][:1])
    return found


def _moved_by_loops(machine: DrivenTree, points: Mapping[str, SpatialPoint]) -> set[str]:
    """Names of points that closures can move, and that do not stand still along the tracked motion."""
    poses = forward_kinematics(machine.tree, np.concatenate([knot.coordinates for knot in machine.knots], axis=1))
    places = {name: np.asarray(poses.point(point)[0]) for name, point in points.items()}
    least = STILL * machine.tree.extent
    moving = {name for name, place in places.items() if np.abs(place - place[:, :1]).max() > least}
    return moving - set(rigid_points(machine, points))


def _candidates(body: SpatialBody) -> Iterator[tuple[str, Array]]:
    """Yield points of a link by name, as offsets (3,) in its frame [m], the best to observe first."""
    yield f"centre of gravity of {body.name}", body.centre
    hinge = next((joint for joint in body.joints if joint.kind == "hinge"), None)
    if hinge is None or body.mass <= 0.0:
        return
    # As far off as its radius of gyration, in the direction that is nearest to an axis of its frame.
    radius = float(np.sqrt(np.linalg.eigvalsh(body.inertia)[-1] / body.mass))
    across = np.eye(3)[int(np.argmin(np.abs(hinge.axis)))]
    across = across - (across @ hinge.axis) * hinge.axis
    offset = hinge.anchor + radius * across / np.linalg.norm(across)
    yield f"{body.name} {1e3 * radius:.3g} mm off its axis", offset
