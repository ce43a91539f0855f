"""Search of the time steps up to which the response of an actuator stays the same."""

from __future__ import annotations

import copy
from collections.abc import Callable
from dataclasses import replace

import mujoco
import numpy as np

from conrod.engines.mujoco.compiled_edits import set_step
from conrod.exact.motion import Array
from conrod.models.inspection.actuator_results import SAME_RESPONSE, StepBounds
from conrod.models.inspection.actuator_runs import TrialBench, run_trial

DOUBLINGS, HALVINGS = 4, 6
MAX_SEARCH_STEPS = 40_000  # of one run
COMPARED_INSTANTS = 200
MIN_MOVE = 0.05  # of a range, that changes are shares of at least
MIN_STEPS = 8  # of a run that is long enough to be compared
IMPLICIT = ("implicit", "implicitfast", "discrete")
CRAMPED = 4.0  # times its own step, below which a largest stable step is compared with implicitfast's


def search_steps(
    bench: TrialBench, command: Callable[[mujoco.MjData], None], seconds: float, span: float
) -> StepBounds | None:
    """Find the largest time steps at which halving the step leaves a response the same.

    Args:
        command: sets what begins the response in data at the start.
        seconds: length of the response.
        span: range of the coordinate that it is meant for.

    Returns:
        None where the response is too long to be compared at small steps.
    """
    own = bench.step
    if seconds / own > MAX_SEARCH_STEPS:
        return None
    name = mujoco.mjtIntegrator(bench.model.opt.integrator).name.removeprefix("mjINT_")
    search = _Search(bench, command, seconds, span)
    largest, tried = search.largest_step()
    diverges, faster = search.response(own) is None, None
    if name.lower() not in IMPLICIT and (largest is None or largest < CRAMPED * own):
        other = copy.copy(bench.model)
        other.opt.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
        faster, _ = _Search(replace(bench, model=other), command, seconds, span).largest_step()
    shown = name if name == "RK4" else name.lower() if name != "EULER" else "Euler"
    return StepBounds(own, shown, largest, faster, diverges, search.change(own), tried)


class _Search:
    """Responses of a bench by their time step, each made once."""

    def __init__(
        self, bench: TrialBench, command: Callable[[mujoco.MjData], None], seconds: float, span: float
    ) -> None:
        self._bench, self._command, self._seconds, self._span = bench, command, seconds, span
        self._made = dict[float, Array | None]()

    def response(self, step: float) -> Array | None:
        """Values at `COMPARED_INSTANTS` evenly spaced times; None where the run diverges, or has too few steps."""
        if step not in self._made:
            self._made[step] = self._run(step)
        return self._made[step]

    def _run(self, step: float) -> Array | None:
        count = round(self._seconds / step)
        if count < MIN_STEPS:
            return None
        model, data = copy.copy(self._bench.model), copy.copy(self._bench.data)
        set_step(model, step)
        self._command(data)
        run = run_trial(replace(self._bench, model=model), data, count, self._span)
        if run.broke:
            return None
        times = np.linspace(0.0, (MIN_STEPS - 1) / MIN_STEPS * self._seconds, COMPARED_INSTANTS)
        return np.array([np.interp(times, step * np.arange(count), values) for values in (run.values, run.rates)])

    def change(self, step: float) -> float | None:
        """Change of the response, over its range, when a step [s] is halved; None if either run diverges."""
        one, half = self.response(step), self.response(0.5 * step)
        if one is None or half is None:
            return None
        ranges = np.maximum(np.ptp(half, axis=1), [MIN_MOVE * self._span, MIN_MOVE * self._span / self._seconds])
        change = np.abs(one - half)
        # Rates in the end: what swings from step to step hardly moves. How fast it begins to move is the step's.
        late = change[1, COMPARED_INSTANTS // 2 :].max()
        return float(max(change[0].max() / ranges[0], late / ranges[1]))

    def is_unchanged(self, step: float) -> bool:
        """True if the response stays the same when a step [s] is halved."""
        change = self.change(step)
        return change is not None and change <= SAME_RESPONSE

    def largest_step(self) -> tuple[float | None, tuple[float, float]]:
        """Largest step [s] at which halving leaves the response the same; smallest and largest tried."""
        own, least = self._bench.step, self._bench.step
        if self.is_unchanged(own):
            for k in range(1, DOUBLINGS + 1):
                if not self.is_unchanged(2.0**k * own):
                    return 2.0 ** (k - 1) * own, (own, 2.0**k * own * (1.0 + 1e-6))
            return 2.0**DOUBLINGS * own, (own, 2.0**DOUBLINGS * own)
        for k in range(1, HALVINGS + 1):
            if self._seconds / own * 2.0 ** (k + 1) > MAX_SEARCH_STEPS:
                break
            least = 0.5**k * own
            if self.is_unchanged(least):
                return least, (least, own)
        return None, (least, own)
