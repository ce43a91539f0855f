"""MJCF text of a spatial machine, from its links as they stand in the reference pose.

Every frame of a link is parallel to the world in that pose, and every joint coordinate 0.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from conrod.exact.motion import Array

# Links are steel rods that touch nothing; what turns in the middle of a joint is a ball of the same radius.
RADIUS, DENSITY = 0.008, 7800.0  # [m], [kg/m^3]
ORIGIN = np.zeros(3)


@dataclass(frozen=True)
class Joint:
    """A joint between a link and its parent, at the link's origin; the second of two turns with the first."""

    name: str
    axis: Array  # in the world, in the reference pose; of any length
    kind: Literal["hinge", "slide", "ball"] = "hinge"


@dataclass(frozen=True)
class Link:
    """A rigid body: all positions are in the world, in the reference pose [m]."""

    name: str
    origin: Array
    joints: tuple[Joint, ...]
    rods: tuple[Array, ...] = ()  # far ends of straight rods from the origin
    sites: Mapping[str, Array] = field(default_factory=dict)
    links: tuple[Link, ...] = ()  # carried by this one


@dataclass(frozen=True)
class Closure:
    """What closes a loop: two sites that coincide (connect), or two links that are one (weld)."""

    name: str
    first: str
    second: str
    kind: Literal["connect", "weld"] = "connect"


def hinge_closure(name: str, pin: Array, axis: Array) -> tuple[dict[str, Array], dict[str, Array], list[Closure]]:
    """A hinge held at both ends of its pin: sites of the one link, sites of the other, closures; one row is redundant.

    Args:
        pin, axis: the middle [m], and from there to one end [m].
    """
    ends = {"1": pin + axis, "2": pin - axis}
    pins, eyes = ({f"{name}_{part}_{k}": end for k, end in ends.items()} for part in ("pin", "eye"))
    return pins, eyes, [Closure(f"{name}_{k}", f"{name}_pin_{k}", f"{name}_eye_{k}") for k in ends]


def model_text(name: str, links: Iterable[Link], closures: Iterable[Closure]) -> str:
    """The model as MJCF, with gravity, masses and no contacts."""
    root = ET.Element("mujoco", model=name)
    ET.SubElement(root, "compiler", angle="radian")
    ET.SubElement(root, "option", timestep="0.001", gravity="0 0 -9.81")
    geom = {"type": "capsule", "size": str(RADIUS), "density": str(DENSITY), "contype": "0", "conaffinity": "0"}
    ET.SubElement(ET.SubElement(root, "default"), "geom", geom)
    world = ET.SubElement(root, "worldbody")
    for link in links:
        _write(world, link, ORIGIN)
    equality = ET.SubElement(root, "equality")
    for closure in closures:
        part = "site" if closure.kind == "connect" else "body"
        ends = {f"{part}1": closure.first, f"{part}2": closure.second}
        ET.SubElement(equality, closure.kind, {"name": closure.name, **ends})
    ET.indent(root)
    return ET.tostring(root, encoding="unicode") + "\n"


def _write(parent: ET.Element, link: Link, parent_origin: Array) -> None:
    body = ET.SubElement(parent, "body", name=link.name, pos=_text(link.origin - parent_origin))
    for joint in link.joints:
        axis = {} if joint.kind == "ball" else {"axis": _text(joint.axis)}
        ET.SubElement(body, "joint", {"name": joint.name, "type": joint.kind, **axis})
    for end in link.rods:
        ET.SubElement(body, "geom", fromto=f"0 0 0 {_text(end - link.origin)}")
    if not link.rods:
        ET.SubElement(body, "geom", type="sphere")
    for site, point in link.sites.items():
        ET.SubElement(body, "site", name=site, pos=_text(point - link.origin))
    for child in link.links:
        _write(body, child, link.origin)


def _text(vector: Array) -> str:
    """Coordinates to the last digit; what is below rounding of a metre is 0."""
    return " ".join(repr(round(float(x), 17) + 0.0) for x in vector)
