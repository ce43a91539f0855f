"""Judged runs of a model with closed loops in motion, over its exact motion."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import mujoco

from conrod.exact.motion import Array
from conrod.exact.space.motion import SpatialMotion
from conrod.mjcf.drawn_links import LINE_PRESETS, RunToDraw, draw_links, drawn_end, frame_indices
from conrod.mjcf.loading import FoundPoint
from conrod.mjcf.loop_results import LoopRun
from conrod.report.drawing.moving_links import MovingLinks


def draw_judged_runs(
    model: mujoco.MjModel, exact: SpatialMotion, points: Sequence[FoundPoint], runs: Sequence[LoopRun],
    recorded: Mapping[str, Array],
) -> MovingLinks | None:  # fmt: skip
    """Draw runs over the exact motion at the same instants; None if nothing can be drawn.

    Args:
        points: judged points.
        recorded: coordinates (nq, K) of each run, by its label; fewer instants if it broke off.
    """
    shown, drawn = frame_indices(len(exact.times)), list[RunToDraw]()
    for run in runs:
        if (coordinates := recorded.get(run.label)) is not None:
            there, preset = shown[shown < coordinates.shape[1]], LINE_PRESETS.get(run.label, run.label)
            seconds, ended = float(exact.times[-1]), drawn_end(run.outcome)
            drawn.append(RunToDraw(run.label, preset, seconds, coordinates[:, there], ended))
    return draw_links(model, exact.coordinates[:, shown], drawn, points)
