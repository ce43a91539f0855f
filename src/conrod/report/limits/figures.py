"""All figures of a scene's limits, by what they are called beside the scene's name."""

from __future__ import annotations

from collections.abc import Iterator

from matplotlib.figure import Figure

from conrod.report.charts.canvas import drawing_style, svg_text
from conrod.report.limits.axis_section import axis_figures, by_axis
from conrod.report.limits.findings import needs_chart
from conrod.report.limits.float_figure import float_figure
from conrod.report.limits.long_run_figure import long_run_figure
from conrod.report.limits.map_figure import map_figure
from conrod.studies.limits.maps import LimitMap
from conrod.studies.limits.results import LimitStudy

FLOAT, LONG_RUNS, NEEDS = "follower-float", "long-runs", "mass-ratio-iterations"


def limits_figures(study: LimitStudy) -> dict[str, str]:
    """The SVG figures for which the study has data."""
    with drawing_style():
        return {name: svg_text(figure) for name, figure in _figures(study) if figure is not None}


def _figures(study: LimitStudy) -> Iterator[tuple[str, Figure | None]]:
    for axis, walks in by_axis(study.walks).items():
        yield from axis_figures(axis, walks).items()
    yield NEEDS, needs_chart(study.needs)
    for found in study.maps:
        yield map_name(found), map_figure(found)
    yield FLOAT, float_figure(study.floats)
    yield LONG_RUNS, long_run_figure(study.long_runs)


def map_name(found: LimitMap) -> str:
    """What the figure of a map is called."""
    return f"{found.x_axis}-x-{found.y_axis}-{found.engine}-{found.preset}"
