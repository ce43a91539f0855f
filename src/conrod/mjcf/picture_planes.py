"""The plane or the projection in which points of a machine are drawn."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from conrod.exact.motion import Array

FLAT = 1e-6  # of the largest displacement, that a planar motion leaves its plane by
ALONG_AXIS = 1e-6  # 1 - cosine of the angle of a normal to an axis that it is taken for
NORMALS = {"yz": (1.0, 0.0, 0.0), "xz": (0.0, -1.0, 0.0), "xy": (0.0, 0.0, 1.0)}  # towards the viewer
DIAGONAL = 0.5 * math.cos(math.radians(45.0))
# A cabinet projection: y to the right, z up, x towards the viewer and down at 45 deg, at half its length.
OBLIQUE = ((-DIAGONAL, 1.0, 0.0), (-DIAGONAL, 0.0, 1.0))
OBLIQUE_WORDS = "Oblique projection: y to the right, z up, x towards the viewer at half its length"


@dataclass(frozen=True)
class PictureView:
    """A view of points in space.

    Attributes:
        words: what it shows, in words.
        matrix: directions (2, 3) that are to the right and up in the picture.
    """

    words: str
    matrix: tuple[tuple[float, float, float], tuple[float, float, float]]

    def project(self, places: Array) -> Array:
        """Project places (.., 3) onto the picture (.., 2), y down."""
        return np.asarray(places @ np.array(self.matrix).T * [1.0, -1.0])


def view_of(tracks: Array) -> PictureView:
    """Choose the view of points (T, P, 3): the plane of their motion, or an oblique projection in space."""
    normal = _plane_normal(tracks)
    if normal is None:
        return PictureView(OBLIQUE_WORDS, OBLIQUE)
    for name, axis in NORMALS.items():
        if abs(normal @ np.array(axis)) >= 1.0 - ALONG_AXIS:
            right, up = (_axis(letter) for letter in name)
            return PictureView(f"In the {name} plane", (right, up))
    # Seen from the side from which the axis planes nearest to it are seen.
    nearest = max(NORMALS.values(), key=lambda axis: abs(float(normal @ np.array(axis))))
    normal = normal * np.sign(normal @ np.array(nearest))
    level = np.cross([0.0, 0.0, 1.0], normal)
    level /= np.linalg.norm(level)
    up_there = np.cross(normal, level)
    seen = ", ".join(f"{round(float(value), 3) + 0.0:g}" for value in normal)
    rows = [(float(x), float(y), float(z)) for x, y, z in (level, up_there)]
    return PictureView(f"In the plane of its motion, seen from ({seen})", (rows[0], rows[1]))


def _axis(letter: str) -> tuple[float, float, float]:
    x, y, z = (float(letter == one) for one in "xyz")
    return x, y, z


def _plane_normal(tracks: Array) -> Array | None:
    """Normal (3,) of the plane in which points (T, P, 3) move; None if they move in space."""
    moved = (tracks - tracks[:1]).reshape(-1, 3)
    _, squares, directions = np.linalg.svd(moved.T @ moved)
    sizes = np.sqrt(squares)
    if sizes[1] > FLAT * sizes[0]:
        return np.asarray(directions[2]) if sizes[2] <= FLAT * sizes[0] else None
    # Along a line, or not at all: across the axis in whose direction there is least to see.
    least = "xyz"[int(np.argmin(np.ptp(tracks.reshape(-1, 3), axis=0)))]
    return np.array(next(axis for name, axis in NORMALS.items() if least not in name))
