"""Error against steps along the refinement paths of a sweep, with order, plateau and floor."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from conrod.report import numbers
from conrod.report.charts.canvas import on_log_grid, whole_decades
from conrod.report.charts.layout import NORMS, steps_axis
from conrod.report.charts.styles import colour, engine_title, preset_style, preset_title
from conrod.report.sweep.points import cheapest_within, preset_curves
from conrod.report.table import Table, table
from conrod.studies.frame.measurement import QUANTITIES
from conrod.studies.sweep.findings import SweepStudy, SweptPoint, SweptRule

TOLERANCES = (1e-3, 1e-6, 1e-9)
OTHER_LINES: tuple[tuple[Any, str], ...] = (
    ((0, (3, 1, 1, 1)), "v"),
    ((0, (1, 1)), "X"),
    ((0, (6, 1, 1, 1, 1, 1)), "*"),
)
# A fitted floor is one where the errors come this near to it; far below them it is nothing that a run has shown.
NEAR_FLOOR = 20.0
FAILED_ABOVE, FAILED_APART = 1.03, 0.027  # of the panel's height


@dataclass(frozen=True)
class Path:
    """A rule that the figure shows, its completed points and the others, and how they are drawn."""

    rule: SweptRule
    points: Sequence[SweptPoint]
    failed: Sequence[SweptPoint]
    title: str
    style: Mapping[str, Any]

    def errors(self, quantity: str) -> list[float]:
        """Errors of the completed points, at increasing numbers of steps."""
        return [point.error(quantity) or 0.0 for point in self.points]


def principal_paths(study: SweepStudy) -> list[Path]:
    """The presets, and of each engine the rules that are cheapest for some tolerance of position, each curve once."""
    rules = {(rule.engine, rule.name): rule for rule in study.rules}
    shown: dict[tuple[str, str], tuple[str, Mapping[str, Any]]] = {}
    for curve in preset_curves(study):
        look = preset_title(curve.engine, curve.preset), preset_style(curve.engine, curve.preset)
        shown.setdefault((curve.engine, curve.rule), look)
    for engine in study.engines:
        cheapest = [cheapest_within(study.points, "position", allowed, engine) for allowed in TOLERANCES]
        others = dict.fromkeys((engine, p.rule) for p in cheapest if p is not None and (engine, p.rule) not in shown)
        for key, (line, marker) in zip(others, OTHER_LINES, strict=False):
            own = {"linestyle": line, "marker": marker, "markersize": 4.5}
            shown[key] = f"{engine_title(engine)}: {key[1]}", preset_style(engine, None) | own
    found: dict[str, Path] = {}
    for key, (title, style) in shown.items():
        points = study.points_of(rules[key]) if key in rules else []
        completed = [point for point in points if point.completed]
        # A knob that changes nothing would hide another curve.
        drawn = f"{key[0]} {[[f'{p.error(q):.1e}' for q in QUANTITIES] for p in completed]}"
        if completed and drawn not in found:
            failed = [point for point in points if not point.completed]
            found[drawn] = Path(rules[key], completed, failed, title, style)
    return list(found.values())


def orders_figure(study: SweepStudy) -> Figure:
    """The principal paths, of which there must be one: a panel for each quantity."""
    paths = principal_paths(study)
    figure = Figure(figsize=(10.5, 10.8))
    panels = figure.subplots(3, 1, sharex=True)
    for axes, quantity in zip(panels, QUANTITIES, strict=True):
        axes.set_xscale("log")
        whole_decades(axes, [on_log_grid(np.array(path.errors(quantity))) for path in paths])
        for path in paths:
            _draw(axes, path, quantity)
        axes.set_ylabel(f"{quantity} error, max / {NORMS[quantity]}")
        axes.legend(loc="center left", bbox_to_anchor=(1.005, 0.5), handlelength=3.6, labelspacing=0.7, fontsize=7.0)
    _mark_failed(panels[0], [path for path in paths if path.failed])
    steps_axis(
        panels[-1], sorted({p.steps_per_revolution for path in paths for p in (*path.points, *path.failed)}), 1.2
    )
    figure.align_ylabels(panels)
    figure.subplots_adjust(left=0.08, right=0.64, top=0.93, bottom=0.05, hspace=0.1)
    return figure


def _draw(axes: Axes, path: Path, quantity: str) -> None:
    """A curve, a broad pale line along its plateau, and a dotted one at the floor of one that claims an order."""
    steps = [point.steps_per_revolution for point in path.points]
    label = f"{path.title}:\n{order_words(path.rule, path.points, quantity)}"
    axes.plot(steps, on_log_grid(np.array(path.errors(quantity))), label=label, **path.style)
    plateau, floor = path.rule.orders[quantity].plateau, floor_reached(path.rule, path.points, quantity)
    ends, level = (
        ([steps[-3], steps[-1]], plateau) if plateau is not None else ([steps[-1] / 4, steps[-1] * 1.2], floor)
    )
    if level:
        broad = {"alpha": 0.2, "linewidth": 8.0} if plateau is not None else {"linewidth": 1.0, "linestyle": ":"}
        axes.plot(ends, on_log_grid(np.array([level] * 2)), color=colour(path.rule.engine), zorder=1, **broad)


def _mark_failed(axes: Axes, failed: Sequence[Path]) -> None:
    """Runs that did not complete, above the first panel."""
    for k, path in enumerate(failed):
        at = [point.steps_per_revolution for point in path.failed]
        style = dict(path.style) | {"linestyle": "none", "markersize": 5.0, "clip_on": False}
        axes.plot(at, [FAILED_ABOVE + FAILED_APART * k] * len(at), transform=axes.get_xaxis_transform(), **style)
    if failed:
        place = (1.005, FAILED_ABOVE + 0.5 * FAILED_APART * (len(failed) - 1))
        axes.annotate("did not complete", place, xycoords="axes fraction", fontsize=7.5, va="center")


# -- words -------------------------------------------------------------------------------------------------------------


def floor_reached(rule: SweptRule, points: Sequence[SweptPoint], quantity: str) -> float | None:
    """The fitted floor of a path that claims an order, where its errors come near to it."""
    found = rule.orders[quantity]
    least = min((p.error(quantity) or 0.0 for p in points if p.completed), default=0.0)
    if found.claimed is None or found.floor is None:
        return None
    return found.floor if 0.0 < least <= NEAR_FLOOR * found.floor else None


def order_words(rule: SweptRule, points: Sequence[SweptPoint], quantity: str) -> str:
    """Order, plateau and floor of one quantity, in one phrase."""
    found = rule.orders[quantity]
    if found.plateau is not None:
        return f"plateau at {numbers.measured(found.plateau)}"
    if found.claimed is None:
        return "no order claimed"
    floor = floor_reached(rule, points, quantity)
    order = f"order {numbers.order(found.claimed)}"
    return order if floor is None else f"{order}, floor {numbers.measured(floor)}"


def orders_table(study: SweepStudy) -> Table:
    """Order, plateau and floor of every rule."""
    presets = {(curve.engine, curve.rule): f" (`{curve.preset}`)" for curve in preset_curves(study)}
    rows = [
        [
            engine_title(rule.engine),
            rule.name + presets.get((rule.engine, rule.name), ""),
            rule.path,
            *(order_words(rule, study.points_of(rule), quantity) for quantity in QUANTITIES),
        ]
        for rule in study.rules
    ]
    return table(["engine", "settings", "refined", *QUANTITIES], rows)
