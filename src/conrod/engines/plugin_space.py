"""Checks of what a plugin's engine hands over of machines in space."""

from __future__ import annotations

from typing import Any

import numpy as np

from conrod.engines.plugin_pieces import MAX_STAMP_DEVIATION
from conrod.engines.plugin_values import check_array, check_text, check_type, refuse_unless
from conrod.engines.space import SpatialRun, SpatialStart
from conrod.exact.motion import QUANTITIES, Array


def check_spatial_run(found: Any, start: SpatialStart, preset: str, steps: int, every: int = 1) -> SpatialRun:
    """Return a copy of a run in space that has all points of its start, at the times that were asked for.

    Numbers that are not finite pass where a run has points: they are an outcome, as in the plane.

    Args:
        start, preset, steps, every: as given to `SpatialRuns.run_in_space`.

    Raises:
        EngineFault: a stamp, a point or an array of the run cannot be used; says which.
    """
    check_type(found, SpatialRun, "a run in space")
    failure = check_text(found.failure, "why a run in space broke off")
    times, most = check_array(found.times, "stamps"), steps // every + 1
    whole = len(times) <= most if failure else len(times) == most
    refuse_unless(whole, f"{len(times)} samples of a run in space, of which {most} were asked for")
    off = np.abs(times - start.step * every * np.arange(len(times)))
    if off.max(initial=0.0) > MAX_STAMP_DEVIATION * start.step:
        late = int(np.argmax(off > MAX_STAMP_DEVIATION * start.step))
        refuse_unless(False, f"stamps of which number {late} is {times[late]:.6g} s, {off[late]:.3g} s off its step")
    points = dict(check_type(found.points, dict, "points in space"))
    refuse_unless(set(points) == set(start.points), f"points {sorted(map(str, points))}, not {sorted(start.points)}")
    return SpatialRun(times, {name: _check_point(name, points[name], len(times)) for name in start.points}, failure)


def _check_point(name: str, values: Any, samples: int) -> Array:
    """Return a copy of position, velocity and acceleration (3, T, 3) of a point."""
    refuse_unless(type(values) is np.ndarray, f"point {name} as {type(values).__name__}, not as a numpy array")
    shape = (len(QUANTITIES), samples, 3)
    refuse_unless(values.shape == shape, f"point {name} of shape {values.shape}, not {shape}")
    refuse_unless(values.dtype == np.float64, f"point {name} as {values.dtype}, not as float64")
    return np.array(values)
