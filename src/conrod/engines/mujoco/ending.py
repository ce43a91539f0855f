"""What MuJoCo itself did to a run. Imports no engine."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from conrod.engines.mujoco.settings import MuJoCoSettings
from conrod.motion import Array
from conrod.outcome import Verdict
from conrod.trajectory import Outcome

# What MuJoCo warns of where it resets the state, if it may.
BAD_NUMBERS = {"BADQPOS", "BADQVEL", "BADQACC"}


def ended_by_engine(
    clock: Array, first: int, before: float, warnings: Mapping[str, int], settings: MuJoCoSettings
) -> Verdict | None:
    """What MuJoCo did after a warning, told from its clock: its own reset starts it again, a stop lets it stand.

    Args:
        clock: of the engine at consecutive samples (T,) [s].
        first: index in the run of the first of them.
        before: the clock at the sample before that.
        warnings: of the engine, by name, up to the last sample.
    """
    if not np.all(np.isfinite(clock)):
        return None
    # The clock sums its steps, so over a long run it is off by many of them: each is judged by itself.
    steps = np.diff(clock, prepend=before)
    off = np.abs(steps - settings.timestep) > 0.5 * settings.timestep
    if not off.any():
        return None
    at = int(np.argmax(off))
    if steps[at] < 0.0:
        return Verdict(Outcome.RESET, f"the engine reset its state at step {first + at}")
    if settings.autoreset and not BAD_NUMBERS.isdisjoint(warnings):
        # In the first step there is nothing yet that a clock could fall back from.
        return Verdict(Outcome.RESET, f"the engine reset its state at step {first + at - 1}")
    return Verdict(Outcome.DIVERGED, f"the engine warned of bad numbers and stopped at step {first + at}")
