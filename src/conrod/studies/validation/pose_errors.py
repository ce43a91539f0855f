"""Recorder of how far each body's pose is off, over the last turn of a run: what a moving drawing shows."""

from __future__ import annotations

import math

import numpy as np

from conrod.exact.motion import Array
from conrod.runs.comparison import Stretch
from conrod.scenes import Scene
from conrod.studies.validation.results import PoseErrors

POSES = 60  # of a turn: 6 deg apart


class DrawnPoses:
    """Signed errors of the bodies' poses at the crank angle actually reached, at some samples of the last turn.

    Args:
        turn: steps of a turn.
    """

    def __init__(self, scene: Scene, turn: int) -> None:
        self._scene, self._turn, self._seen = scene, turn, 0
        self._angles: list[Array] = []
        self._errors: list[Array] = []

    def add(self, stretch: Stretch) -> None:
        states = stretch.bodies.position
        count = self._seen + len(states.poses) + stretch.left
        first = max(0, count - 1 - self._turn)
        kept = first + np.unique(np.linspace(0, count - 1 - first, POSES + 1).astype(int)) - self._seen
        rows = kept[(kept >= 0) & (kept < len(states.poses))]
        self._seen += len(states.poses)
        angle = states.instants.angle[rows]
        error = states.poses[rows] - self._scene.kinematics.poses(angle) if len(rows) else states.poses[rows]
        # A body that has turned often is where one is that has not.
        error[:, 2::3] = np.remainder(error[:, 2::3] + math.pi, 2.0 * math.pi) - math.pi
        self._angles.append(angle)
        self._errors.append(error)

    @property
    def errors(self) -> PoseErrors:
        """All that was recorded."""
        return PoseErrors(np.concatenate(self._angles), np.concatenate(self._errors))
