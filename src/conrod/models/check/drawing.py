"""A model in motion over its own exact motion, driven at a scene's speed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from conrod.exact.motion import Array
from conrod.mjcf.drawn_links import LINE_PRESETS, RunToDraw, draw_links, drawn_end, frame_indices
from conrod.mjcf.driving import LoopRecording
from conrod.models.check.results import JudgedRun
from conrod.models.check.turning import ALMOST_REVOLUTION, Turning
from conrod.report.drawing.moving_links import MovingLinks

TURN_SECONDS = 1.0  # of a turn that is drawn at no machine's speed
# What grey shows: the model's own closures, which are not the scene's where its lengths are others.
REFERENCE = "as its own closures place it at the crank angle reached"


def draw_scene_runs(
    turning: Turning, judged: Sequence[JudgedRun], recorded: Mapping[str, LoopRecording], period: float
) -> MovingLinks | None:
    """Draw the first turn of driven runs over the model's exact motion; None if nothing can be drawn.

    Args:
        recorded: recording of each run, by its label.
        period: time [s] of a turn of the crank.
    """
    longest = max(recorded.values(), key=lambda run: len(run.times))
    samples = int(np.searchsorted(longest.times, period * (1.0 + 1e-9)))
    shown = frame_indices(max(2, min(samples, len(longest.times))))
    exact = _exact_coordinates(turning, longest.coordinates[turning.crank.coordinate, shown])
    seconds, drawn = float(longest.times[shown[-1]]), list[RunToDraw]()
    for run in judged:
        coordinates = recorded[run.label].coordinates
        there, preset = shown[shown < coordinates.shape[1]], LINE_PRESETS.get(run.label, run.label)
        drawn.append(RunToDraw(run.label, preset, seconds, coordinates[:, there], drawn_end(run.outcome)))
    return draw_links(turning.model, exact, drawn, turning.points, REFERENCE)


def draw_turn(turning: Turning, *, as_far_as_it_goes: bool = False) -> MovingLinks | None:
    """Draw a turn, or the pass, of a model whose runs would say nothing, as its closures place it.

    Args:
        as_far_as_it_goes: whether its crank goes no further than a part of the turn.
    """
    end, name = ALMOST_REVOLUTION if turning.reach is None else sum(turning.reach), "a turn of its crank"
    if as_far_as_it_goes:
        end, name = turning.machine.knots[-1].time, "its crank turned as far as it goes"
    times = np.linspace(0.0, end, len(frame_indices(1000)))
    run = RunToDraw(f"{name}, as its closures place it", "", TURN_SECONDS, turning.coordinates(times))
    return draw_links(turning.model, None, [run], turning.points)


def _exact_coordinates(turning: Turning, crank: Array) -> Array:
    """Exact coordinates (nq, K) of all joints at coordinates (K,) [rad] of the crank."""
    times = np.array([turning.time_at(float(value)) for value in crank])
    order = np.argsort(times, kind="stable")
    found = np.empty((turning.model.nq, len(times)))
    found[:, order] = turning.coordinates(times[order])
    return found
