"""State of a tree in a compiled model: one coordinate per joint, or seven of a body that is free in space.

MuJoCo keeps the place and the turn of a free body in the world, as a unit quaternion, its velocity in the world, and
its spin in its own frame (MuJoCo documentation, Computation, 'General framework'). Imports no engine.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from conrod.engines.tree import Tree
from conrod.exact.motion import Array


@dataclass(frozen=True)
class Coordinates:
    """Of the bodies that the engine has; poses and rates are theirs, (T, 3 m).

    Attributes:
        places: of each branch of the tree, the first of its coordinates.
        rate_places: the first of its rates.
        free: whether its body is free in space.
        sizes: numbers of all coordinates and of all rates.
    """

    tree: Tree
    places: tuple[int, ...]
    rate_places: tuple[int, ...]
    free: tuple[bool, ...]
    sizes: tuple[int, int]

    def of_poses(self, poses: Array) -> Array:
        """Coordinates (T, nq)."""
        found = np.zeros((len(poses), self.sizes[0]))
        for k, column in enumerate(self.tree.coordinates(poses).T):
            place = self.places[k]
            if self.free[k]:
                pose = poses[:, self._columns(k)]
                found[:, place : place + 2] = pose[:, :2]
                found[:, place + 3], found[:, place + 6] = np.cos(0.5 * pose[:, 2]), np.sin(0.5 * pose[:, 2])
            else:
                found[:, place] = column
        return found

    def of_rates(self, poses: Array, rates: Array) -> Array:
        """Rates (T, nv)."""
        found = np.zeros((len(poses), self.sizes[1]))
        for k, column in enumerate(self.tree.rates(poses, rates).T):
            place = self.rate_places[k]
            if self.free[k]:
                found[:, [place, place + 1, place + 5]] = rates[:, self._columns(k)]
            else:
                found[:, place] = column
        return found

    def forward(self, coordinates: Array, rates: Array, after: Array | None = None) -> tuple[Array, Array]:
        """Poses and their rates.

        Args:
            after: poses (3 m,) that these follow in a run told in pieces; None at its beginning.
        """
        known = {self.tree.branches[k].child: self._free_body(k, coordinates, rates, after) for k in self._free_ones}
        return self.tree.forward(coordinates[:, self.places], rates[:, self.rate_places], known)

    def _free_body(self, k: int, coordinates: Array, rates: Array, after: Array | None) -> tuple[Array, Array]:
        """Pose and rates (T, 3) in the plane; the first turn within half a turn of the one before, or of the start."""
        place, rate = self.places[k], self.rate_places[k]
        near = (self.tree.start if after is None else after)[self._columns(k)][2]
        turn = 2.0 * np.arctan2(coordinates[:, place + 6], coordinates[:, place + 3])
        # Whole turns are counted, so that the same comes of it wherever a run is cut.
        turn = turn - 2.0 * np.pi * np.cumsum(np.rint(np.diff(turn, prepend=near) / (2.0 * np.pi)))
        pose = np.column_stack([coordinates[:, place : place + 2], turn])
        return pose, rates[:, [rate, rate + 1, rate + 5]]

    @property
    def _free_ones(self) -> list[int]:
        return [k for k, free in enumerate(self.free) if free]

    def _columns(self, k: int) -> slice:
        i = 3 * self.tree.mechanism.body_index[self.tree.branches[k].child]
        return slice(i, i + 3)
