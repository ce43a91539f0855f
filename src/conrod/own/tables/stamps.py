"""Stamps: the instants that the values of a table belong to, where its rows say other ones."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.optimize import least_squares

from conrod.errors import InvalidInput
from conrod.exact.motion import Array
from conrod.own.tables.judging import Exact
from conrod.own.tables.samples import Alignment, Observed
from conrod.scenes import Scene

RATE = {"velocity": "acceleration", "acceleration": "jerk"}
FINE = 1e-13  # relative, of a shift and of what it leaves
HALF_TURN = 0.5  # of a period: beyond it another instant of another turn is nearer


def shifted(observed: Observed, by: float, scene: Scene) -> Observed:
    """The table with all its rows so much later [s], the crank as far on as it turns in that time."""
    rate = scene.speed if observed.rate is None else observed.rate
    angle = None if observed.angle is None else observed.angle + rate * by
    return replace(observed, times=observed.times + by, angle=angle)


def stamp_of(name: str, observed: Observed, scene: Scene, alignment: Alignment) -> float | None:
    """Time by which the values of a quantity belong later than their rows say [s], by least squares.

    Returns:
        None where no shift within half a turn makes the difference smaller.
    """
    samples = {point: own[name] for point, own in observed.points.items() if name in own}

    def motion(by: Array) -> Exact:
        return Exact(shifted(observed, float(by[0]) * scene.period, scene), scene, alignment)

    def residuals(by: Array) -> Array:
        try:
            exact = motion(by)
            return np.concatenate([exact.difference(name, p).ravel() / scene.lengths[p] for p in samples])
        except InvalidInput:  # the linkage does not come to where the crank would then be
            return np.full(sum(own.values.size for own in samples.values()), np.nan)

    def slopes(by: Array) -> Array:
        exact = motion(by).motion(name)
        rates = {p: getattr(exact.point(p), RATE[name]) for p in samples}
        seen = [alignment.seen(rates[p], own, placed=False).ravel() / scene.lengths[p] for p, own in samples.items()]
        return -scene.period * np.concatenate(seen)[:, None]

    start = np.zeros(1)
    before = 0.5 * float(np.sum(residuals(start) ** 2))
    found = least_squares(residuals, start, jac=slopes, bounds=(-HALF_TURN, HALF_TURN), xtol=FINE, ftol=FINE, gtol=FINE)
    within = abs(found.x[0]) < 0.99 * HALF_TURN
    return float(found.x[0]) * scene.period if within and found.cost < before else None
