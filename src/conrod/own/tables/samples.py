"""Motion of a table, and its errors against a scene."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TypeAlias

import numpy as np

from conrod.exact.motion import Array, Motion
from conrod.runs.comparison import Size, size_of
from conrod.scenes import Scene

QUANTITIES = ("position", "velocity", "acceleration")
ERRORS = ("total", "position", "velocity", "acceleration")
# More cannot be distinguished in the width of a figure; each span keeps its largest error.
SPANS = 400


@dataclass(frozen=True)
class ErrorCurve:
    """Normalised error over a run.

    Attributes:
        size: max, rms and final value of all samples.
        at: where each span begins (N,), in revolutions since the first row; at most `SPANS`.
        largest: largest error in each span (N,).
    """

    size: Size
    at: Array
    largest: Array


def error_curve(at: Array, error: Array) -> ErrorCurve:
    """The curve of errors (T,) at places (T,) of a run."""
    edges = np.unique(np.linspace(0, len(error), min(SPANS, len(error)) + 1).astype(int))[:-1]
    return ErrorCurve(size_of(error), np.asarray(at[edges]), np.asarray(np.maximum.reduceat(error, edges)))


# By point, then by name in `ERRORS` as far as the table has columns for them; over revolutions since the first row.
Errors: TypeAlias = Mapping[str, Mapping[str, ErrorCurve]]


@dataclass(frozen=True)
class Samples:
    """One quantity of one point; a table may have one of its two components alone.

    Attributes:
        values: (T, c), SI.
        axes: which component each column is, 0 for x and 1 for y.
    """

    values: Array
    axes: tuple[int, ...]


@dataclass(frozen=True)
class Observed:
    """All that a table says.

    Attributes:
        times: (T,) [s], increasing.
        angle, rate, acceleration: of the crank by the table's own account (T,) [rad, rad/s, rad/s^2], None without.
        points: samples by point and quantity (`QUANTITIES`).
    """

    times: Array
    angle: Array | None
    rate: Array | None
    acceleration: Array | None
    points: Mapping[str, Mapping[str, Samples]]

    @property
    def step(self) -> float:
        """Time from row to row [s], the median."""
        return float(np.median(np.diff(self.times)))

    def has(self, quantity: str) -> bool:
        """True if any point has the quantity."""
        return any(quantity in samples for samples in self.points.values())

    def thinned(self, most: int) -> Observed:
        """At most so many rows, evenly spread, the first and the last among them."""
        count = len(self.times)
        if count <= most:
            return self
        keep = np.unique(np.rint(np.linspace(0, count - 1, most)).astype(int))
        rows = self.with_samples(lambda _, samples: replace(samples, values=samples.values[keep]))
        return replace(rows.with_crank(lambda column: column[keep]), times=self.times[keep])

    def with_samples(self, change: Callable[[str, Samples], Samples]) -> Observed:
        """The table with changed samples.

        Args:
            change: makes the new samples from the quantity's name and the old ones.
        """
        points = {
            point: {quantity: change(quantity, samples) for quantity, samples in quantities.items()}
            for point, quantities in self.points.items()
        }
        return replace(self, points=points)

    def with_crank(self, change: Callable[[Array], Array]) -> Observed:
        """The table with changed columns of the crank, as far as it has them."""
        columns = (self.angle, self.rate, self.acceleration)
        angle, rate, acceleration = (None if column is None else change(column) for column in columns)
        return replace(self, angle=angle, rate=rate, acceleration=acceleration)


# -- errors ------------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Exact:
    """The exact motion beside a table: each motion is computed once, for all points and quantities."""

    observed: Observed
    scene: Scene

    @property
    def nominal_angle(self) -> Array:
        """Crank angle at the nominal time (T,) [rad]."""
        return np.asarray(self.scene.speed * self.observed.times)

    @property
    def angle(self) -> Array:
        """Crank angle by the table's own account (T,) [rad]; where it has none, the nominal one."""
        return self.nominal_angle if self.observed.angle is None else self.observed.angle

    @cached_property
    def nominal(self) -> Motion:
        """At the nominal time."""
        return self.scene.motion(self.nominal_angle, self.scene.speed)

    @cached_property
    def reached(self) -> Motion:
        """At the angle, rate and angular acceleration by the table's own account; nominal where it has none."""
        observed = self.observed
        if observed.angle is None and observed.rate is None and observed.acceleration is None:
            return self.nominal
        rate = self.scene.speed if observed.rate is None else observed.rate
        return self.scene.motion(self.angle, rate, 0.0 if observed.acceleration is None else observed.acceleration)

    def difference(self, name: str, point: str) -> Array:
        """Table minus exact (T, c), SI, of the components that it has."""
        quantity = quantity_of(name)
        motion = self.nominal if name == "total" else self.reached
        samples, exact = self.observed.points[point][quantity], getattr(motion.point(point), quantity)
        return np.asarray(samples.values - exact[:, samples.axes])

    @cached_property
    def errors(self) -> Errors:
        """Normalised errors by point, and by name in `ERRORS` as far as the table has columns for them.

        `position`, `velocity` and `acceleration` are taken at the angle, rate and angular acceleration that the
        table's own columns say; where it has none, at the nominal ones, and `position` is then the same as `total`.
        """
        times, scene = self.observed.times, self.scene
        errors: dict[str, dict[str, ErrorCurve]] = {point: {} for point in self.observed.points}
        for point, samples in self.observed.points.items():
            for name in ERRORS:
                if (quantity := quantity_of(name)) in samples:
                    norm = scene.lengths[point] * abs(scene.speed) ** QUANTITIES.index(quantity)
                    sizes = np.linalg.norm(self.difference(name, point), axis=1) / norm
                    errors[point][name] = error_curve((times - times[0]) / scene.period, sizes)
        return errors

    def largest(self, name: str) -> float | None:
        """The largest error of a name over all points; None where no point has it."""
        return largest(self.errors, name)

    @property
    def phase(self) -> float | None:
        """Largest deviation of the table's crank from the nominal one [rad]; None where it has no crank angle."""
        if self.observed.angle is None:
            return None
        # A table may count its angle from 0 to 360 deg again and again, and begin in any turn.
        phase = np.unwrap(self.angle) - self.nominal_angle
        return float(np.abs(phase - 2.0 * np.pi * np.rint(phase[0] / (2.0 * np.pi))).max())


def quantity_of(name: str) -> str:
    """The quantity that an error is of."""
    return "position" if name == "total" else name


def largest(errors: Errors, name: str, measure: str = "max") -> float | None:
    """The largest error of a name over all points; None where no point has it. `measure`: max, rms or final."""
    sizes = [getattr(series[name].size, measure) for series in errors.values() if name in series]
    return max(sizes) if sizes else None
