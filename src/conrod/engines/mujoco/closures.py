"""Closures of the loops of a tree as MJCF, with the elements and numbers that all of it is written with.

Imports no engine.
A cut pin is an equality `connect` of two sites. A rolling pair is a fixed tendon, a linear combination of joint
coordinates, that an equality keeps at its length of the compiled pose, which is exact: where a pair's equation is
linear the engine has it exactly.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET

from conrod.engines.mujoco.settings import MuJoCoSettings
from conrod.engines.tree import Branch, Tree, mesh_row
from conrod.mechanism.mechanism import Point, Revolute


def add(parent: ET.Element, tag: str, **attributes: str) -> ET.Element:
    """A new last child of an element."""
    return ET.SubElement(parent, tag, attributes)


def section(root: ET.Element, tag: str) -> ET.Element:
    """A section of the model, made where it is missing."""
    found = root.find(tag)
    return add(root, tag) if found is None else found


def clean(value: float) -> float:
    """Zero for what is zero but for rounding."""
    return 0.0 if abs(value) < 1e-15 else value


def number(value: float) -> str:
    """The shortest text that reads back as the same number."""
    value = clean(float(value))
    texts = (f"{value:.6g}", f"{value:.15g}", repr(value))
    return next(text for text in texts if float(text) == value)


def numbers(values: list[float] | tuple[float, ...]) -> str:
    """Numbers separated by blanks, each exact."""
    return " ".join(number(v) for v in values)


def short(value: float) -> str:
    """Four digits: enough for what is only looked at."""
    return f"{clean(value):.4g}"


def add_closures(root: ET.Element, tree: Tree, settings: MuJoCoSettings) -> None:
    """Equalities of all loops, with the tendons that they hold."""
    meshes = tree.mechanism.meshes
    if not tree.cuts and not meshes:
        return
    if meshes:
        tendons = add(root, "tendon")
        for mesh in meshes:
            tendon = add(tendons, "fixed", name=mesh.name)
            for branch, coefficient in zip(tree.branches, mesh_row(tree, mesh), strict=True):
                if coefficient != 0.0:
                    add(tendon, "joint", joint=joint_name(tree, branch), coef=number(coefficient))
    equality = add(root, "equality")
    stiffness = {"solref": numbers(settings.solref), "solimp": numbers(settings.solimp)}
    for joint in tree.cuts:
        first, second = _sites(joint)
        add(equality, "connect", name=joint.name, site1=first, site2=second, **stiffness)
    for mesh in meshes:
        add(equality, "tendon", name=mesh.name, tendon1=mesh.name, **stiffness)


def joint_name(tree: Tree, branch: Branch) -> str:
    """Name of a branch's joint in the model: the driven one is the crank."""
    return "crank" if branch.joint.name == tree.mechanism.driver.joint else branch.joint.name


def closure_points(body: str, tree: Tree) -> list[tuple[str, Point]]:
    """Names and places of the sites of a body that closures hold."""
    points = []
    for joint in tree.cuts:
        ends = ((joint.a, joint.point_a), (joint.b, joint.point_b))
        points += [(site, point) for site, (holder, point) in zip(_sites(joint), ends, strict=True) if holder == body]
    return points


def _sites(joint: Revolute) -> tuple[str, str]:
    """Names of the two sites that a closure holds."""
    return f"{joint.name}.{joint.a}", f"{joint.name}.{joint.b}"
