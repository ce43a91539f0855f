"""Hashes of the samples of a run, by which runs are told to be the same bit for bit."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator

import numpy as np

from conrod.comparison.trajectory import Trajectory
from conrod.exact.motion import Array


class Fingerprint:
    """Hash of all samples of a run, independent of how it is cut into pieces.

    Positions, velocities and accelerations may have different instants, so each quantity is hashed separately.
    """

    def __init__(self) -> None:
        self._hashes: dict[str, hashlib._Hash] = {}

    def add(self, trajectory: Trajectory) -> None:
        """Add the next piece of a run."""
        for name, values in recorded_series(trajectory):
            self._hashes.setdefault(name, hashlib.sha256()).update(np.ascontiguousarray(values).data)

    def digest(self) -> str:
        """Return the hash of all quantities, 64 hexadecimal digits."""
        whole = hashlib.sha256()
        for name in sorted(self._hashes):
            whole.update(name.encode() + self._hashes[name].digest())
        return whole.hexdigest()

    def digests(self) -> dict[str, str]:
        """Return the hash of each quantity by name, 16 hexadecimal digits."""
        return {name: found.hexdigest()[:16] for name, found in self._hashes.items()}


def recorded_series(trajectory: Trajectory) -> Iterator[tuple[str, Array]]:
    """Yield names and series: poses and rates of the bodies, motion of the points."""
    assert trajectory.bodies is not None
    states = trajectory.bodies.position
    yield "bodies position", states.poses
    yield "bodies rate", states.rates
    for name, tracks in trajectory.points.items():
        yield f"{name} position", tracks.position.values
        yield f"{name} velocity", tracks.velocity.values
        yield f"{name} acceleration", tracks.acceleration.values
