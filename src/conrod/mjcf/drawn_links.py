"""Links of a compiled model as lines of a picture, in the plane of their motion or in an oblique projection."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import mujoco
import numpy as np
from numpy.typing import NDArray

from conrod.comparison.trajectory import Outcome
from conrod.engines.engine import STOCK
from conrod.exact.motion import Array
from conrod.exact.space.motion import SpatialMotion
from conrod.mjcf.link_sketch import sketch_links
from conrod.mjcf.loading import FoundPoint
from conrod.mjcf.loop_results import OWN_SETTINGS, LoopRun
from conrod.mjcf.picture_planes import PictureView, view_of
from conrod.report.drawing.moving_links import GEOM, DrawnRun, LinkShape, MovingLinks
from conrod.report.numbers import round_to_digits

FRAMES = 60  # of a run, besides its first
MAX_LABELS, BESIDE = 8, 30.0  # names of points, and how near one hides another [drawing units]
MAX_NUMBERS = 40_000  # of all runs together, above which fewer instants are drawn
STRIDES = (1, 2, 3, 4, 5, 6)  # from one to the next; all divide `FRAMES`
DRAWING_UNITS = 1000.0  # of the picture's larger side
MARGIN, MIN_ASPECT = 0.08, 0.3  # of the larger side: about the picture, and its least height or width
MIN_WIDTH, MAX_WIDTH = 8.0, 120.0  # of the axis of a geom [drawing units]
RUN_DIGITS = 3  # of differences from the exact places


# Preset whose line the curve of a run has, by the run's label, where that is no preset.
LINE_PRESETS = {OWN_SETTINGS: STOCK}


def drawn_end(outcome: Outcome) -> str:
    """Say how a run ended; empty if it completed."""
    return "" if outcome is Outcome.COMPLETED else f"ended as {outcome.slug}"


@dataclass(frozen=True)
class RunToDraw:
    """A run of a model, to be drawn.

    Attributes:
        name, preset, seconds, ended: as in `DrawnRun`.
        coordinates: coordinates (nq, K) of all joints at equally spaced instants; fewer instants if it broke off.
    """

    name: str
    preset: str
    seconds: float
    coordinates: Array
    ended: str = ""


def frame_indices(samples: int) -> NDArray[np.intp]:
    """Indices (K,) of the samples to draw, of a run of that many samples."""
    return np.round(np.linspace(0, samples - 1, min(samples, FRAMES + 1))).astype(np.intp)


def draw_links(
    model: mujoco.MjModel, exact: Array | None, runs: Sequence[RunToDraw], points: Sequence[FoundPoint] = (),
    reference: str = "exact",
) -> MovingLinks | None:  # fmt: skip
    """Draw runs of a model as moving lines; None if nothing moves or nothing can be drawn.

    Args:
        exact: exact coordinates (nq, K) at the runs' instants; None where there is no exact motion.
        points: judged points, which are named in the picture.
        reference: what the exact coordinates are, in words.
    """
    motions = [exact] if exact is not None else [run.coordinates for run in runs]
    if not motions or not model.nv or not all(motion.shape[1] for motion in motions):
        return None
    sketch = sketch_links(model, np.concatenate(motions, axis=1), points)
    if not sketch.offsets:
        return None
    instants = sum(run.coordinates.shape[1] for run in runs) + (0 if exact is None else exact.shape[1])
    numbers = 2 * len(sketch.offsets) * instants
    every = next((n for n in STRIDES if numbers <= n * MAX_NUMBERS), STRIDES[-1])
    motions = [motion[:, ::every] for motion in motions]
    runs = [replace(run, coordinates=run.coordinates[:, ::every]) for run in runs]
    tracks = [sketch.places(model, motion) for motion in motions]
    still = sketch.ground_places(model, motions[0][:, 0])
    view = view_of(np.concatenate(tracks))
    scale, box = _fit_picture(view, tracks, still)
    flat = [scale * view.project(track).reshape(len(track), -1) for track in tracks]
    drawn, exact_rows = list[DrawnRun](), np.round(flat[0], 1) if exact is not None else np.empty((0, 0))
    for k, run in enumerate(runs):
        if exact is None:
            drawn.append(DrawnRun(run.name, run.preset, run.seconds, np.round(flat[k], 1), (), run.ended))
            continue
        count = min(run.coordinates.shape[1], motions[0].shape[1])
        off = sketch.places(model, run.coordinates[:, :count]) - tracks[0][:count]
        rows = scale * view.project(off).reshape(count, -1)
        rounded = np.array([[round_to_digits(float(value), RUN_DIGITS) for value in row] for row in rows])
        judged = np.linalg.norm(off[:, sketch.judged or slice(None)], axis=2).max(axis=1)
        away = tuple(round_to_digits(1e3 * float(size), RUN_DIGITS) for size in judged)
        drawn.append(DrawnRun(run.name, run.preset, run.seconds, rounded, away, run.ended))
    widths = [_with_width(shape, scale) for shape in sketch.shapes]
    ground = tuple(_with_width(shape, scale) for shape in sketch.ground)
    return MovingLinks(
        view.words, reference if exact is not None else "", box, tuple(widths), ground,
        np.round(scale * view.project(still), 1), _clear_labels(sketch.labels, flat[0]), exact_rows, tuple(drawn),
        sketch.left_out,
    )  # fmt: skip


def _clear_labels(labels: Sequence[tuple[int, str]], rows: Array) -> tuple[tuple[int, str], ...]:
    """Leave out the name of each point that stays beside a named point in all rows (K, 2 P) of the picture."""
    found = list[tuple[int, str]]()
    for k, name in labels:
        apart = [np.linalg.norm(rows[:, 2 * k : 2 * k + 2] - rows[:, 2 * j : 2 * j + 2], axis=1) for j, _ in found]
        if all(float(distances.max()) > BESIDE for distances in apart):
            found.append((k, name))
    return tuple(found[:MAX_LABELS])


def _with_width(shape: LinkShape, scale: float) -> LinkShape:
    """A shape with its width [m] in drawing units, neither a hair nor a block."""
    if not shape.width:
        return shape
    least, most = (MIN_WIDTH, MAX_WIDTH) if shape.kind == GEOM else (MIN_WIDTH, 2.0 * DRAWING_UNITS)
    return replace(shape, width=round(float(np.clip(scale * shape.width, least, most)), 1))


def _fit_picture(view: PictureView, tracks: Sequence[Array], still: Array) -> tuple[float, tuple[int, int, int, int]]:
    """Scale [drawing units / m] and box of a picture of moving points (K, P, 3) and fixed points (G, 3)."""
    places = np.concatenate([view.project(track).reshape(-1, 2) for track in [*tracks, still[None]]])
    low, high = places.min(axis=0), places.max(axis=0)
    size = float((high - low).max()) or 1.0
    scale = DRAWING_UNITS / size
    middle, sides = 0.5 * scale * (low + high), np.maximum(scale * (high - low), MIN_ASPECT * DRAWING_UNITS)
    sides += 2.0 * MARGIN * DRAWING_UNITS
    left, top = middle - 0.5 * sides
    return scale, (round(float(left)), round(float(top)), round(float(sides[0])), round(float(sides[1])))


# -- judged runs over the exact motion ---------------------------------------------------------------------------------


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
