"""The report on a model's ingredients: a page for each machine with a figure for each engine, an index of verdicts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure as Canvas
from matplotlib.lines import Line2D

from conrod.report.ablate import tables
from conrod.report.charts.canvas import Layout, log_axis, on_grid, on_log_grid, rows_axis
from conrod.report.charts.styles import engine_title
from conrod.report.figure import Figure
from conrod.report.kind import Index, Kind, Page, Part
from conrod.report.numbers import ROUNDING
from conrod.report.template import rendered
from conrod.studies.ablate.findings import MEANINGS, AblationStudy, EngineAblation, Evidence, IngredientResult, Verdict
from conrod.studies.ablate.verdict import AS_GOOD, COSTS, NO_CHANGE, Levels

WIDTH, ROW = 9.5, 0.24  # [inch]
LEFT, BETWEEN, RIGHT, TOP, BOTTOM = 2.6, 0.35, 0.85, 0.42, 0.5  # [inch]
COST_SHARE = 0.52  # of the panels' width
# Okabe and Ito's colours, distinct for colour-blind readers; the verdict stands beside the row in words as well.
COLOURS = {
    Verdict.REQUIRED: "#0072B2",
    Verdict.FREE: "#009E73",
    Verdict.COSTLY: "#E69F00",
    Verdict.HARMFUL: "#D55E00",
    Verdict.UNDECIDED: "#777777",
}
MARK: dict[str, Any] = {"marker": "o", "markersize": 4.6, "linestyle": "none", "markeredgewidth": 1.1}
APART = 0.17  # of a row: the two models of an ingredient above each other
Row = IngredientResult | str  # or the heading of those below it
TICKS = (0.1, 0.2, 0.5, 1.0, 1.5, 2.0, 3.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0, 500.0, 1000.0)


def ingredients_figure(found: EngineAblation) -> Canvas:
    """The figure of an engine that has ingredients."""
    rows = _rows(found.ingredients)
    tall = ROW * len(rows)
    height = TOP + tall + BOTTOM
    layout = Layout(WIDTH, height)
    wide = WIDTH - LEFT - BETWEEN - RIGHT
    costs = layout.axes(LEFT, BOTTOM, COST_SHARE * wide, tall)
    changes = layout.axes(LEFT + COST_SHARE * wide + BETWEEN, BOTTOM, (1.0 - COST_SHARE) * wide, tall)
    for axes in (costs, changes):
        rows_axis(axes, [one if isinstance(one, str) else one.title for one in rows])
        axes.grid(visible=False, axis="y")
        for row in range(1, len(rows), 2):
            axes.axhspan(row - 0.5, row + 0.5, color="#f5f5f5", zorder=0, linewidth=0)
    _costs(costs, rows)
    _changes(changes, rows, Levels.of(found.variants).motion["position"])
    _verdicts(changes, rows)
    layout.legend(_legend(), 4)
    return layout.figure


def _rows(ingredients: Sequence[IngredientResult]) -> list[Row]:
    """Ingredients, those that are added and those that the minimal model consists of each under a heading."""
    rows = list[Row]()
    for heading, minimal in (("added", False), ("part of the minimal model", True)):
        some = [one for one in ingredients if one.minimal is minimal]
        rows += [heading, *some] if some else []
    return rows


def _seen(rows: Sequence[Row]) -> list[tuple[int, IngredientResult, Evidence]]:
    """Every piece of evidence with its row."""
    found = [(row, one) for row, one in enumerate(rows) if isinstance(one, IngredientResult)]
    return [(row, one, evidence) for row, one in found for evidence in one.evidence]


def _costs(axes: Axes, rows: Sequence[Row]) -> None:
    ends = [1.0]
    for row, one, evidence in _seen(rows):
        if evidence.cost is None:
            continue
        low, middle, high = on_grid(np.array([evidence.cost.low, evidence.cost.ratio, evidence.cost.high]), 1.0)
        at, colour = _lane(row, one, evidence), COLOURS[one.verdict]
        axes.plot([low, high], [at, at], color=colour, linewidth=2.2, alpha=0.55, solid_capstyle="butt", zorder=3)
        axes.plot([middle], [at], **_mark(colour, evidence))
        ends += [float(low), float(high)]
    axes.axvline(1.0, color="#333333", linewidth=0.9, zorder=2)
    axes.axvspan(1.0, COSTS, color="#e2e2e2", zorder=1, linewidth=0)
    low, high = min(ends) / 1.06, max(ends) * 1.06
    ticks = [tick for tick in TICKS if low <= tick <= high]
    log_axis(axes, (low, high), ticks, [f"{tick:g}" for tick in ticks])
    axes.set_xlabel("CPU time with it / without it [-]")
    for label, shown in zip(axes.get_yticklabels(), rows, strict=True):
        if isinstance(shown, str):
            label.set_fontstyle("italic")
            label.set_color("#666666")
    axes.tick_params(axis="y", length=0)


def _changes(axes: Axes, rows: Sequence[Row], level: float) -> None:
    largest = level
    for row, one, evidence in _seen(rows):
        if evidence.change is None:
            continue
        change = float(on_log_grid(np.array([evidence.change["position"]]))[0])
        axes.plot([change], [_lane(row, one, evidence)], clip_on=False, **_mark(COLOURS[one.verdict], evidence))
        largest = max(largest, change)
    top = 10.0 ** np.ceil(np.log10(largest) + 0.3)
    axes.axvspan(0.5 * ROUNDING, float(on_log_grid(np.array([level]))[0]), color="#e2e2e2", zorder=1, linewidth=0)
    first, last = round(np.log10(ROUNDING)), round(float(np.log10(top)))
    every = max(2, -(-(last - first) // 5))
    decades = range(first, last + 1, every)
    names = ["$\\leq 10^{-12}$" if k == first else f"$10^{{{k}}}$" for k in decades]
    log_axis(axes, (0.5 * ROUNDING, top), [10.0**k for k in decades], names)
    axes.set_xlabel("change of the position, max / L")
    axes.set_yticks([])


def _verdicts(axes: Axes, rows: Sequence[Row]) -> None:
    """The verdict in words at the right end of each row."""
    for row, one in enumerate(rows):
        if isinstance(one, IngredientResult):
            axes.annotate(
                one.verdict.value, (1.0, row), (8.0, 0.0), ("axes fraction", "data"), "offset points", va="center",
                color=COLOURS[one.verdict], fontsize=8.5, fontweight="bold",
            )  # fmt: skip


def _lane(row: int, one: IngredientResult, evidence: Evidence) -> float:
    """Above each other where an ingredient was looked at in two models, in the middle where in one."""
    if len(one.evidence) == 1:
        return float(row)
    return row + (APART if evidence.full else -APART)


def _mark(colour: str, evidence: Evidence) -> dict[str, Any]:
    return {**MARK, "color": colour, "markerfacecolor": "white" if evidence.full else colour, "zorder": 5}


def _legend() -> list[Line2D]:
    mark = MARK | {"color": "#555555"}
    return [
        Line2D([], [], label="alone, in the minimal model", **mark),
        Line2D([], [], label="in the full model", markerfacecolor="white", **mark),
        Line2D([], [], color="#d0d0d0", linewidth=7.0, label="no cost, no change"),
    ]


# -- pages -------------------------------------------------------------------------------------------------------------

RULES: dict[str, Any] = {"verdicts": MEANINGS, "as_good": AS_GOOD, "no_change": NO_CHANGE, "costs": COSTS}


def merged(earlier: AblationStudy, new: AblationStudy) -> AblationStudy:
    """The new study with the engines that the earlier one looked at besides; none of another machine's."""
    if (earlier.kind, dict(earlier.parameters)) != (new.kind, dict(new.parameters)):
        return new
    known = {found.engine: found for found in (*earlier.engines, *new.engines)}
    return replace(new, engines=tuple(known.values()), unsupported={**earlier.unsupported, **new.unsupported})


def _figures(study: AblationStudy) -> dict[str, Figure]:
    """Engine -> its figure, of engines that have ingredients."""
    alt = f"Cost and change of every ingredient in {{}}, {study.name}"
    return {
        found.engine: Figure(
            f"{study.name}-{found.engine}", alt.format(engine_title(found.engine)), partial(ingredients_figure, found)
        )
        for found in study.engines
        if found.ingredients
    }


def _finding(found: EngineAblation) -> str:
    return f"{tables.speed_up(found)} {tables.left_out(found)}".strip()


def _page(part: Part[AblationStudy]) -> Page:
    figures = _figures(part.findings)
    names = {"figures": figures, "tables": tables, "title": engine_title, "finding": _finding}
    return Page(
        rendered("ablate", study=part.findings, command=part.command, **names, **RULES), tuple(figures.values())
    )


def _summary(study: AblationStudy) -> dict[str, Any]:
    return {
        "findings": {found.engine: _finding(found) for found in study.engines},
        "verdicts": {
            found.engine: {one.name: one.verdict.value for one in found.ingredients} for found in study.engines
        },
        "engines": {found.engine: found.version for found in study.engines},
        "machines": sorted({found.machine for found in study.engines}),
    }


def _index(index: Index[AblationStudy]) -> Page:
    studies = {name: index.findings(name) for name in index.entries}
    engines = dict.fromkeys(found.engine for study in studies.values() for found in study.engines)
    drawn = [figure for study in studies.values() for figure in _figures(study).values()]
    text = rendered(
        "ablate-index", entries=index.entries, headline=tables.full_table(studies), figure=drawn[0] if drawn else None,
        by_engine={engine_title(engine): tables.verdicts_table(engine, studies) for engine in engines},
        versions=index.versions, origin=index.origin, **RULES,
    )  # fmt: skip
    return Page(text)


KIND = Kind(
    name="ablate",
    findings=AblationStudy,
    title=lambda study: study.title,
    summary=_summary,
    page=_page,
    index=_index,
    merged=merged,
    digits=4,
)
