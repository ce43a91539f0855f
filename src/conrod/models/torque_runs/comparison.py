"""A user's run beside the exact motion at the same times: differences, normalised."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from conrod.errors import InvalidInput
from conrod.exact.motion import Array
from conrod.models.tables.columns import AXES, CRANK_ANGLE, CRANK_SPEED, MOTION, TIME
from conrod.models.torque_runs.exact import Values
from conrod.scenes import Scene

PHASE, SPEED, CRANK = "phase", "speed", "crank"  # errors of the crank, and whose they are in tables
# What may be judged: of points, normalised by L, omega L and omega^2 L; of the crank [rad] and over omega.
JUDGED_QUANTITIES = (*MOTION, PHASE, SPEED)
MAX_START_DISTANCE = 0.02  # of L, of the first row from the mechanism: an engine's own start may leave joints ajar
START_ANGLES = 3600  # of a turn, that the first row is compared with


@dataclass(frozen=True)
class RunComparison:
    """The columns of a run and of the exact motion at the same rows, SI.

    Attributes:
        values: of the run, (T,) by quantity of `columns.quantities`, the time among them.
        exact: of the exact motion, of all these quantities.
        lengths: travel L of each observed point [m].
        speed: omega [rad/s], the largest exact speed of the crank.
    """

    values: Values
    exact: Values
    lengths: Mapping[str, float]
    speed: float

    @property
    def times(self) -> Array:
        """(T,) [s], growing."""
        return self.values[TIME]

    @property
    def compared_columns(self) -> list[str]:
        """Columns that both have, without accelerations of the crank."""
        judged = {CRANK_ANGLE, CRANK_SPEED}
        return [name for name in self.values if name in judged or "." in name]

    def keep_rows(self, rows: NDArray[np.intp]) -> RunComparison:
        """Keep some rows."""
        return replace(
            self, values={name: own[rows] for name, own in self.values.items()},
            exact={name: own[rows] for name, own in self.exact.items()},
        )  # fmt: skip

    def difference(self, column: str) -> Array:
        """Run minus exact motion (T,), SI; of the crank angle without whole turns that a table does not count."""
        off = np.asarray(self.values[column] - self.exact[column])
        if column != CRANK_ANGLE:
            return off
        # Where rows lie far apart the crank itself may turn by more than half a turn between two.
        unwrapped = np.unwrap(off)
        return np.asarray(unwrapped - 2.0 * math.pi * np.rint(unwrapped[0] / (2.0 * math.pi)))

    def unit_of(self, column: str) -> float:
        """Size that the difference of a column is divided by: 1 rad, omega, L, omega L or omega^2 L."""
        if "." not in column:
            return 1.0 if column == CRANK_ANGLE else self.speed
        point, component = column.rsplit(".", 1)
        order = ["", "v", "a"].index(component[:-1])
        return self.lengths[point] * self.speed**order

    @cached_property
    def sizes(self) -> dict[str, dict[str, Array]]:
        """Normalised errors (T,) by name in `JUDGED_QUANTITIES`, and by point, or `crank`."""
        found: dict[str, dict[str, Array]] = {}
        for quantity, (letter, _) in MOTION.items():
            for point in self.lengths:
                columns = [name for axis in AXES if (name := f"{point}.{letter}{axis}") in self.values]
                if columns:
                    parts = [self.difference(name) / self.unit_of(name) for name in columns]
                    found.setdefault(quantity, {})[point] = np.linalg.norm(parts, axis=0)
        for quantity, column in ((PHASE, CRANK_ANGLE), (SPEED, CRANK_SPEED)):
            if column in self.values:
                found[quantity] = {CRANK: np.abs(self.difference(column)) / self.unit_of(column)}
        return found

    def largest(self, name: str) -> float | None:
        """The largest error of a quantity; None where the run has none."""
        return max((float(error.max()) for error in self.sizes.get(name, {}).values()), default=None)

    def normalised_differences(self) -> Array:
        """Differences (N,) of all compared columns but accelerations, each divided by its `unit_of`."""
        columns = [name for name in self.compared_columns if name.rsplit(".", 1)[-1][:1] != "a"]
        return np.concatenate([self.difference(name) / self.unit_of(name) for name in columns])


def check_start(scene: Scene, values: Values, row_time: float) -> None:
    """Refuse a run whose first row fits the mechanism at no crank angle.

    Raises:
        InvalidInput: says which point lies how far off.
    """
    low, high = scene.kinematics.span
    exact = scene.motion(np.linspace(low, high, START_ANGLES), 1.0)
    off = dict[str, Array]()
    for point, length in scene.lengths.items():
        axes = [k for k, axis in enumerate(AXES) if f"{point}.{axis}" in values]
        if axes:
            found = np.array([values[f"{point}.{AXES[k]}"][0] for k in axes])
            off[point] = np.linalg.norm(exact.point(point).position[:, axes] - found, axis=1) / length
    if not off:
        return
    nearest = int(np.argmin(np.max(list(off.values()), axis=0)))
    worst = max(off, key=lambda point: float(off[point][nearest]))
    if (size := float(off[worst][nearest])) > MAX_START_DISTANCE:
        shown = 1e3 * size * scene.lengths[worst]
        raise InvalidInput(
            f"the run starts off the mechanism: at t = {row_time:.6g} s {worst} is {shown:.4g} mm from the nearest "
            "place where the machine can be; is it in another frame or unit? `conrod show` names the frame"
        )
