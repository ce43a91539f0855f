"""Errors of a table against the exact motion, as docs/design.md names them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from conrod.comparison import ErrorSeries
from conrod.motion import Array
from conrod.scenes import Scene
from conrod.tables.alignment import Alignment
from conrod.tables.samples import QUANTITIES, Observed

ERRORS = ("total", "position", "velocity", "acceleration")


@dataclass(frozen=True)
class Crank:
    """What a table says of its crank.

    Attributes:
        phase: its angle minus the nominal one (T,) [rad].
        speed: largest |rate / nominal rate - 1|, None where the table has no rate.
        acceleration: largest |angular acceleration| / omega^2, None where it has none.
    """

    phase: Array
    speed: float | None
    acceleration: float | None


def table_errors(observed: Observed, scene: Scene, alignment: Alignment) -> dict[str, dict[str, ErrorSeries]]:
    """Normalised errors by point, and by name in `ERRORS` as far as the table has columns for them.

    `position`, `velocity` and `acceleration` are taken at the angle, rate and angular acceleration that the table's
    own columns say; where it has none, at the nominal ones, and `position` is then the same as `total`.
    """
    return {
        point: {name: series for name in ERRORS if (series := error_of(name, point, observed, scene, alignment))}
        for point in observed.points
    }


def error_of(name: str, point: str, observed: Observed, scene: Scene, alignment: Alignment) -> ErrorSeries | None:
    """One error of one point; None where the table has no columns for it."""
    quantity = quantity_of(name)
    if quantity not in observed.points[point]:
        return None
    angle, difference = difference_of(name, point, observed, scene, alignment)
    norm = scene.lengths[point] * abs(scene.speed) ** QUANTITIES.index(quantity)
    return ErrorSeries(angle, np.linalg.norm(difference, axis=1) / norm)


def quantity_of(name: str) -> str:
    """The quantity that an error is of."""
    return "position" if name == "total" else name


def difference_of(name: str, point: str, observed: Observed, scene: Scene, alignment: Alignment) -> tuple[Array, Array]:
    """Crank angles (T,) [rad] that an error is taken at, and table minus exact (T, c), SI, in the table's frame."""
    quantity = quantity_of(name)
    if name == "total":
        angle = alignment.nominal(observed, scene.speed)
        motion = scene.motion(angle, alignment.sense * scene.speed)
    else:
        angle = alignment.reached(observed, scene.speed)
        motion = scene.motion(angle, alignment.rate(observed, scene.speed), alignment.acceleration(observed))
    samples = observed.points[point][quantity]
    exact: Array = getattr(motion.point(point), quantity)
    return angle, samples.values - alignment.seen(exact, samples, placed=quantity == "position")


def largest(errors: Mapping[str, Mapping[str, ErrorSeries]], name: str, measure: str = "max") -> float | None:
    """The largest error of a name over all points; None where no point has it. `measure`: max, rms or final."""
    sizes = [getattr(series[name].size, measure) for series in errors.values() if name in series]
    return max(sizes) if sizes else None


def crank_of(observed: Observed, scene: Scene, alignment: Alignment) -> Crank | None:
    """How the table's crank deviates from the nominal one; None where the table does not say where it was."""
    if observed.angle is None:
        return None
    # A table may count its angle from 0 to 360 deg again and again, and begin in any turn.
    angle = np.unwrap(alignment.reached(observed, scene.speed))
    phase = angle - alignment.nominal(observed, scene.speed)
    phase = phase - 2.0 * np.pi * np.rint(phase[0] / (2.0 * np.pi))
    speed = alignment.sense * scene.speed
    rate, acceleration = alignment.rate(observed, scene.speed), alignment.acceleration(observed)
    return Crank(
        phase,
        None if observed.rate is None else float(np.abs(rate / speed - 1.0).max()),
        None if observed.acceleration is None else float(np.abs(acceleration).max()) / speed**2,
    )
