"""Exact poses over a turn of the crank or a stretch, dense where the mechanism moves fast: where Newton starts from."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from conrod.exact.motion import Array


@dataclass(frozen=True)
class PoseTable:
    """Poses at increasing crank angles: from 0 to 2 pi, or over the stretch that an input without full turns makes."""

    angles: Array  # (K,) [rad]
    poses: Array  # (K, 3 n)
    slopes: Array  # (K, 3 n), by the crank angle
    gain: Array | None  # (3 n,) over the whole turn; zero but for bodies that turn; None where poses do not repeat

    def interpolate(self, angle: Array) -> Array:
        """Poses (T, 3 n) at any angles, or of the stretch, by cubic Hermite interpolation within the turn."""
        turns = self._turns(angle)
        within = angle - 2.0 * np.pi * turns
        left = np.clip(np.searchsorted(self.angles, within, side="right") - 1, 0, len(self.angles) - 2)
        width = (self.angles[left + 1] - self.angles[left])[:, None]
        t = (within - self.angles[left])[:, None] / width
        start, stop = self.poses[left], self.poses[left + 1]
        rise = stop - start
        a, b = width * self.slopes[left] - rise, rise - width * self.slopes[left + 1]
        here = start + t * rise + t * (1.0 - t) * ((1.0 - t) * a + t * b)
        return here if self.gain is None else np.asarray(here + turns[:, None] * self.gain)

    def _turns(self, angle: Array) -> Array:
        """Whole turns that angles are beyond those of the table."""
        return np.zeros_like(angle) if self.gain is None else np.floor(angle / (2.0 * np.pi))

    def covers(self, angle: Array) -> Array:
        """True (T,) for angles that the table has poses of."""
        within = angle - 2.0 * np.pi * self._turns(angle)
        return np.asarray((within >= self.angles[0]) & (within <= self.angles[-1]))

    def nearest(self, angle: float) -> tuple[float, Array]:
        """The tabulated angle (whole turns added) next to an angle, and the poses (1, 3 n) there."""
        turns = float(self._turns(np.array([angle]))[0])
        k = int(np.argmin(np.abs(self.angles - (angle - 2.0 * np.pi * turns))))
        poses = self.poses[k] if self.gain is None else self.poses[k] + turns * self.gain
        return float(self.angles[k] + 2.0 * np.pi * turns), poses[None]

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
