"""The report of a sweep: a page for each machine with its work-precision diagram, and an index of the cheapest."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure as Drawing
from matplotlib.lines import Line2D

from conrod.engines import engine_style
from conrod.exact.motion import QUANTITIES
from conrod.report import numbers
from conrod.report.charts.canvas import (
    NORMS,
    add_legend_above,
    preset_handles,
    round_to_log_grid,
    set_decades,
    set_log_axis,
)
from conrod.report.charts.styles import colour, engine_title, preset_style
from conrod.report.figure import Figure, Spot, spots_in_axes
from conrod.report.kind import Index, Kind
from conrod.report.results import distrust_lines, distrust_words
from conrod.report.table import Table, table
from conrod.report.terminal import PrintedPart
from conrod.studies.sweep import tables
from conrod.studies.sweep.findings import SweepStudy, SweptPoint


def diagram_of(study: SweepStudy) -> Figure | None:
    """Return the figure of error against cost; None where nothing was timed."""
    if not tables.timed_points(study):
        return None
    alt = f"Error against cost of every run, {study.name}"
    return Figure(f"{study.name}-work-precision", alt, partial(work_precision_figure, study), partial(spots, study))


def spots(study: SweepStudy, diagram: Drawing) -> Iterator[Spot]:
    """Yield a spot for each timed point of the diagram, with its settings to paste."""
    points = tables.timed_points(study)
    for axes, quantity in zip(diagram.axes, QUANTITIES, strict=True):
        places = [(p.cost or 0.0, p.error(quantity) or 0.0, _point_words(study, p)) for p in points]
        yield from spots_in_axes(diagram, axes, places)


def _point_words(study: SweepStudy, point: SweptPoint) -> str:
    """Describe a run in the diagram: engine, steps, errors, cost, and settings to paste."""
    errors = ", ".join(f"{quantity} {numbers.measured_text(point.error(quantity))}" for quantity in QUANTITIES)
    return (
        f"{point.label}: {engine_title(point.engine)} {point.rule}, {point.steps_per_revolution} steps a revolution: "
        f"errors {errors}; {numbers.duration(point.cost or 0.0)} a revolution.\n{study.settings_lines(point)}"
    )


def _summary(study: SweepStudy) -> dict[str, Any]:
    return {"findings": tables.findings(study), "cheapest": tables.cheapest_rows(study, "position")}


def cheapest_table(index: Index[SweepStudy]) -> Table:
    """Return the cheapest settings of all machines for several tolerances of the position."""
    rows = [
        [f"[{name}]({entry['page']})", *row]
        for name, entry in index.entries.items()
        for row in entry["summary"]["cheapest"]
    ]
    head = ["machine", "position " + tables.CHEAPEST_HEAD[0], *tables.CHEAPEST_HEAD[1:]]
    return table(head, rows, right=head[4:])


def first_figure(studies: Iterable[SweepStudy]) -> Figure | None:
    """Return the position diagram of the study with most points; None where none was timed."""
    study = max((study for study in studies if tables.timed_points(study)), key=lambda s: len(s.points), default=None)
    if study is None:
        return None
    alt = f"Position error against cost of every run, {study.name}"
    return Figure("position", alt, partial(work_precision_figure, study, ("position",)))


# -- the work-precision diagram: error against cost, every timed run of the grid in it ---------------------------------

OVERALL_FRONT_STYLE: dict[str, Any] = {"color": "#c4c4c4", "linewidth": 7.0, "zorder": 1, "solid_capstyle": "round"}

WIDTH, PANEL, MARGINS = 10.5, 5.1, 1.4  # of a figure, of a panel, of legend and labels [inch]


def work_precision_figure(study: SweepStudy, quantities: Sequence[str] = QUANTITIES) -> Drawing:
    """Draw error against CPU time, a panel for each quantity.

    Args:
        study: with timings.
        quantities: names of the panels' quantities.
    """
    points = tables.timed_points(study)
    figure = Drawing(figsize=(WIDTH, PANEL * len(quantities) + MARGINS))
    drawn = figure.subplots(len(quantities), 1, sharex=True, squeeze=False)[:, 0]
    costs = round_to_log_grid(np.array([p.cost or 0.0 for p in points]))
    limits = (float(costs.min()) / 1.6, float(costs.max()) * 1.6)
    for axes, quantity in zip(drawn, quantities, strict=True):
        _cost_axis(axes, limits)
        _draw_panel(axes, study, points, quantity)
    drawn[0].set_title(f"{study.name}: {study.title}", loc="left", parse_math=False)
    drawn[-1].set_xlabel("CPU time of a simulated revolution")
    add_legend_above(figure, _legend(study), 3)
    return figure


def _cost_axis(axes: Axes, limits: tuple[float, float]) -> None:
    """Give the axes a logarithmic scale of CPU time, with its decades in words."""
    first, last = np.ceil(np.log10(limits[0])), np.floor(np.log10(limits[1]))
    decades = [10.0**k for k in range(int(first), int(last) + 1)]
    set_log_axis(axes, limits, decades, [numbers.duration(x).replace(".0", "") for x in decades])


def _draw_panel(axes: Axes, study: SweepStudy, points: Sequence[SweptPoint], quantity: str) -> None:
    set_decades(axes, [_rounded_errors(points, quantity)])
    axes.set_ylabel(f"{quantity} error, max / {NORMS[quantity]}")
    _plot_points(axes, study.front(quantity), quantity, OVERALL_FRONT_STYLE)
    for engine in study.engines:
        _plot_points(axes, _points_without_preset(points, engine), quantity, _dot_style(engine))
        _plot_points(axes, study.front(quantity, engine), quantity, _front_style(engine))
    for curve in tables.preset_curves(study):
        of_preset = [p for p in curve.points if p in points]
        _plot_points(axes, of_preset, quantity, preset_style(curve.engine, curve.preset) if of_preset else {})


def _plot_points(axes: Axes, points: Sequence[SweptPoint], quantity: str, style: dict[str, Any]) -> None:
    axes.plot(round_to_log_grid(np.array([p.cost or 0.0 for p in points])), _rounded_errors(points, quantity), **style)


def _points_without_preset(points: Sequence[SweptPoint], engine: str) -> list[SweptPoint]:
    """Points of an engine that belong to no preset."""
    return [p for p in points if p.engine == engine and p.preset is None]


def _rounded_errors(points: Sequence[SweptPoint], quantity: str) -> Any:
    """Errors of points, rounded to the resolution of a logarithmic figure."""
    return round_to_log_grid(np.array([p.error(quantity) or 0.0 for p in points]))


def _dot_style(engine: str) -> dict[str, Any]:
    """Arguments of `Axes.plot` for runs of no preset."""
    dots = {"linestyle": "none", "marker": engine_style(engine).marker, "markersize": 2.6, "markeredgewidth": 0.0}
    return {**dots, "color": colour(engine), "alpha": 0.35, "zorder": 2}


def _front_style(engine: str) -> dict[str, Any]:
    """Arguments of `Axes.plot` for an engine's Pareto front."""
    line = {"color": colour(engine), "linewidth": 2.2, "alpha": 0.9, "zorder": 6, "linestyle": "-"}
    dots = {
        "marker": engine_style(engine).marker,
        "markersize": 4.0,
        "markeredgecolor": "white",
        "markeredgewidth": 0.5,
    }
    return {**line, **dots}


def _legend(study: SweepStudy) -> list[Line2D]:
    drawn = [curve for curve in tables.preset_curves(study) if any(p.completed and p.cost for p in curve.points)]
    handles = preset_handles((curve.engine, curve.preset) for curve in drawn)
    engines = tables.timed_engines(study)
    for engine in (one for one in engines if _points_without_preset(tables.timed_points(study), one)):
        style = _dot_style(engine) | {"alpha": 0.5, "markersize": 4.0}
        handles.append(Line2D([], [], label=f"{engine_title(engine)}, other settings", **style))
    for engine in engines:
        label = f"best of {engine_title(engine)} (Pareto front)"
        handles.append(Line2D([], [], label=label, **_front_style(engine)))
    handles.append(Line2D([], [], label="best of all engines", **OVERALL_FRONT_STYLE))
    return handles


def results_to_print(studies: Sequence[SweepStudy]) -> Iterator[PrintedPart]:
    """Yield for each scene the settings that no other beats in both cost and position error."""
    yield from distrust_lines(studies)
    for study in studies:
        yield tables.front_table(study, f"{study.name}: settings that none beats in both cost and position")
        yield tables.RATIO_NOTE
        yield points_words(study)
        yield from (f"{name} unsupported: {why}" for name, why in study.unsupported.items())


def points_words(study: SweepStudy) -> str:
    """Say how many settings were run, and how the runs ended."""
    return f"{len(study.points)} settings and steps: {tables.end_words(study)}"


def verdict(study: SweepStudy) -> str:
    """Say in a few sentences which settings are cheapest, or that the figures cannot be trusted."""
    found = distrust_words(study) or " ".join(tables.findings(study)) or points_words(study)
    return f"{study.name}: {found}".replace("**", "")


def headline(entries: Mapping[str, Mapping[str, Any]]) -> str:
    """Say which engine is the cheapest within `COMPARED_ERROR` of the position, and on how many machines."""
    allowed = tables.tolerance_text(tables.COMPARED_ERROR)
    cheapest = Counter[str]()
    for entry in entries.values():
        rows = [row for row in entry["summary"]["cheapest"] if row[0] == allowed and row[-1] != numbers.MISSING]
        cheapest.update(row[1] for row in sorted(rows, key=lambda row: float(row[-1]))[:1])
    found = [f"{engine} on {count}" for engine, count in cheapest.most_common()]
    said = f"Cheapest for a position error of {allowed} L, on {len(entries)} machines"
    return f"{said}: {', '.join(found)}." if found else ""


SWEEP_REPORT = Kind(
    name="sweep",
    findings=SweepStudy,
    title=lambda study: study.title,
    summary=_summary,
    printed=results_to_print,
    verdict=verdict,
    headline=headline,
    digits=6,
)
