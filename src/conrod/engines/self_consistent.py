"""What a motion answers to itself: x = respond(x), found in rounds."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from conrod.motion import Array

ROUNDS = 40
SETTLED = 1e-6  # of the largest entry
LEAST_SHARE = 0.25  # of a round's change that is taken over


def self_consistent(respond: Callable[[Array], Array], start: Array) -> Array | None:
    """The state that responds with itself; None where the rounds do not settle, or where a response is not finite."""
    state, before, share = start, np.zeros_like(start), 1.0
    for _ in range(ROUNDS):
        # What grows without end ends here as not finite, or as a matrix that cannot be solved.
        with np.errstate(all="ignore"):
            try:
                change = respond(state) - state
            except np.linalg.LinAlgError:
                return None
        largest = float(np.abs(change).max())
        if not math.isfinite(largest):
            return None
        share, before = _share(share, before, change), change
        state = state + share * change
        if largest <= SETTLED * float(np.abs(state).max()):
            return state
    return None


def _share(share: float, before: Array, change: Array) -> float:
    """How much of a change is taken over, so that a state that would swing about its end does not.

    Aitken's rule (Irons and Tuck, 1969), from what the last share has done to the change.
    """
    turned = change - before
    if not before.any() or not turned.any():
        return 1.0
    return float(np.clip(-share * np.sum(before * turned) / np.sum(turned * turned), LEAST_SHARE, 1.0))
