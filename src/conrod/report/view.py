"""What the parts of a drawing of a mechanism share."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes

from conrod.mechanism import GROUND, Mechanism, Point, Pose, to_world
from conrod.motion import Array
from conrod.report.room import Room

MM = 1e3


@dataclass(frozen=True)
class View:
    """A mechanism at a crank angle, to be drawn; lengths in mm.

    Attributes:
        axes: what it is drawn on.
        poses: of the bodies and the ground, x and y in mm.
        turn: stacked poses over a turn or a pass, (T, 3 n) [m, m, rad].
        paths: of the observed points over a turn or a pass, (T, 2).
        size: of a symbol.
        extent: of the mechanism.
        room: texts and lines that are drawn already.
    """

    axes: Axes
    mechanism: Mechanism
    poses: dict[str, Pose]
    turn: Array
    paths: dict[str, Array]
    size: float
    extent: float
    room: Room

    def place(self, body: str, point: Point) -> Array:
        """A point of a body, given in its own frame [m], in the drawing; (2,) [mm]."""
        return np.array(to_world(self.poses[body], (MM * point[0], MM * point[1])))

    @property
    def in_metres(self) -> dict[str, Pose]:
        """Poses of the bodies and the ground [m, m, rad]."""
        return {name: (x / MM, y / MM, phi) for name, (x, y, phi) in self.poses.items()}

    def poses_over_turn(self, body: str) -> Array:
        """Poses of a body or the ground over a turn or a pass, (T, 3) [m, m, rad]."""
        if body == GROUND:
            return np.zeros((len(self.turn), 3))
        k = self.mechanism.body_index[body]
        return self.turn[:, 3 * k : 3 * k + 3]
