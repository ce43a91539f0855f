"""Tables of a sweep on errors: order, plateau and floor, and their parts."""

from __future__ import annotations

from collections.abc import Sequence

from conrod.report import numbers
from conrod.report.charts.styles import engine_title, preset_title
from conrod.report.sweep.points import preset_curves
from conrod.report.table import Table, table
from conrod.studies.frame.measurement import QUANTITIES
from conrod.studies.sweep.error_budget import ErrorBudget, Norm, Part
from conrod.studies.sweep.findings import SweepStudy, SweptPoint, SweptRule

# A fitted floor is one where the errors come this near to it; far below them it is nothing that a run has shown.
NEAR_FLOOR = 20.0


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


# -- error budgets -----------------------------------------------------------------------------------------------------


def title_of(budget: ErrorBudget) -> str:
    """Engine, preset and steps."""
    steps = budget.settings.get("steps_per_revolution")
    return preset_title(budget.engine, budget.preset) + ("" if steps is None else f", {steps} steps")


def budget_table(budget: ErrorBudget) -> Table:
    """A row for each part."""
    rows = [[_name(part), *_norms(part)] for part in budget.parts]
    return table(["part", *(f"{q}: max, rms (known to)" for q in QUANTITIES)], rows)


def _name(part: Part) -> str:
    changes = (f"`{key}` {numbers.setting(old)} to {numbers.setting(new)}" for key, (old, new) in part.changes.items())
    return f"{part.name}: {', '.join(changes)}" if part.changes else part.name


def _norms(part: Part) -> list[str]:
    if part.norms is None:
        missing = ", ".join(f"{role}: {outcome}" for role, outcome in part.missing.items())
        return [f"unknown ({missing})", *[numbers.MISSING] * (len(QUANTITIES) - 1)]
    return [_norm(part.norms[quantity]) for quantity in QUANTITIES]


def _norm(norm: Norm) -> str:
    known = "" if norm.known_to is None else f" ({numbers.measured(norm.known_to)})"
    zero = "" if norm.resolved else ", not resolved"
    return f"{numbers.measured(norm.max)}, {numbers.measured(norm.rms)}{known}{zero}"
