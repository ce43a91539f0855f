"""Shares of cells whose error band, by a study of convergence alone, holds the true error."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from statistics import median

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from conrod.report import numbers
from conrod.report.charts.canvas import on_grid
from conrod.report.charts.layout import log_axis, rows_axis
from conrod.report.charts.styles import colour, engine_title
from conrod.report.table import Table, table
from conrod.studies.frame.measurement import QUANTITIES
from conrod.studies.sweep.findings import SweepStudy
from conrod.studies.sweep.grid_convergence import GridConvergence, Share
from conrod.studies.validation.refinement import PATHS

RATIOS = (1e-4, 1e3)  # of band to error, drawn; what lies beyond is drawn at the edge
COUNTS = ("contained", "missed", "at_rounding", "unreasonable", "oscillating")
SPREAD = 0.3  # half the height over which the rules of a row are spread


@dataclass(frozen=True)
class Row:
    """All rules of an engine along a path, or a preset along it.

    Attributes:
        shares: by quantity, of all rules together; their ratio is the median over the rules.
        ratios: by quantity, of each rule its median of band / |true error|.
    """

    engine: str
    title: str
    path: str
    shares: Mapping[str, Share]
    ratios: Mapping[str, Sequence[float]]


def pooled(engine: str, title: str, path: str, rules: Sequence[GridConvergence]) -> Row:
    """The shares of several rules, added up."""
    own = {q: [rule.shares[q] for rule in rules] for q in QUANTITIES}
    ratios = {q: [share.ratio for share in shares if share.ratio is not None] for q, shares in own.items()}
    counts = {q: {name: sum(getattr(share, name) for share in own[q]) for name in COUNTS} for q in QUANTITIES}
    shares = {q: Share(**counts[q], ratio=median(ratios[q]) if ratios[q] else None) for q in QUANTITIES}
    return Row(engine, title, path, shares, ratios)


def rows_of(study: SweepStudy) -> list[Row]:
    """Engines and what is refined, those of which three grids in a row completed somewhere."""
    groups = {
        (engine, path): [g for g in study.grid_convergence if (g.engine, g.path) == (engine, path) and g.shares]
        for engine in study.engines
        for path in PATHS
    }
    return [pooled(engine, "all settings", path, found) for (engine, path), found in groups.items() if found]


def shares_table(study: SweepStudy) -> Table:
    """Counts and shares, of all settings and of the presets, each refined both ways from the same settings."""
    presets = [pooled(one.engine, f"`{one.label}`", one.path, [one]) for one in study.both_ways if one.shares]
    rows = [
        [
            engine_title(row.engine),
            row.title,
            row.path,
            quantity,
            str(found.judged),
            f"**{numbers.percent(found.share)}**",
            numbers.measured(found.ratio),
            *map(str, (found.unreasonable, found.oscillating, found.at_rounding)),
        ]
        for row in (*rows_of(study), *presets)
        for quantity, found in row.shares.items()
    ]
    head = ["engine", "settings", "refined", "quantity", "cells", "band holds the error", "band / error, median"]
    counts = ["of the cells with factor 3", "of these oscillating", "besides, at rounding"]
    return table([*head, *counts], rows, right=[*head[4:], *counts])


# -- figure ------------------------------------------------------------------------------------------------------------


def bands_figure(study: SweepStudy) -> Figure:
    """Shares on the left, band over error of every rule on the right, of a study that has rows."""
    rows = rows_of(study)
    height = 3 * (0.42 * len(rows) + 0.5) + 1.1
    figure = Figure(figsize=(10.5, height))
    grid = figure.subplots(3, 2, sharey="row", sharex="col", width_ratios=(1.0, 1.35))
    for (left, right), quantity in zip(grid, QUANTITIES, strict=True):
        for place, row in enumerate(rows):
            _bar(left, place, row, row.shares[quantity])
            _dots(right, place, row, row.ratios[quantity])
        rows_axis(left, [f"{engine_title(row.engine)}, {row.path}" for row in rows], 0.4)
        left.set_title(quantity, loc="left")
        left.set_xlim(0.0, 100.0)
        right.axvline(1.0, color="#333333", linewidth=1.2, zorder=3)
        ends, ticks = (RATIOS[0] / 2.0, RATIOS[1] * 2.0), [10.0**k for k in range(-4, 4)]
        log_axis(right, ends, ticks, ["≤ 1e-4", *(numbers.quantity(x) for x in ticks[1:-1]), "≥ 1000"])
        right.tick_params(axis="y", length=0)
    note = {"xycoords": ("data", "axes fraction"), "fontsize": 8.0, "annotation_clip": False}
    grid[0, 1].annotate("band too narrow  |  holds the error", (1.0, 1.06), ha="center", **note)
    grid[2, 0].set_xlabel("cells whose band holds the true error [%]")
    grid[2, 1].set_xlabel("band / |true error|, a dot for the median of each setting [-]")
    figure.subplots_adjust(left=0.21, right=0.975, top=1.0 - 0.4 / height, bottom=0.55 / height)
    figure.subplots_adjust(hspace=0.32, wspace=0.06)
    return figure


def _bar(axes: Axes, place: int, row: Row, found: Share) -> None:
    if found.share is None:
        axes.annotate("all at rounding", (2.0, place), va="center", fontsize=8.0)
        return
    filled, inside = row.path == PATHS[1], found.share > 0.5
    share = float(on_grid(np.array(100.0 * found.share), 100.0))
    axes.barh(place, 100.0, height=0.62, color="#eeeeee", zorder=1)
    axes.barh(place, share, height=0.62, color=colour(row.engine), alpha=0.85 if filled else 0.5, zorder=2)
    axes.annotate(
        f"{numbers.percent(found.share)} of {found.judged}", (share, place), xytext=(-5 if inside else 5, 0),
        textcoords="offset points", ha="right" if inside else "left", va="center", fontsize=8.0,
        color="white" if inside and filled else "black",
    )  # fmt: skip


def _dots(axes: Axes, place: int, row: Row, found: Sequence[float]) -> None:
    logarithm = on_grid(np.log10(np.clip(np.sort(np.array(found)), *RATIOS)), 7.0)
    # Spread by rank, so that settings of one ratio stay apart.
    heights = place + (np.linspace(-SPREAD, SPREAD, len(found)) if len(found) > 1 else np.zeros(len(found)))
    hue = colour(row.engine)
    face = hue if row.path == PATHS[1] else "none"
    axes.plot(10.0**logarithm, heights, "o", markersize=3.2, markeredgewidth=0.8, color=hue, markerfacecolor=face)
