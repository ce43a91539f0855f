"""Errors of a table against the exact motion, as docs/design.md names them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TypeAlias

import numpy as np

from conrod.exact.motion import Array, Motion
from conrod.own.error_curve import ErrorCurve, error_curve
from conrod.own.tables.samples import QUANTITIES, Alignment, Observed
from conrod.scenes import Scene

ERRORS = ("total", "position", "velocity", "acceleration")
# By point, then by name in `ERRORS` as far as the table has columns for them; over revolutions since the first row.
Errors: TypeAlias = Mapping[str, Mapping[str, ErrorCurve]]


@dataclass(frozen=True)
class Crank:
    """The crank by a table's own account.

    Attributes:
        phase_max, phase_final: of its angle minus the nominal one, in size [rad].
        speed: largest |rate / nominal rate - 1|, None where the table has no rate.
        acceleration: largest |angular acceleration| / omega^2, None where it has none.
    """

    phase_max: float
    phase_final: float
    speed: float | None
    acceleration: float | None


@dataclass(frozen=True)
class Exact:
    """The exact motion beside a table: each motion is computed once, for all points and quantities."""

    observed: Observed
    scene: Scene
    alignment: Alignment

    @cached_property
    def nominal(self) -> Motion:
        """At the nominal time."""
        angle = self.alignment.nominal(self.observed, self.scene.speed)
        return self.scene.motion(angle, self.alignment.sense * self.scene.speed)

    @cached_property
    def reached(self) -> Motion:
        """At the angle, rate and angular acceleration by the table's own account."""
        observed = self.observed
        if observed.angle is None and observed.rate is None and observed.acceleration is None:
            return self.nominal
        angle = self.alignment.reached(observed, self.scene.speed)
        rate, acceleration = self.alignment.rate(observed, self.scene.speed), self.alignment.acceleration(observed)
        return self.scene.motion(angle, rate, acceleration)

    def motion(self, name: str) -> Motion:
        """The motion that an error is taken against."""
        return self.nominal if name == "total" else self.reached

    def difference(self, name: str, point: str) -> Array:
        """Table minus exact (T, c), SI, in the table's frame."""
        quantity = quantity_of(name)
        samples = self.observed.points[point][quantity]
        exact: Array = getattr(self.motion(name).point(point), quantity)
        return samples.values - self.alignment.seen(exact, samples, placed=quantity == "position")


def quantity_of(name: str) -> str:
    """The quantity that an error is of."""
    return "position" if name == "total" else name


def table_errors(observed: Observed, scene: Scene, alignment: Alignment) -> Errors:
    """Normalised errors by point, and by name in `ERRORS` as far as the table has columns for them.

    `position`, `velocity` and `acceleration` are taken at the angle, rate and angular acceleration that the table's
    own columns say; where it has none, at the nominal ones, and `position` is then the same as `total`.
    """
    exact, revolutions = Exact(observed, scene, alignment), (observed.times - observed.times[0]) / scene.period
    errors: dict[str, dict[str, ErrorCurve]] = {point: {} for point in observed.points}
    for point, samples in observed.points.items():
        for name in ERRORS:
            if (quantity := quantity_of(name)) in samples:
                norm = scene.lengths[point] * abs(scene.speed) ** QUANTITIES.index(quantity)
                sizes = np.linalg.norm(exact.difference(name, point), axis=1) / norm
                errors[point][name] = error_curve(revolutions, sizes)
    return errors


def largest(errors: Errors, name: str, measure: str = "max") -> float | None:
    """The largest error of a name over all points; None where no point has it. `measure`: max, rms or final."""
    sizes = [getattr(series[name].size, measure) for series in errors.values() if name in series]
    return max(sizes) if sizes else None


def crank_of(observed: Observed, scene: Scene, alignment: Alignment) -> Crank | None:
    """Deviation of the table's crank from the nominal one; None where the table has no crank angle."""
    if observed.angle is None:
        return None
    # A table may count its angle from 0 to 360 deg again and again, and begin in any turn.
    angle = np.unwrap(alignment.reached(observed, scene.speed))
    phase = angle - alignment.nominal(observed, scene.speed)
    phase = phase - 2.0 * np.pi * np.rint(phase[0] / (2.0 * np.pi))
    speed = alignment.sense * scene.speed
    rate, acceleration = alignment.rate(observed, scene.speed), alignment.acceleration(observed)
    return Crank(
        float(np.abs(phase).max()),
        float(abs(phase[-1])),
        None if observed.rate is None else float(np.abs(rate / speed - 1.0).max()),
        None if observed.acceleration is None else float(np.abs(acceleration).max()) / speed**2,
    )
