"""Errors of a table's motion against a scene."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TypeAlias

import numpy as np

from conrod.comparison.compare import Size, size_of
from conrod.exact.link_rotations import ROTATIONS, link_rotations
from conrod.exact.motion import Array, Motion
from conrod.models.tables.columns import (
    AXES,
    CRANK,
    CRANK_ACCELERATION,
    CRANK_ANGLE,
    CRANK_SPEED,
    MOTION,
    TIME,
    rotation_column,
)
from conrod.scenes import Scene

# Name of an error -> the quantity that it is of.
ERRORS = {"total": "position"} | dict(zip(MOTION, MOTION, strict=True))
ALL_ERRORS = (*ERRORS, *ROTATIONS)  # of points, then of links
# More cannot be distinguished in the width of a figure; each span keeps its largest error.
MAX_CURVE_SPANS = 400


@dataclass(frozen=True)
class ErrorCurve:
    """Normalised error over a run.

    Attributes:
        size: max, rms and final value of all samples.
        at: where each span begins (N,), in revolutions since the first row; at most `MAX_CURVE_SPANS`.
        largest: largest error in each span (N,).
    """

    size: Size
    at: Array
    largest: Array


# By point or link, then by name in `ALL_ERRORS` as far as the table has columns for them; over revolutions since the
# first row.
Errors: TypeAlias = Mapping[str, Mapping[str, ErrorCurve]]


@dataclass(frozen=True)
class TableComparison:
    """A table compared with the exact motion; each exact motion is computed once, for all points.

    Attributes:
        values: what the table says, SI: an array (T,) by quantity, of those in `columns.quantities` that it has; times
            increase.
        turn: angle [rad] that is added to the crank angle, (T,) or one for all rows.
    """

    values: Mapping[str, Array]
    scene: Scene
    turn: float | Array = 0.0

    def change_columns(self, change: Callable[[Array], Array], *names: str) -> TableComparison:
        """Replace the named columns that the table has by a function of them."""
        return replace(self, values={n: change(v) if n in names else v for n, v in self.values.items()})

    def scale_columns(self, by: float, *names: str) -> TableComparison:
        """Multiply the named columns by a factor."""
        return self.change_columns(lambda column: by * column, *names)

    def thin_rows(self, max_rows: int) -> TableComparison:
        """Keep at most `max_rows` evenly spread rows, the first and the last among them."""
        count = len(self.times)
        if count <= max_rows:
            return self
        keep = np.unique(np.rint(np.linspace(0, count - 1, max_rows)).astype(int))
        return self.change_columns(lambda column: column[keep], *self.values)

    def shift_time(self, by: float | Array) -> TableComparison:
        """Shift all rows later in time [s], and the crank by the angle that it turns in that time."""
        turn = self.values.get(CRANK_SPEED, self.scene.speed) * by
        return self.change_columns(lambda times: times + by, TIME).change_columns(
            lambda angle: angle + turn, CRANK_ANGLE
        )

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
        """Crank angle in the table (T,) [rad]; the nominal angle if the table has none."""
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
    def motion_at_nominal_crank(self) -> Motion:
        """Exact motion at the nominal crank angle and speed."""
        return self.scene.motion(self.nominal_angle, self.scene.speed)

    @cached_property
    def motion_at_own_crank(self) -> Motion:
        """Exact motion at the table's crank angle, speed and acceleration; nominal if it has none."""
        if not CRANK.keys() & self.values.keys():
            return self.motion_at_nominal_crank
        rate = self.values.get(CRANK_SPEED, self.scene.speed)
        return self.scene.motion(self.angle, rate, self.values.get(CRANK_ACCELERATION, 0.0))

    @property
    def motion_orders(self) -> list[int]:
        """Orders of derivative of the points' columns that the table has: 0 for positions, 2 for accelerations."""
        return [order for order, name in enumerate(MOTION) if self.points(name)]

    @cached_property
    def derivatives_by_angle(self) -> Mapping[str, Sequence[Array]]:
        """Exact positions of each point and their derivatives by the crank angle, each (T, 2), up to the table's."""
        solver = self.scene.kinematics
        return solver.point_derivatives(solver.derivatives(self.angle, self.motion_orders[-1]))

    # -- links ---------------------------------------------------------------------------------------------------------

    def links(self, quantity: str) -> list[str]:
        """Links for which the table has a column of a quantity of rotation."""
        begin = rotation_column(quantity, "")
        return [name.removeprefix(begin) for name in self.values if name.startswith(begin)]

    @property
    def rotation_columns(self) -> list[str]:
        """Columns of the table that hold a rotation of a link, or its derivatives."""
        return [rotation_column(quantity, link) for quantity in ROTATIONS for link in self.links(quantity)]

    @cached_property
    def exact_rotations(self) -> tuple[Array, ...]:
        """Exact rotation, angular velocity and angular acceleration (T, n) of all links at the table's crank motion."""
        rate = self.values.get(CRANK_SPEED, self.scene.speed)
        return link_rotations(self.scene.kinematics, self.angle, rate, self.values.get(CRANK_ACCELERATION, 0.0))

    def rotation_difference(self, quantity: str, link: str) -> Array:
        """Table minus exact motion (T,) of a link's rotation [rad], angular velocity or angular acceleration [SI].

        A table may count an angle from 0 to 360 deg again and again, and begin in any turn, so jumps by a turn from one
        row to the next are taken out of the difference. A turn that slips over several rows stays in it.
        """
        exact = self.exact_rotations[ROTATIONS.index(quantity)][:, self.scene.kinematics.mechanism.body_index[link]]
        off = self.values[rotation_column(quantity, link)] - exact
        if quantity != "rotation":
            return np.asarray(off)
        off = np.unwrap(off)
        return np.asarray(off - 2.0 * np.pi * np.rint(off[0] / (2.0 * np.pi)))

    def _rotation_sizes(self, quantity: str) -> dict[str, Array]:
        """Normalised errors (T,) of a quantity of rotation, by link: over its range R, omega R or omega^2 R."""
        return {
            link: np.abs(self.rotation_difference(quantity, link))
            / (self.scene.kinematics.rotation_ranges[link] * abs(self.scene.speed) ** ROTATIONS.index(quantity))
            for link in self.links(quantity)
        }

    # -- errors --------------------------------------------------------------------------------------------------------

    def axes(self, name: str, point: str) -> dict[int, str]:
        """Columns of the table that an error is computed from, by component (0 for x, 1 for y)."""
        letter, _ = MOTION[ERRORS[name]]
        columns = {k: f"{point}.{letter}{axis}" for k, axis in enumerate(AXES)}
        return {k: column for k, column in columns.items() if column in self.values}

    def points(self, name: str) -> list[str]:
        """Observed points for which the table has a column of an error's quantity, x or y or both."""
        return [point for point in self.scene.lengths if self.axes(name, point)]

    def difference(self, name: str, point: str) -> Array:
        """Table minus exact motion (T, c), SI, of the c components that the table has."""
        axes, motion = (
            self.axes(name, point),
            self.motion_at_nominal_crank if name == "total" else self.motion_at_own_crank,
        )
        exact = getattr(motion.point(point), ERRORS[name])
        return np.asarray(np.column_stack([self.values[column] for column in axes.values()]) - exact[:, list(axes)])

    def normalising_size(self, name: str, point: str) -> float:
        """Size that an error is divided by: L, omega L or omega^2 L."""
        return self.scene.lengths[point] * abs(self.scene.speed) ** list(MOTION).index(ERRORS[name])

    def normalised_differences(self, name: str) -> Array:
        """Table minus exact motion, normalised, of all components of all points (T, c)."""
        return np.column_stack([self.difference(name, p) / self.normalising_size(name, p) for p in self.points(name)])

    def angle_derivatives(self, name: str) -> Array:
        """Derivatives of `normalised_differences` of positions with respect to the crank angle (T, c)."""
        motion = self.scene.motion(self.nominal_angle if name == "total" else self.angle, 1.0)
        axes = {p: list(self.axes(name, p)) for p in self.points(name)}
        return -np.column_stack([motion.point(p).velocity[:, axes[p]] / self.normalising_size(name, p) for p in axes])

    @cached_property
    def sizes(self) -> dict[str, dict[str, Array]]:
        """Normalised errors (T,) by name in `ALL_ERRORS` and by point or link, for which the table has columns.

        `position`, `velocity` and `acceleration` are taken at the angle, rate and angular acceleration that the
        table's own columns say; where it has none, at the nominal ones, and `position` is then the same as `total`.
        """
        return {
            name: {
                p: np.linalg.norm(self.difference(name, p), axis=1) / self.normalising_size(name, p)
                for p in self.points(name)
            }
            for name in ERRORS
        } | {name: self._rotation_sizes(name) for name in ROTATIONS}

    def largest(self, name: str) -> float | None:
        """The largest error of a name in `ALL_ERRORS` over all points or links; None if none has it."""
        return max((float(error.max()) for error in self.sizes[name].values()), default=None)

    @property
    def errors(self) -> Errors:
        """Error curves over the run, by point or link and by name in `ALL_ERRORS`."""
        at = (self.times - self.times[0]) / self.scene.period
        edges = np.unique(np.linspace(0, len(at), min(MAX_CURVE_SPANS, len(at)) + 1).astype(int))[:-1]
        found: dict[str, dict[str, ErrorCurve]] = {}
        links = (link for quantity in ROTATIONS for link in self.links(quantity))
        for owner in dict.fromkeys((*self.scene.lengths, *links)):
            for name in ALL_ERRORS:
                if (error := self.sizes[name].get(owner)) is not None:
                    curve = ErrorCurve(size_of(error), at[edges], np.asarray(np.maximum.reduceat(error, edges)))
                    found.setdefault(owner, {})[name] = curve
        return found
