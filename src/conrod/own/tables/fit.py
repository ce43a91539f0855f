"""Residuals of a table against the exact motion in an alignment, with their exact derivatives."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Literal

import numpy as np

from conrod.exact.motion import Array, PointMotion
from conrod.own.tables.samples import Alignment, Observed, Samples
from conrod.scenes import Scene

# What is fitted: positions at the nominal time, positions at the table's own crank angle, or that angle itself.
Kind = Literal["nominal", "reached", "crank"]
TURNING = ("time", "phase", "zero")  # what shifts the crank angle
QUARTER = 0.5 * math.pi


@dataclass(frozen=True)
class Fit:
    """A least-squares problem. Fitted quantities are in units in which each is about one; see `scale`.

    Attributes:
        kind: what is fitted.
    """

    observed: Observed
    scene: Scene
    kind: Kind

    @cached_property
    def positions(self) -> dict[str, Samples]:
        """Samples of position by point."""
        return {name: s["position"] for name, s in self.observed.points.items() if "position" in s}

    @property
    def vectors(self) -> int:
        """Number of errors: each is of one point, or of the crank, in one row."""
        return len(self.observed.times) * (1 if self.kind == "crank" else len(self.positions))

    def thinned(self, most: int) -> Fit:
        """The same with at most so many rows."""
        return replace(self, observed=self.observed.thinned(most))

    def scale(self, name: str) -> float:
        """The unit of a fitted quantity, SI: the time of a radian at nominal speed, the largest L, or a radian."""
        if name == "time":
            return 1.0 / abs(self.scene.speed)
        return max(self.scene.lengths.values()) if name in ("x", "y") else 1.0

    def moved(self, alignment: Alignment, names: Sequence[str], step: Sequence[float] | Array) -> Alignment:
        """An alignment changed by so many units of each quantity."""
        change = {name: float(size) * self.scale(name) for name, size in zip(names, step, strict=True)}
        x, y = alignment.offset
        offset = (x + change.pop("x", 0.0), y + change.pop("y", 0.0))
        return replace(alignment, offset=offset, **{name: getattr(alignment, name) + by for name, by in change.items()})

    def angle(self, alignment: Alignment) -> Array:
        """Crank angles (T,) [rad] at which positions are fitted."""
        at = alignment.nominal if self.kind == "nominal" else alignment.reached
        return at(self.observed, self.scene.speed)

    def linearised(self, alignment: Alignment, names: Sequence[str] = ()) -> tuple[Array, Array]:
        """Residuals (N,), table minus exact, and derivatives of the exact values (N, p).

        Positions are divided by L; the crank angle is in radians.
        """
        if self.kind == "crank":
            reached = np.unwrap(alignment.reached(self.observed, self.scene.speed))
            slopes = [np.full_like(reached, self._turn(alignment, name)) for name in names]
            return reached - alignment.nominal(self.observed, self.scene.speed), _stacked(slopes, len(reached))
        motion = self.scene.motion(self.angle(alignment), 1.0)
        parts = [self._of_point(name, motion.point(name), alignment, names) for name in self.positions]
        return np.concatenate([r for r, _ in parts]), np.concatenate([slopes for _, slopes in parts])

    def _of_point(
        self, name: str, exact: PointMotion, alignment: Alignment, names: Sequence[str]
    ) -> tuple[Array, Array]:
        samples, length = self.positions[name], self.scene.lengths[name]
        off = samples.values - alignment.seen(exact.position, samples, placed=True)
        slopes = [self._slope(which, exact, samples, alignment).ravel() for which in names]
        return off.ravel() / length, _stacked(slopes, off.size) / length

    def _slope(self, name: str, exact: PointMotion, samples: Samples, alignment: Alignment) -> Array:
        if name in TURNING:
            # At a crank speed of 1 rad/s the velocity is the derivative by the angle.
            return self._turn(alignment, name) * alignment.seen(exact.velocity, samples, placed=False)
        if name == "rotation":
            turned = replace(alignment, rotation=alignment.rotation + QUARTER)
            return turned.seen(exact.position, samples, placed=False)
        along = np.array([float(axis == "xy".index(name)) for axis in samples.axes])
        return np.broadcast_to(along * self.scale(name), samples.values.shape)

    def _turn(self, alignment: Alignment, name: str) -> float:
        """Derivative of the crank angle by what shifts it."""
        if name == "time":
            return -alignment.sense * math.copysign(1.0, self.scene.speed)
        return 1.0


def _stacked(columns: Sequence[Array], rows: int) -> Array:
    return np.column_stack(columns) if columns else np.empty((rows, 0))
