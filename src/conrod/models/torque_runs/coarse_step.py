"""What a run looks like whose time step is too coarse: its joints gape, and more so the faster it goes."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from conrod.models.tables.causes import Cause
from conrod.models.tables.columns import AXES, CRANK_ANGLE, CRANK_SPEED
from conrod.models.torque_runs.comparison import RunComparison
from conrod.scenes import Scene

COARSE_STEP, GEOMETRY = "coarse step", "lengths"
MIN_GAP = 3e-7  # of L; below it a gap may be the rounding of the digits of a table
MIN_GAP_SHARE = 1e-3  # of the error of the position; a smaller gap does not come from what makes that
MIN_SPEED_RATIO = 1.5  # of rows in the fastest and in the slowest third, for a gap to tell whether it grows with speed
GROWS, STAYS = 1.3, 1.1  # ratio of gaps there, above which they grow with speed, and below which they do not


def coarse_step_cause(run: RunComparison, scene: Scene, wrong: Sequence[str]) -> Cause | None:
    """Return the cause that points leave the mechanism at the run's own crank angles; None where they do not.

    No torque, mass, friction or start moves a point off the curve that it is bound to: at the crank angle of the run
    itself each point has one place. A step of an engine leaves it by about the acceleration times the step squared.
    """
    gap = _gap_words(run, scene)
    if gap is None:
        return None
    kind, words = gap
    begin = "lengths or the frame are others: "
    if kind == COARSE_STEP:
        begin = "the time step is too coarse: "
        words += "; halve the step and check again: what comes of the step falls to a half or a quarter"
    return Cause(kind, begin + words, {name: (size, size) for name in wrong if (size := run.largest(name))})


def _gap_words(run: RunComparison, scene: Scene) -> tuple[str, str] | None:
    """Kind of the cause, and how far points lie from their places at the run's own crank angles."""
    if CRANK_ANGLE not in run.values:
        return None
    exact = scene.motion(run.values[CRANK_ANGLE], 1.0)
    gaps = {}
    for point, length in scene.lengths.items():
        axes = [k for k, axis in enumerate(AXES) if f"{point}.{axis}" in run.values]
        if axes:
            found = np.column_stack([run.values[f"{point}.{AXES[k]}"] for k in axes])
            gaps[point] = np.linalg.norm(found - exact.point(point).position[:, axes], axis=1) / length
    worst = max(gaps, key=lambda point: float(gaps[point].max()), default=None)
    error = run.largest("position")
    if worst is None or error is None or float(gaps[worst].max()) < max(MIN_GAP, MIN_GAP_SHARE * error):
        return None
    gap, size = gaps[worst], 1e3 * float(gaps[worst].max()) * scene.lengths[worst]
    words = f"at the run's own crank angles {worst} is up to {size:.3g} mm off the mechanism"
    speed = np.abs(run.values.get(CRANK_SPEED, run.exact[CRANK_SPEED]))
    slow, fast = speed <= np.quantile(speed, 1.0 / 3.0), speed >= np.quantile(speed, 2.0 / 3.0)
    ratio = float(gap[fast].max() / max(gap[slow].max(), 1e-300))
    if speed[fast].mean() > MIN_SPEED_RATIO * speed[slow].mean():
        if ratio > GROWS:
            return COARSE_STEP, f"{words}, and more so the faster it goes, which no torque, mass or friction does"
        if ratio < STAYS:
            return GEOMETRY, f"{words}, at any speed alike, which no torque, mass, friction or step does"
    return COARSE_STEP, f"{words}, which no torque, mass or friction does, but other lengths may"
