"""Names in a work-precision diagram: of points on the fronts, and of the presets' curves."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from itertools import pairwise

import numpy as np
from matplotlib.axes import Axes

from conrod.exact.motion import Array
from conrod.report.charts.canvas import on_log_grid
from conrod.report.charts.styles import colour, engine_title
from conrod.report.sweep.selection import Placed, preset_curves
from conrod.studies.sweep.findings import SweepStudy, SweptPoint

Place = tuple[float, float]  # in a panel, or its width and height [pt]

NAME_SIZE = 6.5  # [pt]
ALONG = 3.0  # [pt] between the places of a line that names keep off
# Directions from a point, best first: a front has nothing of its own below it and to its left.
DIRECTIONS = ((-0.8, -0.6), (-1.0, 0.0), (-0.3, -1.0), (-0.9, 0.45), (0.3, -1.0), (0.9, -0.45), (0.0, 1.0), (0.9, 0.45))
DISTANCES = (12.0, 16.0, 22.0, 30.0, 40.0, 52.0)  # [pt]
FAR = 13.0  # [pt]: a name at this distance or more needs a line to its point
MARKED = 4.5  # half the side of a marked point [pt]
ON_NAME, OUTSIDE, ON_MARK, ON_DOT = 1000.0, 1000.0, 60.0, 1.0


def name_offsets(
    texts: Sequence[str], at: Sequence[Place], marks: Sequence[Place], dots: Sequence[Place], panel: Place, size: float
) -> list[Place]:
    """Offset [pt] of a name from each point, placed one after the other, where it covers least.

    Args:
        texts: the names.
        at: their points [pt] from the lower left corner of the panel.
        marks: points that should stay free: those that are named, and those of highlighted curves [pt].
        dots: points that may be covered where nothing else is left [pt].
        panel: width and height of the panel [pt].
        size: of the font [pt].
    """
    tries = [(distance * dx, distance * dy) for distance in DISTANCES for dx, dy in DIRECTIONS]
    ranks = [0.1 * distance + 0.1 * rank for distance in DISTANCES for rank in range(len(DIRECTIONS))]
    named: list[tuple[Array, Array]] = []
    offsets = []
    for text, point in zip(texts, at, strict=True):
        half = np.array([0.36 * size * len(text), 0.6 * size])
        centres = np.add(point, tries)
        burden = np.array(ranks)
        for other, its_half in named:
            burden += ON_NAME * _touching(centres, other[None], half + its_half)
        burden += ON_MARK * _touching(centres, _places(marks), half + MARKED)
        burden += ON_DOT * _touching(centres, _places(dots), half + 1.0)
        burden += OUTSIDE * ((centres < half) | (centres + half > panel)).any(axis=1)
        best = int(np.argmin(burden))
        named.append((centres[best], half))
        offsets.append(tries[best])
    return offsets


def _places(places: Sequence[Place]) -> Array:
    return np.asarray(places, dtype=float).reshape(-1, 2)


def _touching(centres: Array, others: Array, reach: Array) -> Array:
    """Number of other places (K, 2) within a reach (2,) along x and y of each centre (N, 2)."""
    return np.asarray((np.abs(centres[:, None] - others[None]) < reach).all(axis=2).sum(axis=1))


def name_points(axes: Axes, study: SweepStudy, placed: Sequence[Placed], quantity: str, panel: Place) -> None:
    """The label of every point on the front of its engine, in a panel of a width and height [pt]."""

    def at(points: Sequence[SweptPoint]) -> list[Place]:
        return [_in_points(axes, drawn_place(point, quantity), panel) for point in points]

    by_engine = [study.front(quantity, engine) for engine in study.engines]
    fronts = [point for front in by_engine for point in front]
    timed = [p.point for p in placed if p.point.completed and not p.estimated]
    marks = at([*fronts, *(point for point in timed if point.preset is not None)])
    lines = [place for front in by_engine for place in _along(at(front))]
    dots = [*lines, *at([point for point in timed if point.preset is None])]
    offsets = name_offsets([p.label for p in fronts], at(fronts), marks, dots, panel, NAME_SIZE)
    for point, offset in zip(fronts, offsets, strict=True):
        line = {"arrowstyle": "-", "color": colour(point.engine), "linewidth": 0.4, "shrinkB": 2.0}
        axes.annotate(
            point.label, drawn_place(point, quantity), xytext=offset, textcoords="offset points", fontsize=NAME_SIZE,
            color=colour(point.engine), ha="center", va="center", zorder=8,
            bbox={"facecolor": "white", "edgecolor": "none", "pad": 0.4, "alpha": 0.8},
            arrowprops=line if math.hypot(*offset) >= FAR else None,
        )  # fmt: skip


def drawn_place(point: SweptPoint, quantity: str) -> Place:
    """Measured cost [s] and error of a point, on the grid that is drawn."""
    cost, error = on_log_grid(np.array([point.cost or 0.0, point.error(quantity) or 0.0]))
    return float(cost), float(error)


def _along(places: Sequence[Place]) -> list[Place]:
    """Places along the line through some places, close enough that no name fits between them."""
    found: list[Place] = []
    for (x0, y0), (x1, y1) in pairwise(places):
        count = max(1, round(math.hypot(x1 - x0, y1 - y0) / ALONG))
        found += [(x0 + (x1 - x0) * k / count, y0 + (y1 - y0) * k / count) for k in range(count)]
    return found


def _in_points(axes: Axes, place: Place, panel: Place) -> Place:
    """A place in the data as one in the panel [pt], from its lower left corner."""
    ends = zip(np.log10(place), np.log10([axes.get_xlim(), axes.get_ylim()]), panel, strict=True)
    x, y = (round(float((value - low) / (high - low)) * size, 1) for value, (low, high), size in ends)
    return x, y


def name_curves(axes: Axes, study: SweepStudy, costs: Mapping[str, float], quantity: str) -> None:
    """The name of each preset's curve at the right edge, level with its finest run; names are moved apart."""
    low, high = np.log10(axes.get_ylim())
    ends = []
    for curve in preset_curves(study):
        drawn = [p.error(quantity) or 0.0 for p in curve.points if p.completed and p.label in costs]
        if drawn:
            ends.append((float(np.log10(on_log_grid(np.array(drawn[-1:])))[0]), curve.engine, curve.preset))
    below = low - 1.0
    for level, engine, preset in sorted(ends):
        below = max(level, below + 0.045 * (high - low))
        axes.annotate(
            f"{engine_title(engine)} {preset}", (1.01, (below - low) / (high - low)), xycoords="axes fraction",
            fontsize=8.0, color=colour(engine), va="center", annotation_clip=False,
        )  # fmt: skip
