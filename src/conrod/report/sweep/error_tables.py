"""Tables of a sweep on errors: order, plateau and floor; bands of convergence alone that hold them; their parts."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product
from statistics import median

from conrod.report import numbers
from conrod.report.charts.styles import engine_title, preset_title
from conrod.report.sweep.points import preset_curves
from conrod.report.table import Table, table
from conrod.studies.frame.measurement import QUANTITIES
from conrod.studies.sweep.error_budget import ErrorBudget, Norm, Part
from conrod.studies.sweep.findings import SweepStudy, SweptPoint, SweptRule
from conrod.studies.sweep.grid_convergence import Share
from conrod.studies.validation.refinement import PATHS

# A fitted floor is one where the errors come this near to it; far below them it is nothing that a run has shown.
NEAR_FLOOR = 20.0
COUNTS = ("contained", "missed", "at_rounding", "unreasonable", "oscillating")


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


# -- bands -------------------------------------------------------------------------------------------------------------


def pooled(shares: Sequence[Share]) -> Share:
    """The shares of several rules, added up; their ratio is the median over the rules."""
    ratios = [share.ratio for share in shares if share.ratio is not None]
    counts = {name: sum(getattr(share, name) for share in shares) for name in COUNTS}
    return Share(**counts, ratio=median(ratios) if ratios else None)


def shares_table(study: SweepStudy) -> Table:
    """Counts and shares, of all settings and of the presets, each refined both ways from the same settings."""
    every = [
        ("all settings", [one for one in study.grid_convergence if (one.engine, one.path) == way and one.shares])
        for way in product(study.engines, PATHS)
    ]
    presets = [(f"`{one.label}`", [one]) for one in study.both_ways if one.shares]
    rows = []
    for title, rules in (*(found for found in every if found[1]), *presets):
        for quantity in QUANTITIES:
            found = pooled([rule.shares[quantity] for rule in rules])
            sizes = (f"**{numbers.percent(found.share)}**", numbers.measured(found.ratio))
            counted = (found.unreasonable, found.oscillating, found.at_rounding)
            who = (engine_title(rules[0].engine), title, rules[0].path, quantity, str(found.judged))
            rows.append((*who, *sizes, *map(str, counted)))
    head = ["engine", "settings", "refined", "quantity", "cells", "band holds the error", "band / error, median"]
    counts = ["of the cells with factor 3", "of these oscillating", "besides, at rounding"]
    return table([*head, *counts], rows, right=[*head[4:], *counts])


# -- error budgets -----------------------------------------------------------------------------------------------------


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
