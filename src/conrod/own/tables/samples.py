"""Motion of a table, how its clock, crank and frame stand to those of a scene, and its errors."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TypeAlias

import numpy as np

from conrod.exact.motion import Array, Motion
from conrod.own.error_curve import ErrorCurve, error_curve
from conrod.scenes import Scene

QUANTITIES = ("position", "velocity", "acceleration")
ERRORS = ("total", "position", "velocity", "acceleration")
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

    @property
    def whole(self) -> bool:
        """True if both components are given."""
        return len(self.axes) == 2


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


@dataclass(frozen=True)
class Alignment:
    """Position of a table's clock, crank and frame against the scene's. The default is: none of them differs.

    Attributes:
        time: the table's clock minus the scene's [s].
        phase: crank angle at the scene's time 0 [rad].
        zero: crank angle where the table's own crank angle is 0 [rad].
        sense: +1, or -1 where the table's crank turns the other way.
        offset: place of the scene's origin in the table's frame [m].
        rotation: turn of the scene's axes in the table's frame [rad].
    """

    time: float = 0.0
    phase: float = 0.0
    zero: float = 0.0
    sense: int = 1
    offset: tuple[float, float] = (0.0, 0.0)
    rotation: float = 0.0

    def nominal(self, observed: Observed, speed: float) -> Array:
        """Crank angle at the nominal time (T,) [rad]."""
        return np.asarray(self.sense * speed * (observed.times - self.time) + self.phase)

    def reached(self, observed: Observed, speed: float) -> Array:
        """Crank angle by the table's own account (T,) [rad]; where it has none, the nominal one."""
        if observed.angle is None:
            return self.nominal(observed, speed)
        return np.asarray(self.sense * observed.angle + self.zero)

    def rate(self, observed: Observed, speed: float) -> Array | float:
        """Crank speed by the table's own account [rad/s]; the nominal one where it has none."""
        return self.sense * (speed if observed.rate is None else observed.rate)

    def acceleration(self, observed: Observed) -> Array | float:
        """Angular acceleration of the crank by the table's own account [rad/s^2]; 0 where it has none."""
        return 0.0 if observed.acceleration is None else self.sense * observed.acceleration

    def seen(self, vectors: Array, samples: Samples, placed: bool) -> Array:
        """Vectors of the scene (T, 2) as the table's frame has them, in the components (T, c) that it has.

        Args:
            placed: whether they are positions, which a frame's offset moves too.
        """
        c, s = math.cos(self.rotation), math.sin(self.rotation)
        x, y = vectors[:, 0], vectors[:, 1]
        components = (c * x - s * y, s * x + c * y)
        return np.column_stack([components[axis] + (self.offset[axis] if placed else 0.0) for axis in samples.axes])


# -- errors ------------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Crank:
    """The crank by a table's own account.

    Attributes:
        phase_max, phase_final: of its angle minus the nominal one, in size [rad].
        speed: largest |rate / nominal rate - 1|, None where the table has no rate.
    """

    phase_max: float
    phase_final: float
    speed: float | None


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
    def crank(self) -> Crank | None:
        """Deviation of the table's crank from the nominal one; None where the table has no crank angle."""
        observed, alignment, nominal = self.observed, self.alignment, self.scene.speed
        if observed.angle is None:
            return None
        # A table may count its angle from 0 to 360 deg again and again, and begin in any turn.
        phase = np.unwrap(alignment.reached(observed, nominal)) - alignment.nominal(observed, nominal)
        phase = phase - 2.0 * np.pi * np.rint(phase[0] / (2.0 * np.pi))
        rate, speed = alignment.rate(observed, nominal), alignment.sense * nominal
        return Crank(
            float(np.abs(phase).max()),
            float(abs(phase[-1])),
            None if observed.rate is None else float(np.abs(rate / speed - 1.0).max()),
        )


def quantity_of(name: str) -> str:
    """The quantity that an error is of."""
    return "position" if name == "total" else name


def largest(errors: Errors, name: str, measure: str = "max") -> float | None:
    """The largest error of a name over all points; None where no point has it. `measure`: max, rms or final."""
    sizes = [getattr(series[name].size, measure) for series in errors.values() if name in series]
    return max(sizes) if sizes else None
