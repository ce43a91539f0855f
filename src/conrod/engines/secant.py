"""Where a gap closes."""

from __future__ import annotations

from collections.abc import Callable

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
