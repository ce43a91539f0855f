"""The names in a work-precision diagram: of points on the fronts, and of the presets' curves."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from itertools import pairwise

import numpy as np
from matplotlib.axes import Axes

from conrod.report.charts.styles import colour, engine_title
from conrod.report.sweep.choice import Curve, preset_curves
from conrod.report.sweep.placing import Placed, drawn_costs, drawn_errors
from conrod.report.sweep.point_names import Place, placed_names
from conrod.studies.sweep.results import SweepStudy, SweptPoint

NAME_SIZE = 6.5  # [pt]
ALONG = 3.0  # [pt]


def name_points(axes: Axes, study: SweepStudy, completed: Sequence[Placed], quantity: str, panel: Place) -> None:
    """The label of every point on the front of its engine, in a panel of a width and height [pt]."""
    by_engine = [study.front(quantity, engine) for engine in study.engines]
    fronts = [point for front in by_engine for point in front]
    at = [_in_points(axes, point, quantity, panel) for point in fronts]
    presets = [p.point for p in completed if p.point.preset is not None and not p.estimated]
    others = [p.point for p in completed if p.point.preset is None and not p.estimated]
    marks = [*at, *(_in_points(axes, point, quantity, panel) for point in presets)]
    lines = [place for front in by_engine for place in _along([_in_points(axes, p, quantity, panel) for p in front])]
    dots = [*lines, *(_in_points(axes, point, quantity, panel) for point in others)]
    names = placed_names([p.label for p in fronts], at, marks, dots, panel, NAME_SIZE)
    for point, name in zip(fronts, names, strict=True):
        axes.annotate(
            name.text,
            (float(drawn_costs([point])[0]), float(drawn_errors([point], quantity)[0])),
            xytext=name.offset,
            textcoords="offset points",
            fontsize=NAME_SIZE,
            color=colour(point.engine),
            ha="center",
            va="center",
            zorder=8,
            bbox={"facecolor": "white", "edgecolor": "none", "pad": 0.4, "alpha": 0.8},
            arrowprops={"arrowstyle": "-", "color": colour(point.engine), "linewidth": 0.4, "shrinkB": 2.0}
            if name.needs_line
            else None,
        )


def _along(places: Sequence[Place]) -> list[Place]:
    """Places along the line through some places, close enough that no name fits between them."""
    found: list[Place] = []
    for (x0, y0), (x1, y1) in pairwise(places):
        count = max(1, round(math.hypot(x1 - x0, y1 - y0) / ALONG))
        found += [(x0 + (x1 - x0) * k / count, y0 + (y1 - y0) * k / count) for k in range(count)]
    return found


def _in_points(axes: Axes, point: SweptPoint, quantity: str, panel: Place) -> Place:
    """Where a point is drawn [pt], from the lower left corner of its panel."""
    (left, right), (low, high) = np.log10(axes.get_xlim()), np.log10(axes.get_ylim())
    x, y = np.log10(drawn_costs([point])[0]), np.log10(drawn_errors([point], quantity)[0])
    return (
        round(float((x - left) / (right - left)) * panel[0], 1),
        round(float((y - low) / (high - low)) * panel[1], 1),
    )


def name_curves(axes: Axes, study: SweepStudy, costs: Mapping[str, float], quantity: str) -> None:
    """The name of each preset's curve at the right edge, level with its finest run; names are moved apart."""
    low, high = np.log10(axes.get_ylim())
    ends: list[tuple[float, Curve]] = []
    for curve in preset_curves(study):
        drawn = [p for p in curve.points if p.completed and p.label in costs]
        if drawn:
            ends.append((float(np.log10(drawn_errors(drawn[-1:], quantity)[0])), curve))
    below = low - 1.0
    for level, curve in sorted(ends, key=lambda end: (end[0], end[1].engine, end[1].preset)):
        below = max(level, below + 0.045 * (high - low))
        text = f"{engine_title(curve.engine)} {curve.preset}"
        axes.annotate(
            text,
            (1.01, (below - low) / (high - low)),
            xycoords="axes fraction",
            fontsize=8.0,
            color=colour(curve.engine),
            va="center",
            annotation_clip=False,
        )
