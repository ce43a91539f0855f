"""A spatial machine whose motion is known in closed form, and its MuJoCo model.

A model consists of links in the reference pose: there every frame of a link is parallel to the world, and every joint
coordinate is 0.
"""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Literal, TypeAlias

import numpy as np

from conrod.exact.jet import Jet, sine_cosine
from conrod.exact.motion import Array

# Links are steel rods without contact; a link without rods is a ball of the same radius.
ROD_RADIUS, STEEL_DENSITY = 0.008, 7800.0  # [m], [kg/m^3]
ORIGIN = np.zeros(3)

# A closed form gives positions (T, 3) [m] of observed points in the world, from coordinates (T, 1) [rad] or [m] of the
# driven joints. The model has a site with the name of each point.
Drives: TypeAlias = Mapping[str, Jet]
ClosedForm: TypeAlias = Callable[[Drives], Mapping[str, Jet]]


@dataclass(frozen=True)
class LinkJoint:
    """A joint between a link and its parent, at the link's origin; a second joint moves with the first."""

    name: str
    axis: Array  # in the world, in the reference pose; of any length
    kind: Literal["hinge", "slide", "ball"] = "hinge"


@dataclass(frozen=True)
class ModelLink:
    """A rigid link; all positions are in the world, in the reference pose [m]."""

    name: str
    origin: Array
    joints: tuple[LinkJoint, ...]
    rods: tuple[Array, ...] = ()  # far ends of straight rods from the origin
    sites: Mapping[str, Array] = field(default_factory=dict)
    links: tuple[ModelLink, ...] = ()  # carried by this one


@dataclass(frozen=True)
class LoopClosure:
    """A constraint that closes a loop: two sites that coincide (connect), or two links (weld)."""

    name: str
    first: str
    second: str
    kind: Literal["connect", "weld"] = "connect"


@dataclass(frozen=True)
class SpatialMachine:
    """A machine as a MuJoCo model, with the motion of the same machine from its parameters alone.

    Attributes:
        links, closures: its model; the reference pose is assembled, on the branch of the closed form.
        drives: law of each driven joint, as text ("60rpm", "sine:20deg,1Hz"); 0 in the reference pose.
    """

    name: str
    title: str
    links: Sequence[ModelLink]
    closures: Sequence[LoopClosure]
    drives: Mapping[str, str]
    closed_form: ClosedForm

    @property
    def mjcf(self) -> str:
        """The complete MuJoCo model as XML: gravity and masses, without contacts."""
        root = ET.Element("mujoco", model=self.name)
        ET.SubElement(root, "compiler", angle="radian")
        ET.SubElement(root, "option", timestep="0.001", gravity="0 0 -9.81")
        geom = {
            "type": "capsule",
            "size": str(ROD_RADIUS),
            "density": str(STEEL_DENSITY),
            "contype": "0",
            "conaffinity": "0",
        }
        ET.SubElement(ET.SubElement(root, "default"), "geom", geom)
        world = ET.SubElement(root, "worldbody")
        for link in self.links:
            _add_link(world, link, ORIGIN)
        equality = ET.SubElement(root, "equality")
        for closure in self.closures:
            part = "site" if closure.kind == "connect" else "body"
            ends = {f"{part}1": closure.first, f"{part}2": closure.second}
            ET.SubElement(equality, closure.kind, {"name": closure.name, **ends})
        ET.indent(root)
        return ET.tostring(root, encoding="unicode") + "\n"

    def points(self, drives: Mapping[str, Array]) -> dict[str, Array]:
        """Positions of the observed points and their derivatives by time, each (K, T, 3) [m, m/s, ...].

        Args:
            drives: coordinate of each driven joint and its derivatives by time, (K, T); K = 1 gives positions alone.
        """
        samples = next(iter(drives.values())).shape[1]
        factors = [math.factorial(k) for k in range(max(map(len, drives.values())))]
        found = self.closed_form(
            {joint: Jet([d[:, None] / f for d, f in zip(rows, factors, strict=True)]) for joint, rows in drives.items()}
        )
        return {
            name: np.stack(
                [
                    np.broadcast_to(f * np.asarray(c), (samples, 3))
                    for f, c in zip(factors, one.coefficients, strict=True)
                ]
            )
            for name, one in found.items()
        }


def reference_pose(closed_form: ClosedForm, driven: Iterable[str]) -> dict[str, Array]:
    """Points (3,) [m] of a closed form at driven coordinates 0, the reference pose of the model."""
    points = closed_form({joint: Jet([np.zeros((1, 1))]) for joint in driven})
    return {name: np.asarray(jet.coefficients[0])[0] for name, jet in points.items()}


def hinge_closure(name: str, pin: Array, axis: Array) -> tuple[dict[str, Array], dict[str, Array], list[LoopClosure]]:
    """Close a hinge at both ends of its pin; return sites of both links and two closures, one row redundant.

    Args:
        pin, axis: the middle of the pin [m], and the vector from there to one end [m].
    """
    ends = {"1": pin + axis, "2": pin - axis}
    pins, eyes = ({f"{name}_{part}_{k}": end for k, end in ends.items()} for part in ("pin", "eye"))
    return pins, eyes, [LoopClosure(f"{name}_{k}", f"{name}_pin_{k}", f"{name}_eye_{k}") for k in ends]


def _add_link(parent: ET.Element, link: ModelLink, parent_origin: Array) -> None:
    """Add a link, its joints, rods, sites and children to an XML element."""
    body = ET.SubElement(parent, "body", name=link.name, pos=_coordinates_text(link.origin - parent_origin))
    for joint in link.joints:
        axis = {} if joint.kind == "ball" else {"axis": _coordinates_text(joint.axis)}
        ET.SubElement(body, "joint", {"name": joint.name, "type": joint.kind, **axis})
    for end in link.rods:
        ET.SubElement(body, "geom", fromto=f"0 0 0 {_coordinates_text(end - link.origin)}")
    if not link.rods:
        ET.SubElement(body, "geom", type="sphere")
    for site, point in link.sites.items():
        ET.SubElement(body, "site", name=site, pos=_coordinates_text(point - link.origin))
    for child in link.links:
        _add_link(body, child, link.origin)


def _coordinates_text(vector: Array) -> str:
    """Coordinates in full precision; values below rounding of a metre are written as 0."""
    return " ".join(repr(round(float(x), 17) + 0.0) for x in vector)


# -- vectors in space that move: a jet of shape (T, 3) is a vector, one of shape (T, 1) a number -----------------------
# A machine's formulas are written once; derivatives of any order follow by the arithmetic of jets.

Vector: TypeAlias = Jet | Array  # moving (T, 3), or fixed (3,)

DEGREE = math.pi / 180.0
X, Y, Z = np.eye(3)


def unit(vector: Array) -> Array:
    """Unit vector along a fixed vector."""
    return np.asarray(vector / np.linalg.norm(vector))


def rotate_fixed(vector: Array, axis: Array, angle: float) -> Array:
    """Rotate a fixed vector about a unit axis by a fixed angle [rad]."""
    return np.asarray(rotate(vector, axis, Jet([np.full(1, angle)])).coefficients[0])


def rotate(vector: Vector, axis: Array, angle: Jet) -> Jet:
    """Rotate a vector about a fixed unit axis by a moving angle [rad] (Rodrigues' formula)."""
    sine, cosine = sine_cosine(angle)
    moving = 0.0 * angle + vector
    along = dot(moving, axis) * axis
    return cosine * (moving - along) - sine * cross(moving, axis) + along


def dot(a: Jet, b: Vector) -> Jet:
    """Inner product (T, 1) of two vectors."""
    return Jet([np.sum(c, axis=-1, keepdims=True) for c in (a * b).coefficients])


def cross(a: Jet, b: Vector) -> Jet:
    """Vector product a x b."""
    return _roll_components(a, 1) * _roll_vector(b, 2) - _roll_components(a, 2) * _roll_vector(b, 1)


def _roll_components(vector: Jet, places: int) -> Jet:
    """Shift the components of a moving vector cyclically."""
    return Jet([np.roll(c, -places, axis=-1) for c in vector.coefficients])


def _roll_vector(vector: Vector, places: int) -> Vector:
    """Shift the components of a moving or fixed vector cyclically."""
    return _roll_components(vector, places) if isinstance(vector, Jet) else np.roll(vector, -places)
