"""Error against steps along the refinement paths of a sweep, with order, plateau and floor."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from conrod.report import numbers
from conrod.report.charts.canvas import on_log_grid, whole_decades
from conrod.report.charts.errors import NORMS
from conrod.report.charts.styles import colour, engine_title, preset_style
from conrod.report.sweep.choice import cheapest_within, preset_curves
from conrod.report.sweep.fronts import TOLERANCES
from conrod.report.tables import table
from conrod.studies.frame.measurement import QUANTITIES
from conrod.studies.sweep.results import SweepStudy

if TYPE_CHECKING:
    from conrod.studies.sweep.observed_orders import ObservedOrders

OTHER_LINES: tuple[tuple[Any, str], ...] = (
    ((0, (3, 1, 1, 1)), "v"),
    ((0, (1, 1)), "X"),
    ((0, (6, 1, 1, 1, 1, 1)), "*"),
)
# A fitted floor is one where the errors come this near to it; far below them it is nothing that a run has shown.
NEAR_FLOOR = 20.0
FAILED_ABOVE, FAILED_APART = 1.03, 0.027  # of the panel's height


@dataclass(frozen=True)
class Drawn:
    """A path that the figure shows."""

    orders: ObservedOrders
    title: str
    style: Mapping[str, Any]


def principal_paths(study: SweepStudy) -> tuple[Drawn, ...]:
    """The presets, and of each engine the rules that are cheapest for some tolerance of position."""
    found = {(orders.engine, orders.label): orders for orders in study.orders}
    drawn: dict[tuple[str, str], Drawn] = {}
    for curve in preset_curves(study):
        key = (curve.engine, curve.rule)
        if key in found:
            title = f"{engine_title(curve.engine)} {curve.preset}"
            drawn.setdefault(key, Drawn(found[key], title, preset_style(curve.engine, curve.preset)))
    for engine in study.engines:
        cheapest = [cheapest_within(study, "position", allowed, engine) for allowed in TOLERANCES]
        rules = dict.fromkeys(point.rule for point in cheapest if point is not None)
        others = [(engine, rule) for rule in rules if (engine, rule) in found and (engine, rule) not in drawn]
        for key, (line, marker) in zip(others, OTHER_LINES, strict=False):
            style = preset_style(engine, None) | {"linestyle": line, "marker": marker, "markersize": 4.5}
            drawn[key] = Drawn(found[key], f"{engine_title(engine)}: {key[1]}", style)
    return tuple(drawn.values())


def orders_figure(study: SweepStudy) -> Figure | None:
    """A panel for each quantity; None where nothing completed."""
    paths = [path for path in principal_paths(study) if any(p.errors is not None for p in path.orders.points)]
    if not paths:
        return None
    figure = Figure(figsize=(10.5, 10.8))
    panels = figure.subplots(3, 1, sharex=True)
    steps = sorted({p.steps_per_revolution for path in paths for p in path.orders.points})
    for axes, quantity in zip(panels, QUANTITIES, strict=True):
        axes.set_xscale("log")
        whole_decades(axes, [_curve(axes, path, quantity)[1] for path in paths])
        for path in paths:
            _mark_end(axes, path, quantity)
        axes.set_ylabel(f"{quantity} error, max / {NORMS[quantity]}")
        axes.legend(loc="center left", bbox_to_anchor=(1.005, 0.5), handlelength=3.6, labelspacing=0.7, fontsize=7.0)
    _mark_failed(panels[0], paths)
    panels[-1].set_xlim(steps[0] / 1.2, steps[-1] * 1.2)
    shown = steps if len(steps) <= 10 else steps[:: -(-len(steps) // 10)]
    panels[-1].set_xticks(shown, [str(n) for n in shown])
    panels[-1].minorticks_off()
    panels[-1].set_xlabel("steps per revolution N (step of the crank angle h = 2π / N)")
    figure.align_ylabels(panels)
    figure.subplots_adjust(left=0.08, right=0.64, top=0.93, bottom=0.05, hspace=0.1)
    return figure


def _curve(axes: Axes, path: Drawn, quantity: str) -> tuple[Any, Any]:
    known = [(p.steps_per_revolution, p.errors[quantity]) for p in path.orders.points if p.errors is not None]
    steps, errors = np.array([float(n) for n, _ in known]), on_log_grid(np.array([e for _, e in known]))
    label = f"{path.title}:\n{in_words(path.orders, quantity)}"
    axes.plot(steps, errors, label=label, **path.style)
    return steps, errors


def _mark_end(axes: Axes, path: Drawn, quantity: str) -> None:
    """A broad pale line along a plateau; a dotted one at the floor of a curve that claims an order."""
    found = path.orders.orders[quantity]
    completed = [p.steps_per_revolution for p in path.orders.points if p.errors is not None]
    hue = colour(path.orders.engine)
    if found.plateau is not None:
        level = on_log_grid(np.array([found.plateau] * 2))
        axes.plot([completed[-3], completed[-1]], level, color=hue, alpha=0.2, linewidth=8.0, zorder=1)
    elif floor := floor_reached(path.orders, quantity):
        level = on_log_grid(np.array([floor] * 2))
        axes.plot([completed[-1] / 4.0, completed[-1] * 1.2], level, color=hue, linewidth=1.0, linestyle=":", zorder=1)


def _mark_failed(axes: Axes, paths: Sequence[Drawn]) -> None:
    """Runs that did not complete, above the first panel."""
    failed = [path for path in paths if path.orders.failed]
    for k, path in enumerate(failed):
        at = [p.steps_per_revolution for p in path.orders.failed]
        height = [FAILED_ABOVE + FAILED_APART * k] * len(at)
        style = dict(path.style) | {"linestyle": "none", "markersize": 5.0, "clip_on": False}
        axes.plot(at, height, transform=axes.get_xaxis_transform(), **style)
    if failed:
        place = (1.005, FAILED_ABOVE + 0.5 * FAILED_APART * (len(failed) - 1))
        axes.annotate("did not complete", place, xycoords="axes fraction", fontsize=7.5, va="center")


def floor_reached(orders: ObservedOrders, quantity: str) -> float | None:
    """The fitted floor of a path that claims an order, where its errors come near to it."""
    found = orders.orders[quantity]
    least = min((p.errors[quantity] for p in orders.points if p.errors is not None), default=None)
    if found.claimed is None or found.floor is None or least is None:
        return None
    return found.floor if 0.0 < least <= NEAR_FLOOR * found.floor else None


def in_words(orders: ObservedOrders, quantity: str) -> str:
    """Order, plateau and floor of one quantity, in one phrase."""
    found = orders.orders[quantity]
    if found.plateau is not None:
        return f"plateau at {numbers.measured(found.plateau)}"
    if found.claimed is None:
        return "no order claimed"
    floor = floor_reached(orders, quantity)
    said = f"order {numbers.order(found.claimed)}"
    return said if floor is None else f"{said}, floor {numbers.measured(floor)}"


def orders_table(study: SweepStudy, *, presets_only: bool = False) -> str:
    """Order, plateau and floor of every rule, or of the presets alone."""
    presets = {(curve.engine, curve.rule): curve.preset for curve in preset_curves(study)}
    rows = []
    for orders in study.orders:
        preset = presets.get((orders.engine, orders.label))
        if presets_only and preset is None:
            continue
        name = orders.label if preset is None else f"{orders.label} (`{preset}`)"
        found = [_full(orders, quantity) for quantity in QUANTITIES]
        rows.append([engine_title(orders.engine), name, orders.path, *found])
    return table(["engine", "settings", "what is refined", *QUANTITIES], rows)


def _full(orders: ObservedOrders, quantity: str) -> str:
    """As `in_words`, with the orders of the last pairs where none is claimed."""
    found = orders.orders[quantity]
    if found.plateau is None and found.claimed is None:
        pairs = [pair for pair in found.pairs if pair is not None][-3:]
        if pairs:
            return "none claimed: last pairs " + ", ".join(f"{round(pair, 1) + 0.0:.1f}" for pair in pairs)
    return in_words(orders, quantity)
