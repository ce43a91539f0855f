"""Stamps: by how much the values of a quantity belong to another instant than their rows say."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from conrod.scenes import Scene
from conrod.tables.alignment import Alignment
from conrod.tables.judging import Exact, quantity_of
from conrod.tables.samples import Observed

STEPS = 30
CONVERGED = 1e-12  # of a period
NEXT = {"position": "velocity", "velocity": "acceleration", "acceleration": "jerk"}


def shifted(observed: Observed, by: float, scene: Scene) -> Observed:
    """The table with all its rows so much later [s], the crank as far on as it turns in that time."""
    rate = scene.speed if observed.rate is None else observed.rate
    angle = None if observed.angle is None else observed.angle + rate * by
    return replace(observed, times=observed.times + by, angle=angle)


def stamp_of(name: str, observed: Observed, scene: Scene, alignment: Alignment) -> float | None:
    """By how much later than their rows say the values of an error's quantity belong [s], by Gauss and Newton.

    Returns:
        None where no shift makes the difference smaller.
    """
    total, first = 0.0, None
    for _ in range(STEPS):
        step, left = _step(name, shifted(observed, total, scene), scene, alignment)
        first = left if first is None else first
        # Beyond half a turn it is another instant of another turn, found from elsewhere.
        if abs(total + step) > 0.5 * scene.period:
            return None
        total += step
        if abs(step) < CONVERGED * scene.period:
            return total if left < first else None
    return None


def _step(name: str, observed: Observed, scene: Scene, alignment: Alignment) -> tuple[float, float]:
    """The best shift to first order [s], and the sum of squares as it is."""
    up, down, left = 0.0, 0.0, 0.0
    exact, quantity = Exact(observed, scene, alignment), quantity_of(name)
    for point, quantities in observed.points.items():
        if quantity in quantities:
            difference = exact.difference(name, point)
            faster = getattr(exact.motion(name).point(point), NEXT[quantity])
            slope = alignment.seen(faster, quantities[quantity], placed=False)
            weight = scene.lengths[point] ** -2
            up += weight * float(np.sum(slope * difference))
            down += weight * float(np.sum(slope * slope))
            left += weight * float(np.sum(difference**2))
    return (up / down if down else 0.0), left
