"""Error budgets: the parts of the iteration, the step and the model itself."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from conrod.report import numbers
from conrod.report.charts.canvas import on_log_grid
from conrod.report.charts.layout import NORMS, log_axis, rows_axis
from conrod.report.charts.styles import colour, preset_title
from conrod.report.table import Table, table
from conrod.studies.frame.measurement import QUANTITIES
from conrod.studies.sweep.error_budget import ErrorBudget, Norm, Part
from conrod.studies.sweep.findings import SweepStudy

# The parts that stand in the figure: name -> marker, size, words.
SHOWN = {
    "total": ("|", 13.0, "whole error"),
    "iteration": ("o", 6.0, "iteration: stopping early"),
    "step": ("s", 5.5, "step: its finite length"),
    "model": ("^", 6.5, "model: softness, at no step"),
    "regularisation, this step": ("D", 4.5, "what regularisation changes"),
    "stabilisation, this step": ("v", 6.0, "what stabilisation changes"),
}


def title_of(budget: ErrorBudget) -> str:
    """Engine, preset and steps."""
    steps = budget.settings.get("steps_per_revolution")
    return f"{preset_title(budget.engine, budget.preset)}" + ("" if steps is None else f", {steps} steps")


def budget_table(budget: ErrorBudget) -> Table:
    """A row for each part, with the size that the engine's law predicts where it has one."""
    lawful = any(part.predicted is not None for part in budget.parts)
    rows = [[_name(part), *_norms(part), *(_law(part) if lawful else [])] for part in budget.parts]
    head = ["part", *(f"{q}: max, rms (known to)" for q in QUANTITIES)]
    return table([*head, *(["position, by the law", "cause"] if lawful else [])], rows)


def _name(part: Part) -> str:
    changes = (f"`{key}` {setting_value(old)} to {setting_value(new)}" for key, (old, new) in part.changes.items())
    return f"{part.name}: {', '.join(changes)}" if part.changes else part.name


def setting_value(value: Any) -> str:
    """A setting's value, short."""
    match value:
        case None:
            return "none"
        case bool():
            return "yes" if value else "no"
        case float():
            return numbers.quantity(value, 3)
        case list() | tuple():
            return "(" + ", ".join(setting_value(part) for part in value) + ")"
        case _:
            return str(value)


def _norms(part: Part) -> list[str]:
    if part.norms is None:
        missing = ", ".join(f"{role}: {outcome}" for role, outcome in part.missing.items())
        return [f"unknown ({missing})", *[numbers.MISSING] * (len(QUANTITIES) - 1)]
    return [_norm(part.norms[quantity]) for quantity in QUANTITIES]


def _norm(norm: Norm) -> str:
    known = "" if norm.known_to is None else f" ({numbers.measured(norm.known_to)})"
    zero = "" if norm.resolved else ", not resolved"
    return f"{numbers.measured(norm.max)}, {numbers.measured(norm.rms)}{known}{zero}"


def _law(part: Part) -> list[str]:
    predicted = numbers.measured(part.predicted)
    if part.predicted is None or part.norms is None:
        return [predicted, ""]
    position = part.norms["position"]
    if not position.resolved:
        return [predicted, "not named: not resolved"]
    # Two sizes that are both rounding agree about nothing.
    if position.max < numbers.ROUNDING:
        return [predicted, "not named: rounding"]
    return [predicted, "the law's" if part.named else "not named: the law does not give the size"]


# -- figure ------------------------------------------------------------------------------------------------------------


def known_budgets(study: SweepStudy) -> list[ErrorBudget]:
    """Budgets of which a part is known."""
    return [budget for budget in study.budgets if any(part.norms is not None for part in budget.parts)]


def budgets_figure(study: SweepStudy) -> Figure:
    """The parts of every known budget beside each other, a panel for each quantity."""
    budgets = known_budgets(study)
    height = 0.95 * len(budgets) + 1.5
    figure = Figure(figsize=(10.5, height))
    panels = figure.subplots(1, 3, sharey=True)
    for axes, quantity in zip(panels, QUANTITIES, strict=True):
        for place, budget in enumerate(budgets):
            _draw(axes, place, budget, quantity)
        _error_axis(axes, _largest(budgets, quantity))
        axes.set_xlabel(f"{quantity}, max / {NORMS[quantity]}")
        rows_axis(axes, [title_of(budget).replace(", ", ",\n") for budget in budgets], 0.45)
        axes.grid(visible=False, axis="y")
        for place in range(len(budgets) - 1):
            axes.axhline(place + 0.5, color="#bbbbbb", linewidth=0.6)
    handles, labels = panels[0].get_legend_handles_labels()
    known = dict(zip(labels, handles, strict=True))
    at = (0.5, 1.0 - 0.05 / height)
    figure.legend(list(known.values()), list(known), loc="upper center", ncol=3, bbox_to_anchor=at)
    figure.subplots_adjust(left=0.16, right=0.98, top=1.0 - 0.72 / height, bottom=0.5 / height, wspace=0.08)
    return figure


def _largest(budgets: Sequence[ErrorBudget], quantity: str) -> float:
    sizes = [part.norms[quantity].max for budget in budgets for part in budget.parts if part.norms is not None]
    return max([*sizes, 1e3 * numbers.ROUNDING])


def _draw(axes: Axes, place: int, budget: ErrorBudget, quantity: str) -> None:
    known = {part.name: part.norms[quantity] for part in budget.parts if part.norms is not None}
    for lane, (name, (marker, size, words)) in enumerate(SHOWN.items()):
        if name not in known:
            continue
        norm, hue = known[name], colour(budget.engine)
        axes.plot(
            on_log_grid(np.array([norm.max])), [place + 0.14 * (lane - 0.5 * (len(SHOWN) - 1))], linestyle="none",
            marker=marker, markersize=size, color=hue, markeredgewidth=2.0 if marker == "|" else 1.0,
            markerfacecolor=hue if norm.resolved and norm.max >= numbers.ROUNDING else "white",
        )  # fmt: skip
        if place == 0:
            axes.plot([], [], linestyle="none", marker=marker, markersize=size, color="#444444", label=words)


def _error_axis(axes: Axes, largest: float) -> None:
    """A logarithmic axis from rounding on; a shade where only rounding is."""
    lowest, top = round(np.log10(numbers.ROUNDING)), int(np.ceil(np.log10(largest) - 1e-6))
    edge = 10.0 ** (lowest - 0.6)
    decades = range(lowest, top + 1, max(1, (top - lowest) // 4))
    log_axis(axes, (edge, 10.0 ** (top + 0.4)), [10.0**k for k in decades])
    axes.axvspan(edge, numbers.ROUNDING, color="#eeeeee", zorder=0, linewidth=0)
