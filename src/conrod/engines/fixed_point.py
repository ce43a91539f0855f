"""Numerics of the engines' laws: roots, fixed points, and the derivatives that truncation errors grow with."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from conrod.exact.kinematics import Kinematics
from conrod.exact.motion import Array

SECANT_STEPS = 20


def close_gap(gap: Callable[[float], float], start: float, nudge: float, closed: float) -> float:
    """The argument at which a nearly linear function vanishes, by secant iteration.

    Args:
        gap: the function; called last at the result.
        start: first guess.
        nudge: distance of the second guess from it.
        closed: the iteration ends where |gap| is below this, or changes no more.
    """
    here, there = start, start + nudge
    gap_here, gap_there = gap(here), gap(there)
    for _ in range(SECANT_STEPS):
        if abs(gap_there) < closed or gap_there == gap_here:
            break
        here, there = there, there - gap_there * (there - here) / (gap_there - gap_here)
        gap_here, gap_there = gap_there, gap(there)
    return there


ROUNDS = 40
SETTLED = 1e-5  # of the largest entry


def self_consistent(respond: Callable[[Array], Array], start: Array) -> Array | None:
    """The state that responds with itself; None where the rounds do not settle, or a response is not finite."""
    state = start
    for _ in range(ROUNDS):
        # What grows without end ends here as not finite, or as a matrix that cannot be solved.
        with np.errstate(all="ignore"):
            try:
                following = respond(state)
            except np.linalg.LinAlgError:
                return None
        if not np.all(np.isfinite(following)):
            return None
        change, state = float(np.abs(following - state).max()), following
        if change <= SETTLED * float(np.abs(state).max()):
            return state
    return None


SAMPLES = 720
# Why there are no bounds for a linkage with a change point: there is no largest motion of links per gap of a joint.
UNDETERMINED = (
    "none at a change point: there any give of the joints, however small, leaves the motion open. A run that completed "
    "went on in the assembly of the exact motion; one that took the other is told as flipped"
)


def largest_derivatives(kinematics: Kinematics, order: int) -> list[float]:
    """Largest k-th derivative by the crank angle of any observed point, over its L; k = 0..order."""
    points = kinematics.point_derivatives(kinematics.derivatives(kinematics.angles(SAMPLES), order))
    sizes = [0.0] * (order + 1)
    for name, derivatives in points.items():
        length = kinematics.lengths[name]
        for k, values in enumerate(derivatives):
            sizes[k] = max(sizes[k], float(np.linalg.norm(values, axis=1).max()) / length)
    return sizes


def rounding(kinematics: Kinematics, steps: int) -> float:
    """Bound on the position error, over L, that rounding alone can sum up to in so many steps."""
    return float(np.finfo(float).eps) * steps * max(1.0, kinematics.size / kinematics.travel)
