"""Error budgets: the parts of the iteration, the step and the model itself."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from conrod.report import numbers
from conrod.report.charts.canvas import on_log_grid
from conrod.report.charts.layout import NORMS, Layout, log_axis, rows_axis
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
LANE = 0.14  # of a row: the parts above each other


def title_of(budget: ErrorBudget) -> str:
    """Engine, preset and steps."""
    steps = budget.settings.get("steps_per_revolution")
    return preset_title(budget.engine, budget.preset) + ("" if steps is None else f", {steps} steps")


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
        case float():
            return numbers.quantity(value, 3)
        case list() | tuple():
            return "(" + ", ".join(map(setting_value, value)) + ")"
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
    """The size that the law predicts, and whether it names the cause."""
    position = part.norms["position"] if part.norms is not None else None
    if part.predicted is None or position is None:
        named = ""
    elif not position.resolved:
        named = "not named: not resolved"
    elif position.max < numbers.ROUNDING:  # two sizes that are both rounding agree about nothing
        named = "not named: rounding"
    else:
        named = "the law's" if part.named else "not named: the law does not give the size"
    return [numbers.measured(part.predicted), named]


# -- figure ------------------------------------------------------------------------------------------------------------


def known_budgets(study: SweepStudy) -> list[ErrorBudget]:
    """Budgets of which a part is known."""
    return [budget for budget in study.budgets if any(part.norms is not None for part in budget.parts)]


def budgets_figure(study: SweepStudy) -> Figure:
    """The parts of every known budget beside each other, a panel for each quantity."""
    budgets = known_budgets(study)
    rows = 0.95 * len(budgets)
    layout = Layout(10.5, rows + 1.3)
    for k, quantity in enumerate(QUANTITIES):
        axes = layout.axes(1.7 + 2.95 * k, 0.5, 2.75, rows)
        sizes = [0.0]
        for place, budget in enumerate(budgets):
            known = {part.name: part.norms[quantity] for part in budget.parts if part.norms is not None}
            hue = colour(budget.engine)
            for lane, (name, (marker, size, _)) in enumerate(SHOWN.items()):
                if name in known:
                    sizes.append(known[name].max)
                    filled = known[name].resolved and known[name].max >= numbers.ROUNDING
                    style = _mark(marker, size, hue) | {"markerfacecolor": hue if filled else "white"}
                    at = place + LANE * (lane - 0.5 * (len(SHOWN) - 1))
                    axes.plot(on_log_grid(np.array([known[name].max])), [at], **style)
        # From rounding on; a shade where only rounding is.
        top = int(np.ceil(np.log10(max(*sizes, 1e3 * numbers.ROUNDING)) - 1e-6))
        lowest = round(np.log10(numbers.ROUNDING))
        edge = 10.0 ** (lowest - 0.6)
        ticks = [10.0**n for n in range(lowest, top + 1, max(1, (top - lowest) // 4))]
        log_axis(axes, (edge, 10.0 ** (top + 0.4)), ticks)
        axes.axvspan(edge, numbers.ROUNDING, color="#eeeeee", zorder=0, linewidth=0)
        axes.set_xlabel(f"{quantity}, max / {NORMS[quantity]}")
        rows_axis(axes, [title_of(budget).replace(", ", ",\n") if k == 0 else "" for budget in budgets], 0.45)
        axes.grid(visible=False, axis="y")
        for place in range(len(budgets) - 1):
            axes.axhline(place + 0.5, color="#bbbbbb", linewidth=0.6)
    handles = [Line2D([], [], label=words, **_mark(marker, size, "#444444")) for marker, size, words in SHOWN.values()]
    layout.legend(handles, 3)
    return layout.figure


def _mark(marker: str, size: float, hue: str) -> dict[str, Any]:
    wide = 2.0 if marker == "|" else 1.0
    return {"linestyle": "none", "marker": marker, "markersize": size, "color": hue, "markeredgewidth": wide}
