"""The states of a run and the motion of its points in one hash, which does not depend on how the run is cut."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator

import numpy as np

from conrod.motion import Array
from conrod.trajectory import Trajectory


class Fingerprint:
    """Of the samples taken in so far.

    Positions, velocities and accelerations need not have the same instants, so each quantity is hashed for itself.
    """

    def __init__(self) -> None:
        self._hashes: dict[str, hashlib._Hash] = {}

    def add(self, trajectory: Trajectory) -> None:
        """Take in the next piece of a run."""
        for name, values in recorded(trajectory):
            self._hashes.setdefault(name, hashlib.sha256()).update(np.ascontiguousarray(values).data)

    def text(self) -> str:
        """In 64 hexadecimal digits."""
        whole = hashlib.sha256()
        for name in sorted(self._hashes):
            whole.update(name.encode() + self._hashes[name].digest())
        return whole.hexdigest()


def recorded(trajectory: Trajectory) -> Iterator[tuple[str, Array]]:
    """The states of the bodies and the motion of the points, by name."""
    assert trajectory.bodies is not None
    states = trajectory.bodies.position
    yield "bodies position", states.poses
    yield "bodies rate", states.rates
    for name, tracks in trajectory.points.items():
        yield f"{name} position", tracks.position.values
        yield f"{name} velocity", tracks.velocity.values
        yield f"{name} acceleration", tracks.acceleration.values
