"""What closes the loops of a tree, as MJCF. Imports no engine.

A cut pin is an equality `connect` of two sites. A link that is left out is a spatial tendon between two sites, whose
length an equality keeps at the one of the compiled pose, which is exact.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET

from conrod.engines.left_out_rod import DistanceJoint
from conrod.engines.mujoco.settings import MuJoCoSettings
from conrod.engines.mujoco.xml import add, numbers
from conrod.engines.tree import Tree
from conrod.mechanism import Point, Revolute


def add_closures(root: ET.Element, tree: Tree, settings: MuJoCoSettings) -> None:
    """Equalities of all loops, with the tendons that they hold."""
    if not tree.cuts and not tree.distances:
        return
    if tree.distances:
        tendons = add(root, "tendon")
        for distance in tree.distances:
            tendon = add(tendons, "spatial", name=distance.link)
            for site in _sites(distance):
                add(tendon, "site", site=site)
    equality = add(root, "equality")
    stiffness = {"solref": numbers(settings.solref), "solimp": numbers(settings.solimp)}
    for joint in tree.cuts:
        first, second = _sites(joint)
        add(equality, "connect", name=joint.name, site1=first, site2=second, **stiffness)
    for distance in tree.distances:
        add(equality, "tendon", name=distance.link, tendon1=distance.link, **stiffness)


def closure_points(body: str, tree: Tree) -> list[tuple[str, Point]]:
    """Names and places of the sites of a body that closures hold."""
    closing: tuple[Revolute | DistanceJoint, ...] = (*tree.cuts, *tree.distances)
    points = []
    for joint in closing:
        ends = ((joint.a, joint.point_a), (joint.b, joint.point_b))
        points += [(site, point) for site, (holder, point) in zip(_sites(joint), ends, strict=True) if holder == body]
    return points


def _sites(joint: Revolute | DistanceJoint) -> tuple[str, str]:
    """Names of the two sites that a closure holds."""
    name = joint.name if isinstance(joint, Revolute) else joint.link
    return f"{name}.{joint.a}", f"{name}.{joint.b}"
