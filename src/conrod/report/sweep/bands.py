"""Would a self-convergence study have noticed? Shares of cells whose error band holds the true error."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from statistics import median
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from conrod.exact.motion import Array
from conrod.report import numbers
from conrod.report.charts.canvas import on_grid
from conrod.report.charts.styles import colour, engine_title
from conrod.report.tables import table
from conrod.studies.frame.measurement import QUANTITIES
from conrod.studies.sweep.results import SweepStudy

if TYPE_CHECKING:
    from conrod.studies.sweep.grid_convergence import GridConvergence

PATHS = ("step alone", "step with softness")
RATIOS = (1e-4, 1e3)  # of band to error, drawn; what lies beyond is drawn at the edge
BESIDE = 0.3  # half the height over which the rules of a row are spread


@dataclass(frozen=True)
class Pooled:
    """The bands of several rules together, of one quantity.

    Attributes:
        ratios: of each rule, its median of band / |true error|.
    """

    rules: int
    contained: int
    missed: int
    at_rounding: int
    unreasonable: int
    oscillating: int
    ratios: tuple[float, ...]

    @property
    def told(self) -> int:
        """Cells whose error is not rounding."""
        return self.contained + self.missed

    @property
    def share(self) -> float | None:
        """Contained over told; None where nothing is told."""
        return self.contained / self.told if self.told else None

    @property
    def ratio(self) -> float | None:
        """Median over the rules of their median ratio."""
        return median(self.ratios) if self.ratios else None


@dataclass(frozen=True)
class Row:
    """A group of rules: an engine and what is refined, or a preset."""

    engine: str
    title: str
    path: str
    by_quantity: dict[str, Pooled]


def pooled(found: Iterable[GridConvergence], quantity: str) -> Pooled:
    """The shares of several rules of one quantity, added up."""
    shares = [rule.shares[quantity] for rule in found if rule.shares]
    return Pooled(
        rules=len(shares),
        contained=sum(share.contained for share in shares),
        missed=sum(share.missed for share in shares),
        at_rounding=sum(share.at_rounding for share in shares),
        unreasonable=sum(share.unreasonable for share in shares),
        oscillating=sum(share.oscillating for share in shares),
        ratios=tuple(share.ratio for share in shares if share.ratio is not None),
    )


def rows_of(study: SweepStudy) -> tuple[Row, ...]:
    """Engines and what is refined, those of which three grids in a row completed somewhere."""
    rows = []
    for engine in study.engines:
        for path in PATHS:
            found = [g for g in study.grid_convergence if (g.engine, g.path) == (engine, path) and g.shares]
            if found:
                rows.append(Row(engine, "all settings", path, {q: pooled(found, q) for q in QUANTITIES}))
    return tuple(rows)


def preset_rows(study: SweepStudy) -> tuple[Row, ...]:
    """The presets, each refined along both paths from one and the same settings."""
    return tuple(
        Row(found.engine, f"`{found.label}`", found.path, {q: pooled([found], q) for q in QUANTITIES})
        for found in study.both_ways
        if found.shares
    )


def shares_table(study: SweepStudy) -> str:
    """Counts and shares, of all settings and of the presets."""
    rows = []
    for row in (*rows_of(study), *preset_rows(study)):
        for quantity, found in row.by_quantity.items():
            rows.append(
                [
                    engine_title(row.engine),
                    row.title,
                    row.path,
                    quantity,
                    str(found.told),
                    f"**{numbers.percent(found.share)}**",
                    numbers.measured(found.ratio),
                    str(found.unreasonable),
                    str(found.oscillating),
                    str(found.at_rounding),
                ]
            )
    head = [
        "engine",
        "settings",
        "what is refined",
        "quantity",
        "cells",
        "band holds the error",
        "band / error, median",
    ]
    return table([*head, "of the cells with factor 3", "of these oscillating", "besides, at rounding"], rows)


# -- figure ------------------------------------------------------------------------------------------------------------


def bands_figure(study: SweepStudy) -> Figure | None:
    """Shares on the left, band over error of every rule on the right; None where no three grids completed."""
    rows = rows_of(study)
    if not rows:
        return None
    tall = 0.42 * len(rows) + 0.5
    figure = Figure(figsize=(10.5, 3 * tall + 1.1))
    grid = figure.subplots(3, 2, sharey="row", sharex="col", width_ratios=(1.0, 1.35))
    for (left, right), quantity in zip(grid, QUANTITIES, strict=True):
        for place, row in enumerate(rows):
            _bar(left, place, row, row.by_quantity[quantity])
            _dots(right, place, row, row.by_quantity[quantity])
        left.set_yticks(range(len(rows)), [f"{engine_title(row.engine)}, {row.path}" for row in rows])
        left.set_ylim(len(rows) - 0.4, -0.6)
        left.set_title(quantity, loc="left")
        left.set_xlim(0.0, 100.0)
        right.axvline(1.0, color="#333333", linewidth=1.2, zorder=3)
        right.set_xscale("log")
        right.set_xlim(RATIOS[0] / 2.0, RATIOS[1] * 2.0)
        right.minorticks_off()
        right.tick_params(axis="y", length=0)
    grid[0, 1].annotate(
        "band too narrow  |  holds the error",
        (1.0, 1.06),
        xycoords=("data", "axes fraction"),
        ha="center",
        fontsize=8.0,
        annotation_clip=False,
    )
    grid[2, 0].set_xlabel("cells whose band holds the true error [%]")
    grid[2, 1].set_xlabel("band / |true error|, median of each setting [-]")
    figure.subplots_adjust(left=0.21, right=0.975, top=1.0 - 0.4 / (3 * tall + 1.1), bottom=0.55 / (3 * tall + 1.1))
    figure.subplots_adjust(hspace=0.32, wspace=0.06)
    return figure


def _bar(axes: Axes, place: int, row: Row, found: Pooled) -> None:
    if found.share is None:
        axes.annotate("all at rounding", (2.0, place), va="center", fontsize=8.0)
        return
    filled = row.path == PATHS[1]
    hue = colour(row.engine)
    axes.barh(place, 100.0, height=0.62, color="#eeeeee", zorder=1)
    share = float(on_grid(np.array([100.0 * found.share]), 100.0)[0])
    axes.barh(place, share, height=0.62, color=hue, alpha=0.85 if filled else 0.5, zorder=2)
    inside = found.share > 0.5
    axes.annotate(
        f"{numbers.percent(found.share)} of {found.told}",
        (share, place),
        xytext=(-5 if inside else 5, 0),
        textcoords="offset points",
        ha="right" if inside else "left",
        va="center",
        fontsize=8.0,
        color="white" if inside and filled else "black",
    )


def _dots(axes: Axes, place: int, row: Row, found: Pooled) -> None:
    ratios: Array = np.clip(np.sort(np.array(found.ratios)), *RATIOS)
    # Spread by rank, so that settings of one ratio stay apart.
    spread = np.linspace(-1.0, 1.0, len(ratios)) if len(ratios) > 1 else np.zeros(len(ratios))
    heights = place + BESIDE * spread
    logarithm = on_grid(np.log10(ratios), 7.0)
    hue = colour(row.engine)
    style: dict[str, Any] = {"color": hue, "markerfacecolor": hue if row.path == PATHS[1] else "none"}
    axes.plot(10.0**logarithm, heights, "o", markersize=3.2, markeredgewidth=0.8, **style)
