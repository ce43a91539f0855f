"""Errors of a table's motion against a scene."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TypeAlias

import numpy as np

from conrod.exact.motion import Array, Motion
from conrod.own.tables.columns import AXES, CRANK, CRANK_ACCELERATION, CRANK_ANGLE, CRANK_SPEED, MOTION, TIME
from conrod.runs.comparison import Size, size_of
from conrod.scenes import Scene

# Name of an error -> the quantity that it is of.
ERRORS = {"total": "position"} | dict(zip(MOTION, MOTION, strict=True))
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


# By point, then by name in `ERRORS` as far as the table has columns for them; over revolutions since the first row.
Errors: TypeAlias = Mapping[str, Mapping[str, ErrorCurve]]


@dataclass(frozen=True)
class Exact:
    """The exact motion beside a table: each motion is computed once, for all points and quantities.

    Attributes:
        values: what the table says, SI: an array (T,) by quantity, of those in `columns.quantities` that it has; times
            increase.
        turn: by which the crank is taken to be further on, (T,) or for all rows [rad].
    """

    values: Mapping[str, Array]
    scene: Scene
    turn: float | Array = 0.0

    def changed(self, change: Callable[[Array], Array], *names: str) -> Exact:
        """The table with changed columns, of those names that it has."""
        return replace(self, values={n: change(v) if n in names else v for n, v in self.values.items()})

    def scaled(self, by: float, *names: str) -> Exact:
        """The table with columns so many times as large."""
        return self.changed(lambda column: by * column, *names)

    def thinned(self, most: int) -> Exact:
        """At most so many rows, evenly spread, the first and the last among them."""
        count = len(self.times)
        if count <= most:
            return self
        keep = np.unique(np.rint(np.linspace(0, count - 1, most)).astype(int))
        return self.changed(lambda column: column[keep], *self.values)

    def later(self, by: float | Array) -> Exact:
        """The table with all its rows so much later [s], the crank as far on as it turns in that time."""
        turn = self.values.get(CRANK_SPEED, self.scene.speed) * by
        return self.changed(lambda times: times + by, TIME).changed(lambda angle: angle + turn, CRANK_ANGLE)

    # -- the clock and the crank ---------------------------------------------------------------------------------------

    @property
    def times(self) -> Array:
        """(T,) [s], increasing."""
        return self.values[TIME]

    @property
    def nominal_angle(self) -> Array:
        """Crank angle at the nominal time (T,) [rad]."""
        return np.asarray(self.scene.speed * self.times + self.turn)

    @property
    def angle(self) -> Array:
        """Crank angle by the table's own account (T,) [rad]; where it has none, the nominal one."""
        own = self.values.get(CRANK_ANGLE)
        return self.nominal_angle if own is None else own + self.turn

    @property
    def phases(self) -> Array:
        """Deviation of the table's crank from the nominal one (T,) [rad].

        A table may count its angle from 0 to 360 deg again and again, and begin in any turn. Jumps by a turn are taken
        out of the deviation, not of the angle: where rows are missing the crank itself may have turned by more than
        half a turn.
        """
        phase = np.unwrap(self.angle - self.nominal_angle)
        return np.asarray(phase - 2.0 * np.pi * np.rint(phase[0] / (2.0 * np.pi)))

    @property
    def phase(self) -> float | None:
        """Largest deviation of the table's crank from the nominal one [rad]; None where it has no crank angle."""
        return float(np.abs(self.phases).max()) if CRANK_ANGLE in self.values else None

    @cached_property
    def nominal(self) -> Motion:
        """At the nominal time."""
        return self.scene.motion(self.nominal_angle, self.scene.speed)

    @cached_property
    def reached(self) -> Motion:
        """At the angle, rate and angular acceleration by the table's own account; nominal where it has none."""
        if not CRANK.keys() & self.values.keys():
            return self.nominal
        rate = self.values.get(CRANK_SPEED, self.scene.speed)
        return self.scene.motion(self.angle, rate, self.values.get(CRANK_ACCELERATION, 0.0))

    # -- errors --------------------------------------------------------------------------------------------------------

    def axes(self, name: str, point: str) -> dict[int, str]:
        """Columns of the components, 0 for x and 1 for y, that the table has of what an error is of."""
        letter, _ = MOTION[ERRORS[name]]
        columns = {k: f"{point}.{letter}{axis}" for k, axis in enumerate(AXES)}
        return {k: column for k, column in columns.items() if column in self.values}

    def points(self, name: str) -> list[str]:
        """Observed points that the table has what an error is of; it may be one of the two components alone."""
        return [point for point in self.scene.lengths if self.axes(name, point)]

    def difference(self, name: str, point: str) -> Array:
        """Table minus exact (T, c), SI, of the components that it has."""
        axes, motion = self.axes(name, point), self.nominal if name == "total" else self.reached
        exact = getattr(motion.point(point), ERRORS[name])
        return np.asarray(np.column_stack([self.values[column] for column in axes.values()]) - exact[:, list(axes)])

    def norm(self, name: str, point: str) -> float:
        """What an error is divided by: L, omega L or omega^2 L."""
        return self.scene.lengths[point] * abs(self.scene.speed) ** list(MOTION).index(ERRORS[name])

    def misses(self, name: str) -> Array:
        """Table minus exact, normalised, of all components of all points (T, c)."""
        return np.column_stack([self.difference(name, p) / self.norm(name, p) for p in self.points(name)])

    def slopes(self, name: str) -> Array:
        """Derivatives of those of positions by the crank angle (T, c)."""
        motion = self.scene.motion(self.nominal_angle if name == "total" else self.angle, 1.0)
        axes = {p: list(self.axes(name, p)) for p in self.points(name)}
        return -np.column_stack([motion.point(p).velocity[:, axes[p]] / self.norm(name, p) for p in axes])

    @cached_property
    def sizes(self) -> dict[str, dict[str, Array]]:
        """Normalised errors (T,) by name in `ERRORS` and by point, as far as the table has columns for them.

        `position`, `velocity` and `acceleration` are taken at the angle, rate and angular acceleration that the
        table's own columns say; where it has none, at the nominal ones, and `position` is then the same as `total`.
        """
        return {
            name: {p: np.linalg.norm(self.difference(name, p), axis=1) / self.norm(name, p) for p in self.points(name)}
            for name in ERRORS
        }

    def largest(self, name: str) -> float | None:
        """The largest error of a name over all points; None where no point has it."""
        return max((float(error.max()) for error in self.sizes[name].values()), default=None)

    @property
    def errors(self) -> Errors:
        """The same over the run."""
        at = (self.times - self.times[0]) / self.scene.period
        edges = np.unique(np.linspace(0, len(at), min(SPANS, len(at)) + 1).astype(int))[:-1]
        found: dict[str, dict[str, ErrorCurve]] = {}
        for point in self.scene.lengths:
            for name in ERRORS:
                if (error := self.sizes[name].get(point)) is not None:
                    curve = ErrorCurve(size_of(error), at[edges], np.asarray(np.maximum.reduceat(error, edges)))
                    found.setdefault(point, {})[name] = curve
        return found
