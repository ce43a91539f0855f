"""Parts of an MJCF model for the eye: geoms without mass that cannot collide, a camera, a light."""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET
from itertools import pairwise

import numpy as np

from conrod.engines.mujoco.closures import add, numbers, short
from conrod.engines.tree import Tree
from conrod.mechanism.mechanism import GROUND, Mesh, Prismatic, Revolute, Rolling, pins_of

# MuJoCo refuses a bar between two pins of one place, as a crank has whose arc is about its own axis.
LEAST_BAR = 1e-3  # of its width

SEEN_ONLY = {"contype": "0", "conaffinity": "0", "mass": "0", "group": "1"}


def _extent(tree: Tree) -> tuple[float, float, float]:
    """Middle and size of the machine in its start pose, with room for the turning crank."""
    points = [tree.start_pose(body.name)[:2] for body in tree.mechanism.bodies]
    for branch in tree.branches:
        if isinstance(branch.joint, Revolute):
            points.append(np.array(branch.joint.point_a) if branch.joint.a == GROUND else np.zeros(2))
    low, high = np.min(points, axis=0), np.max(points, axis=0)
    middle = 0.5 * (low + high)
    return float(middle[0]), float(middle[1]), float(max(np.max(high - low), 0.15))


def link_width(tree: Tree) -> float:
    """Radius of the bars that links are drawn with [m]."""
    return 0.03 * _extent(tree)[2]


def add_looks(root: ET.Element, tree: Tree) -> None:
    """Sky, lighting and the part of space that viewers start from."""
    x, y, size = _extent(tree)
    add(root, "statistic", center=numbers([x, y, 0.0]), extent=short(size))
    visual = add(root, "visual")
    add(visual, "global", offwidth="1280", offheight="960")
    add(visual, "headlight", ambient="0.45 0.45 0.45", diffuse="0.35 0.35 0.35", specular="0 0 0")
    asset = add(root, "asset")
    add(asset, "texture", type="skybox", builtin="gradient", rgb1="1 1 1", rgb2="0.8 0.85 0.9", width="64", height="64")


def add_camera(world: ET.Element, tree: Tree) -> None:
    """A camera that sees the plane of motion, and a light."""
    x, y, size = _extent(tree)
    place = " ".join(short(v) for v in (x, y, 2.2 * size))
    add(world, "camera", name="front", pos=place)
    add(world, "light", pos=place, dir="0.3 -0.3 -1", directional="true", diffuse="0.4 0.4 0.4", castshadow="false")


def add_link_geoms(element: ET.Element, body: str, tree: Tree) -> None:
    """A bar between the joints of a link, a disc at every pin, a block for a slider. None of them can collide."""
    width = link_width(tree)
    pins = pins_of(tree.mechanism, body)
    if body == GROUND:
        pins = []
    for first, second in pairwise(pins):
        if math.dist(first, second) < LEAST_BAR * width:
            continue
        ends = numbers([*first, 0.0, *second, 0.0])
        add(element, "geom", type="capsule", fromto=ends, size=short(width), rgba="0.35 0.5 0.65 1", **SEEN_ONLY)
    for joint in tree.mechanism.joints:
        if isinstance(joint, Prismatic) and joint.b == body:
            _add_slider_geom(element, joint, width, tree)
    for mesh in tree.mechanism.meshes:
        _add_wheel_geoms(element, body, mesh, width)
    for pin in pins:
        size = f"{short(1.3 * width)} {short(1.6 * width)}"
        place = numbers([*pin, 0.0])
        add(element, "geom", type="cylinder", pos=place, size=size, rgba="0.2 0.2 0.2 1", **SEEN_ONLY)


def _add_wheel_geoms(element: ET.Element, body: str, mesh: Mesh, width: float) -> None:
    """A disc for each wheel of a rolling pair, with a dot that shows its turn; a ring and a rack stay unseen."""
    wheels = [(mesh.a, mesh.point_a, mesh.radius_a if isinstance(mesh, Rolling) else mesh.radius)]
    if isinstance(mesh, Rolling):
        wheels.append((mesh.b, mesh.point_b, mesh.radius_b))
    for wheel, centre, radius in wheels:
        if wheel == body and radius > 0.0 and wheel != GROUND:
            places = (
                (centre, radius, 0.5 * width),
                ((centre[0] + 0.8 * radius, centre[1]), 0.08 * radius, 0.6 * width),
            )
            for place, size, thickness in places:
                sizes, at = f"{short(size)} {short(thickness)}", numbers([*place, 0.0])
                add(element, "geom", type="cylinder", pos=at, size=sizes, rgba="0.75 0.6 0.35 1", **SEEN_ONLY)


def _add_slider_geom(element: ET.Element, joint: Prismatic, width: float, tree: Tree) -> None:
    """A block; for a follower a stem, away from the cam."""
    grey = "0.6 0.6 0.6 1"
    if not any(contact.b == joint.b for contact in tree.mechanism.cam_contacts):
        size = " ".join(short(v * width) for v in (3.0, 3.0, 1.0))
        add(element, "geom", type="box", size=size, rgba=grey, **SEEN_ONLY)
        return
    direction, reach = joint.direction - joint.angle, 10.0 * width
    tip = f"{short(reach * math.cos(direction))} {short(reach * math.sin(direction))} 0"
    add(element, "geom", type="capsule", fromto=f"0 0 0 {tip}", size=short(width), rgba=grey, **SEEN_ONLY)
