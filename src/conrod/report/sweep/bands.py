"""Shares of cells whose error band, by a study of convergence alone, holds the true error."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from statistics import median
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from conrod.exact.motion import Array
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
    """A group of rules: an engine and what is refined, or a preset.

    Attributes:
        shares: by quantity, of all rules together; their ratio is the median over the rules.
        ratios: by quantity, of each rule its median of band / |true error|.
    """

    engine: str
    title: str
    path: str
    shares: dict[str, Share]
    ratios: dict[str, tuple[float, ...]]


def pooled(engine: str, title: str, path: str, found: Sequence[GridConvergence]) -> Row:
    """The shares of several rules, added up."""
    shares, ratios = dict[str, Share](), dict[str, tuple[float, ...]]()
    for quantity in QUANTITIES:
        own = [rule.shares[quantity] for rule in found]
        ratios[quantity] = tuple(share.ratio for share in own if share.ratio is not None)
        counts = {name: sum(getattr(share, name) for share in own) for name in COUNTS}
        shares[quantity] = Share(**counts, ratio=median(ratios[quantity]) if ratios[quantity] else None)
    return Row(engine, title, path, shares, ratios)


def rows_of(study: SweepStudy) -> tuple[Row, ...]:
    """Engines and what is refined, those of which three grids in a row completed somewhere."""
    rows = []
    for engine in study.engines:
        for path in PATHS:
            found = [g for g in study.grid_convergence if (g.engine, g.path) == (engine, path) and g.shares]
            if found:
                rows.append(pooled(engine, "all settings", path, found))
    return tuple(rows)


def preset_rows(study: SweepStudy) -> tuple[Row, ...]:
    """The presets, each refined along both paths from one and the same settings."""
    found = [one for one in study.both_ways if one.shares]
    return tuple(pooled(one.engine, one.label, one.path, [one]) for one in found)


def shares_table(study: SweepStudy) -> Table:
    """Counts and shares, of all settings and of the presets."""
    presets = preset_rows(study)
    rows = [
        [
            engine_title(row.engine),
            f"`{row.title}`" if row in presets else row.title,
            row.path,
            quantity,
            str(found.judged),
            f"**{numbers.percent(found.share)}**",
            numbers.measured(found.ratio),
            str(found.unreasonable),
            str(found.oscillating),
            str(found.at_rounding),
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
    tall = 0.42 * len(rows) + 0.5
    figure = Figure(figsize=(10.5, 3 * tall + 1.1))
    grid = figure.subplots(3, 2, sharey="row", sharex="col", width_ratios=(1.0, 1.35))
    for (left, right), quantity in zip(grid, QUANTITIES, strict=True):
        for place, row in enumerate(rows):
            _bar(left, place, row, row.shares[quantity])
            _dots(right, place, row, row.ratios[quantity])
        rows_axis(left, [f"{engine_title(row.engine)}, {row.path}" for row in rows], 0.4)
        left.set_title(quantity, loc="left")
        left.set_xlim(0.0, 100.0)
        right.axvline(1.0, color="#333333", linewidth=1.2, zorder=3)
        log_axis(right, (RATIOS[0] / 2.0, RATIOS[1] * 2.0))
        right.tick_params(axis="y", length=0)
    grid[0, 1].annotate(
        "band too narrow  |  holds the error", (1.0, 1.06), xycoords=("data", "axes fraction"), ha="center",
        fontsize=8.0, annotation_clip=False,
    )  # fmt: skip
    grid[2, 0].set_xlabel("cells whose band holds the true error [%]")
    grid[2, 1].set_xlabel("band / |true error|, median of each setting [-]")
    height = 3 * tall + 1.1
    figure.subplots_adjust(left=0.21, right=0.975, top=1.0 - 0.4 / height, bottom=0.55 / height)
    figure.subplots_adjust(hspace=0.32, wspace=0.06)
    return figure


def _bar(axes: Axes, place: int, row: Row, found: Share) -> None:
    if found.share is None:
        axes.annotate("all at rounding", (2.0, place), va="center", fontsize=8.0)
        return
    filled = row.path == PATHS[1]
    axes.barh(place, 100.0, height=0.62, color="#eeeeee", zorder=1)
    share = float(on_grid(np.array([100.0 * found.share]), 100.0)[0])
    axes.barh(place, share, height=0.62, color=colour(row.engine), alpha=0.85 if filled else 0.5, zorder=2)
    inside = found.share > 0.5
    axes.annotate(
        f"{numbers.percent(found.share)} of {found.judged}", (share, place), xytext=(-5 if inside else 5, 0),
        textcoords="offset points", ha="right" if inside else "left", va="center", fontsize=8.0,
        color="white" if inside and filled else "black",
    )  # fmt: skip


def _dots(axes: Axes, place: int, row: Row, found: Sequence[float]) -> None:
    ratios: Array = np.clip(np.sort(np.array(found)), *RATIOS)
    # Spread by rank, so that settings of one ratio stay apart.
    heights = place + SPREAD * (np.linspace(-1.0, 1.0, len(ratios)) if len(ratios) > 1 else np.zeros(len(ratios)))
    logarithm = on_grid(np.log10(ratios), 7.0)
    hue = colour(row.engine)
    style: dict[str, Any] = {"color": hue, "markerfacecolor": hue if row.path == PATHS[1] else "none"}
    axes.plot(10.0**logarithm, heights, "o", markersize=3.2, markeredgewidth=0.8, **style)
