"""Clock offset and crank phase of a table, estimated where a user asks for them.

All of them shift the crank angle: the shift is looked for around the turn, and then by least squares.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import least_squares

from conrod.errors import InvalidInput, unknown_choice
from conrod.exact.motion import Array
from conrod.own.tables.samples import Exact, Observed
from conrod.scenes import Scene

CHOICES = ("time", "phase")
TURN = 2.0 * math.pi
# Rows that estimates are made from, and those that the turn is looked through with, evenly spread.
MOST_ROWS, SCAN_ROWS = 50_000, 300
STARTS = 120  # in a turn
PRECISION = 4.0 * float(np.finfo(float).eps)  # relative, of the sum of squares, of a step and of the slope
STILL = 1e-7  # a slope below this share of L leaves a shift undetermined


@dataclass(frozen=True)
class Estimate:
    """One estimated quantity, SI.

    Attributes:
        name: `time` is the table's clock minus the scene's, `phase` the crank angle at the scene's time 0, `zero` that
            where the table's own is 0.
        error: its standard error, for errors of one size (relative to L) that are independent from row to row.
    """

    name: str
    value: float
    error: float


@dataclass(frozen=True)
class Estimation:
    """Estimated quantities, from so many rows.

    Attributes:
        remaining: rms error that is left, divided by L; of the crank angle [rad] where a table has no positions.
    """

    estimates: tuple[Estimate, ...]
    rows: int
    remaining: float

    def aligned(self, observed: Observed, speed: float) -> Observed:
        """A table by the scene's clock and crank."""
        for one in self.estimates:
            observed = _moved(observed, one.name, one.value, speed)
        return observed


def _moved(observed: Observed, name: str, value: float, speed: float) -> Observed:
    if name == "zero" and observed.angle is not None:
        return replace(observed, angle=observed.angle + value)
    return replace(observed, times=observed.times + (-value if name == "time" else value / speed))


def parse_estimate(text: str) -> tuple[str, ...]:
    """The names in `--estimate time,phase`.

    Raises:
        InvalidInput: something that is not estimated.
    """
    names = [name.strip() for name in text.split(",")]
    for name in names:
        if name not in CHOICES:
            raise unknown_choice("thing to estimate", name, CHOICES)
    return tuple(dict.fromkeys(names))


def estimate(observed: Observed, scene: Scene, asked: Sequence[str]) -> Estimation:
    """Estimate what was asked for.

    Raises:
        InvalidInput: the table does not have what it would be determined from, or too little of it.
    """
    what, rows = f"--estimate {','.join(asked)}", observed.thinned(MOST_ROWS)
    has_places = observed.has("position")
    if not has_places and observed.angle is None:
        raise InvalidInput(f"{what}: the table has no positions to estimate it from")
    if scene.kinematics.mechanism.driver.span is not None:
        raise InvalidInput(f"{what}: it would be looked for anywhere in a turn, and the input makes one pass")
    if len(asked) > 1 and not (has_places and observed.angle is not None):
        raise InvalidInput(f"{what}: at constant speed one looks like the other in this table: ask for one of them")
    found = list(_estimates(rows, scene, asked))
    if still := [one.name for one, _ in found if math.isinf(one.error)]:
        raise InvalidInput(f"{what}: {still[0]} cannot be determined: nothing in this table depends on it")
    return Estimation(tuple(one for one, _ in found), len(rows.times), found[0][1])


def _estimates(observed: Observed, scene: Scene, asked: Sequence[str]) -> Iterator[tuple[Estimate, float]]:
    """Estimates, and what is left of each: of the crank's own zero first, then of the clock."""
    table, clock = Exact(observed, scene), "time" if "time" in asked else "phase"
    if "phase" in asked and observed.angle is not None and observed.has("position"):
        shift, error, left = fitted(table, "position")
        yield Estimate("zero", shift, error), left
    if observed.has("position"):
        shift, error, left = fitted(table, "total")
    else:
        off = np.unwrap(table.angle) - table.nominal_angle
        spread = float(np.sum((off - off.mean()) ** 2))
        error, left = math.sqrt(spread / (len(off) - 1) / len(off)), math.sqrt(spread / len(off))
        shift = math.remainder(float(off.mean()), TURN)
    by = -scene.speed if clock == "time" else 1.0
    yield Estimate(clock, shift / by, error / abs(by)), left


def fitted(table: Exact, name: str) -> tuple[float, float, float]:
    """The shift of the crank angle that brings the exact places nearest to those of a table.

    Args:
        name: `total` at the nominal time, `position` at the table's own crank angle.

    Returns:
        The smallest such shift and its standard error [rad], infinite where nothing depends on it, and the rms error
        that is left, divided by L.
    """
    samples = {point: own["position"] for point, own in table.observed.points.items() if "position" in own}
    count, vectors = sum(own.values.size for own in samples.values()), len(table.observed.times) * len(samples)

    def off(angle: Array, rows: slice = slice(None)) -> tuple[Array, Array]:
        """Table minus exact over L, and its derivative by the angle; of angles (.., T), with the numbers last."""
        motion = table.scene.motion(angle.ravel(), 1.0)
        parts = []
        for point, own in samples.items():
            exact, length, shape = motion.point(point), table.scene.lengths[point], (*angle.shape, len(own.axes))
            places, slopes = (v[:, own.axes].reshape(shape) for v in (exact.position, exact.velocity))
            parts.append(np.stack([own.values[rows] - places, -slopes]).reshape(2, *angle.shape[:-1], -1) / length)
        values, slopes = np.concatenate(parts, axis=-1)
        return values, slopes

    angle = table.nominal_angle if name == "total" else table.angle
    turns, few = np.arange(STARTS) * (TURN / STARTS), slice(None, None, max(1, len(angle) // SCAN_ROWS))
    start = turns[int(np.argmin(np.sum(off(turns[:, None] + angle[few], few)[0] ** 2, axis=-1)))]
    found = least_squares(
        lambda by: off(angle + by[0])[0], [start], jac=lambda by: off(angle + by[0])[1][:, None],
        method="lm", xtol=PRECISION, ftol=PRECISION, gtol=PRECISION,
    )  # fmt: skip
    slope, squares = float(np.linalg.norm(found.jac)), 2.0 * float(found.cost)
    # Of independent errors of one size: the square root of s^2 / (J^T J), s^2 = r^T r / (N - 1).
    error = math.inf if slope <= STILL * math.sqrt(count) else math.sqrt(squares / (count - 1)) / slope
    return math.remainder(float(found.x[0]), TURN), error, math.sqrt(squares / vectors)
