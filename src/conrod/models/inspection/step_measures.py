"""Measures of a response to a jump of a command: overshoot, settling time, steady-state error."""

from __future__ import annotations

import numpy as np

from conrod.exact.motion import Array
from conrod.models.inspection.actuator_results import StepResponse

SETTLING_BAND = 0.02  # of a move: the usual criterion of 2 %
FINAL_SHARE, SWING_SHARE = 0.1, 0.2  # of a run, its end, that the final value and the swing are taken of
CREEP_SHARE = 0.05  # of what is left at the begin of that part, by which a slow response comes nearer in it
SETTLED_BY = 0.9  # of a run, until which it must be within its band


def is_settled(values: Array, move: float) -> bool:
    """True if values (T,) stay within the settling band of their final value over the last part of a run."""
    late = values[-max(2, round(2.0 * SWING_SHARE * len(values))) :]
    return bool(np.ptp(late) <= SETTLING_BAND * abs(move))


def measure_step(
    values: Array, forces: Array, step: float, begin: float, target: float, obstacles: tuple[str, ...] = ()
) -> StepResponse:
    """Measure a response (T,) to a command that jumps at its first sample.

    With y the response, y1 its mean at the end and m the commanded move: the overshoot is the largest (y - y1) / m, and
    the settling time the first after which |y - y1| <= 0.02 |m| (Ogata, Modern Control Engineering, 5-3).

    Args:
        forces: of the actuator (T,).
        step: from a sample to the next [s].
        begin: value before the jump.
    """
    move = target - begin
    size = max(abs(move), 1e-300)
    tail = values[-max(1, round(FINAL_SHARE * len(values))) :]
    final = float(tail.mean())
    beyond = np.sign(move) * (values - final)
    overshoot = max(0.0, float(beyond.max())) / size if abs(final - begin) > SETTLING_BAND * size else 0.0
    outside = np.flatnonzero(np.abs(values - final) > SETTLING_BAND * size)
    last = int(outside[-1]) + 1 if len(outside) else 0
    settling = last * step if last <= SETTLED_BY * len(values) else None
    swing = float(np.ptp(values[-max(2, round(SWING_SHARE * len(values))) :])) / size
    # What drifts on has no final value that it could go beyond.
    overshoot = overshoot if overshoot > SETTLING_BAND * 0.05 else 0.0
    peak = float(forces[int(np.abs(forces).argmax())])
    return StepResponse(
        begin, target, final, size, overshoot, settling, swing, len(values) * step, peak, float(forces[-1]), obstacles,
        is_creeping(values, target),
    )  # fmt: skip


def is_creeping(values: Array, target: float) -> bool:
    """True if values (T,) still approach a target throughout the last part of a run.

    What has settled off its target, as under a load, comes no nearer: less than `CREEP_SHARE` of what is left.
    """
    left = np.abs(target - values[-max(3, round(SWING_SHARE * len(values))) :])
    return bool(np.all(np.diff(left) <= 0.0) and left[0] - left[-1] > CREEP_SHARE * left[0] > 0.0)
