"""Shares of cells whose error band, by a study of convergence alone, holds the true error."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from statistics import median

from conrod.report import numbers
from conrod.report.charts.styles import engine_title
from conrod.report.table import Table, table
from conrod.studies.frame.measurement import QUANTITIES
from conrod.studies.sweep.findings import SweepStudy
from conrod.studies.sweep.grid_convergence import GridConvergence, Share
from conrod.studies.validation.refinement import PATHS

COUNTS = ("contained", "missed", "at_rounding", "unreasonable", "oscillating")


@dataclass(frozen=True)
class Row:
    """The shares by quantity of all rules of an engine, or of a preset, along a path."""

    engine: str
    title: str
    path: str
    shares: Mapping[str, Share]


def pooled(engine: str, title: str, path: str, rules: Sequence[GridConvergence]) -> Row:
    """The shares of several rules, added up; their ratio is the median over the rules."""
    own = {q: [rule.shares[q] for rule in rules] for q in QUANTITIES}
    ratios = {q: [share.ratio for share in shares if share.ratio is not None] for q, shares in own.items()}
    counts = {q: {name: sum(getattr(share, name) for share in own[q]) for name in COUNTS} for q in QUANTITIES}
    shares = {q: Share(**counts[q], ratio=median(ratios[q]) if ratios[q] else None) for q in QUANTITIES}
    return Row(engine, title, path, shares)


def rows_of(study: SweepStudy) -> list[Row]:
    """A row for each engine and path on which three grids in a row completed somewhere."""
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
