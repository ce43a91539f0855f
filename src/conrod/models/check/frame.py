"""The frame of a scene's document in a user's model: plane, rotation, origin, crank zero and unit of length."""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np

from conrod.errors import InvalidInput
from conrod.exact.motion import Array
from conrod.mjcf.request import LENGTH_UNITS

# The usual ways to look at a plane, x to the right or y and z up: first and second direction of the picture.
USUAL_VIEWS = {"x": "yz", "y": "xz", "z": "xy"}
UNIT_VECTORS = dict(zip("xyz", np.eye(3), strict=True))
PLANE = re.compile(r"([+-]?)([xyz])([+-]?)([xyz])")
# A crank's axis this close to an axis of the frame is meant to be it.
ALIGNMENT_TOLERANCE = 1e-6


@dataclass(frozen=True)
class PlaneView:
    """A plane of motion seen from one of its sides: unit vectors (3,) to the right and up in the picture.

    Attributes:
        name: the two directions of the plane: xz is x to the right and z up, -xz the same from behind.
        sense: sense of the crank's hinge in this view: +1 if its coordinate grows counter-clockwise.
    """

    name: str
    right: tuple[float, float, float]
    up: tuple[float, float, float]
    sense: int

    def as_complex(self, vectors: Array) -> Array:
        """Project vectors (T, 3) to complex numbers (T,) of the picture."""
        return np.asarray(vectors @ np.array(self.right) + 1j * (vectors @ np.array(self.up)))


@dataclass(frozen=True)
class Frame:
    """Transformation from a model's coordinates to the scene document's.

    Attributes:
        sense: +1 if the crank angle grows with the hinge's coordinate.
        rotation: angle of the document's x axis in the view, counter-clockwise [rad].
        zero: coordinate of the crank at crank angle 0 [rad].
        unit: the model's unit of length [m].
        anchor: a point of the crank's axis, in the model's unit.
        shaft: position of the crank's axis in the document's frame [m].
    """

    view: PlaneView
    sense: int
    rotation: float
    zero: float
    unit: float
    anchor: tuple[float, float, float]
    shaft: tuple[float, float]

    def document_vectors(self, vectors: Array) -> Array:
        """Transform relative positions, velocities or accelerations (T, 3) to the document's frame (T, 2)."""
        flat = self.unit * np.exp(-1j * self.rotation) * self.view.as_complex(vectors)
        return np.column_stack([flat.real, flat.imag])

    def document_positions(self, positions: Array) -> Array:
        """Transform positions (T, 3) to the document's frame (T, 2) [m]."""
        return np.asarray(self.document_vectors(positions - np.array(self.anchor)) + np.array(self.shaft))

    def angle(self, coordinate: Array) -> Array:
        """Crank angles [rad] for coordinates of the crank's hinge."""
        return np.asarray(self.sense * (coordinate - self.zero))

    @property
    def unit_name(self) -> str:
        """Name of the unit of length, as mm."""
        return next((name for name, size in LENGTH_UNITS.items() if size == self.unit), f"{self.unit:g} m")


@dataclass(frozen=True)
class GivenFrame:
    """Parts of the frame that a user gives; None where they are to be fitted."""

    plane: str | None = None
    rotation: float | None = None  # [rad]
    zero: float | None = None  # [rad]
    unit: float | None = None  # [m]


def candidate_views(axis: Array, sense: int, plane: str | None) -> tuple[PlaneView, ...]:
    """Sides to see the plane of motion from, the most likely first.

    A plane is usually seen with x to the right and y or z up; and a hinge's coordinate usually grows with the crank
    angle. Where these are two views, either may be meant. A machine seen from behind is its own mirror image turning
    the other way, which for many a machine is the other assembly branch: so the side must not be free.

    Args:
        sense: sense of the crank angle in the document, +1 for counter-clockwise.
        plane: the view that a user says, which is then the only one.

    Raises:
        InvalidInput: the crank's axis is not across the plane.
    """
    if plane is not None:
        return (_parse_view(plane, axis),)
    usual = _parse_view(USUAL_VIEWS["xyz"[int(np.argmax(np.abs(axis)))]], axis)
    return (usual,) if usual.sense == sense else (usual, _parse_view(f"-{usual.name}", axis))


def _parse_view(plane: str, axis: Array) -> PlaneView:
    """Build a view from its directions to the right and up, as `xz` or `-xz`."""
    parts = PLANE.fullmatch(plane)
    if parts is None or parts[2] == parts[4]:
        raise InvalidInput(f"--plane {plane}: give the directions to the right and up, e.g. xy, xz, yz, or -xz")
    right, up = (
        UNIT_VECTORS[letter] * (-1.0 if sign == "-" else 1.0) for sign, letter in (parts.group(1, 2), parts.group(3, 4))
    )
    across = np.cross(right, up)
    if abs(abs(across @ axis) - 1.0) > ALIGNMENT_TOLERANCE:
        numbers = " ".join(f"{value:.4g}" for value in axis)
        raise InvalidInput(
            f"plane {plane}: the crank's axis ({numbers}) is not across it, so it is not that of the motion"
        )
    a, b, c = right.tolist()
    x, y, z = up.tolist()
    return PlaneView(plane, (a, b, c), (x, y, z), 1 if across @ axis > 0.0 else -1)
