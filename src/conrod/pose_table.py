"""Exact poses over one turn of the crank, dense where the mechanism moves fast, to start Newton iterations from."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from conrod.motion import Array


@dataclass(frozen=True)
class PoseTable:
    """Poses at increasing crank angles from 0 to 2 pi."""

    angles: Array  # (K,) [rad]
    poses: Array  # (K, 3 n)
    slopes: Array  # (K, 3 n), by the crank angle
    gain: Array  # (3 n,) over the whole turn; zero but for bodies that turn fully

    def interpolate(self, angle: Array) -> Array:
        """Poses (T, 3 n) at any angles, by cubic Hermite interpolation within the turn."""
        turns = np.floor(angle / (2.0 * np.pi))
        within = angle - 2.0 * np.pi * turns
        left = np.clip(np.searchsorted(self.angles, within, side="right") - 1, 0, len(self.angles) - 2)
        width = (self.angles[left + 1] - self.angles[left])[:, None]
        t = (within - self.angles[left])[:, None] / width
        start, stop = self.poses[left], self.poses[left + 1]
        rise = stop - start
        a, b = width * self.slopes[left] - rise, rise - width * self.slopes[left + 1]
        here = start + t * rise + t * (1.0 - t) * ((1.0 - t) * a + t * b)
        return np.asarray(here + turns[:, None] * self.gain)

    def nearest(self, angle: float) -> tuple[float, Array]:
        """The tabulated angle (whole turns added) next to an angle, and the poses (1, 3 n) there."""
        turns = np.floor(angle / (2.0 * np.pi))
        k = int(np.argmin(np.abs(self.angles - (angle - 2.0 * np.pi * turns))))
        return float(self.angles[k] + 2.0 * np.pi * turns), (self.poses[k] + turns * self.gain)[None]

    def with_rows(self, angles: Array, poses: Array, slopes: Array) -> PoseTable:
        """The table with further rows, in order."""
        merged = np.concatenate([self.angles, angles])
        order = np.argsort(merged, kind="stable")
        return PoseTable(
            merged[order],
            np.concatenate([self.poses, poses])[order],
            np.concatenate([self.slopes, slopes])[order],
            self.gain,
        )
