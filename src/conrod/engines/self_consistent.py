"""What a motion answers to itself: x = respond(x), found in rounds."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from conrod.motion import Array

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
