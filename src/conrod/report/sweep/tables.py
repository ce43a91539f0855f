"""Tables of a sweep: choices, what each preset and knob does, what failed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import groupby

from conrod.engines.engine import STOCK
from conrod.report import numbers
from conrod.report.charts.styles import engine_title, preset_title
from conrod.report.sweep.error_tables import order_words
from conrod.report.sweep.points import (
    TOLERANCES,
    cheapest_within,
    front_points,
    least_error,
    preset_curves,
    rule_of,
    timed_engines,
    tolerance,
)
from conrod.report.table import Table, table
from conrod.studies.frame.measurement import QUANTITIES
from conrod.studies.sweep.error_budget import ErrorBudget
from conrod.studies.sweep.findings import SweepStudy, SweptPoint, SweptRule

QUANTITY, ALLOWED = "position", 1e-6  # that presets and knobs are compared at
STEPS = "steps per revolution"
COST_HEAD = ["CPU time a revolution", "in steps of the reference loop"]
CHEAPEST_HEAD = ["within", "engine", "cheapest settings", STEPS, "error", *COST_HEAD]
FRONT_HEAD = ["point", "setting", "steps/rev", "position", "[mm]", "velocity", "accel.", "ms/rev", "ratio"]
RATIO = "ratio: a revolution costs as much as so many steps of the engine's fixed reference loop"


# -- choices -----------------------------------------------------------------------------------------------------------


def fronts_table(study: SweepStudy, quantities: Sequence[str] = QUANTITIES, title: str = "") -> Table:
    """Every point on the front of its engine for some quantities, and for which, where they are several."""
    rows = [
        [
            point.label,
            f"{engine_title(point.engine)}: {rule_of(point)}",
            str(point.steps_per_revolution),
            *_errors(study, point),
            *(numbers.measured(None if point.cost is None else 1e3 * point.cost), numbers.measured(point.ratio)),
            *([", ".join(fronts)] if len(quantities) > 1 else []),
        ]
        for point, fronts in front_points(study)
        if fronts.keys() & set(quantities)
    ]
    head = [*FRONT_HEAD, *(["on the front for"] if len(quantities) > 1 else [])]
    return table(head, rows, right=FRONT_HEAD[2:], title=title)


def _errors(study: SweepStudy, point: SweptPoint) -> list[str]:
    position, *others = (numbers.measured(point.error(quantity)) for quantity in QUANTITIES)
    return [position, numbers.in_mm(point.error(QUANTITY), study.lengths), *others]


def _costs(point: SweptPoint) -> list[str]:
    return [numbers.duration(point.cost), numbers.measured(point.ratio)]


def cheapest_rows(study: SweepStudy, quantity: str, tolerances: Sequence[float]) -> list[list[str]]:
    """For each tolerance and engine the cheapest setting within it, or how near it comes; none without costs.

    An engine that a tolerance is too tight for is left out of tighter ones.
    """
    rows, beyond = [], set[str]()
    for allowed in sorted(tolerances, reverse=True):
        for engine in (e for e in timed_engines(study) if e not in beyond):
            best = cheapest_within(study.points, quantity, allowed, engine)
            if best is None:
                beyond.add(engine)
                least = numbers.measured(least_error(study, quantity, engine))
                choice = [f"none of the grid; the least error is {least}", *[numbers.MISSING] * 4]
            else:
                choice = [f"{rule_of(best)} ({best.label})", str(best.steps_per_revolution)]
                choice += [numbers.error(quantity, best.error(quantity), study.lengths), *_costs(best)]
            rows.append([tolerance(allowed), engine_title(engine), *choice])
    return rows


def cheapest_table(study: SweepStudy, quantities: Sequence[str] = QUANTITIES) -> Table:
    """The cheapest setting of each engine for several tolerances of each quantity."""
    rows = [[q, *row] for q in quantities for row in cheapest_rows(study, q, TOLERANCES)]
    return table(["error of", *CHEAPEST_HEAD], rows, right=CHEAPEST_HEAD[3:])


def findings(study: SweepStudy) -> list[str]:
    """For each engine with timings the cheapest setting within the tolerance, and whether it gets there as it comes."""
    found = []
    for engine in timed_engines(study):
        best = cheapest_within(study.points, QUANTITY, ALLOWED, engine)
        least, stock = (least_error(study, QUANTITY, engine, preset) for preset in (None, STOCK))
        title, error = engine_title(engine), f"position error of {tolerance(ALLOWED)} L"
        if best is None:
            text = (
                f"**No setting of {title} in the grid has a {error} or less**; the least is {numbers.measured(least)}."
            )
        else:
            setting = f"{rule_of(best)}, at {best.steps_per_revolution} steps per revolution ({best.label})"
            cost = numbers.duration(best.cost)
            text = f"**The cheapest setting of {title} for a {error}** is {setting}: {cost} of CPU time a revolution."
        never = f" The {STOCK} settings never get there: their least error is {numbers.measured(stock)} L."
        found.append(text + (never if stock is not None and stock > ALLOWED else ""))
    return found


# -- presets and knobs -------------------------------------------------------------------------------------------------


def presets_table(study: SweepStudy) -> Table:
    """What each preset's position error does as the step is refined, and what it is made of."""
    rules = {(rule.engine, rule.name): rule for rule in study.rules}
    budgets = {(budget.engine, budget.preset): budget for budget in study.budgets}
    rows = []
    for curve in preset_curves(study):
        preset, rule = (curve.engine, curve.preset), rules.get((curve.engine, curve.rule))
        rows.append(
            [
                preset_title(*preset),
                order_words(rule, study.points_of(rule), QUANTITY) if rule else numbers.MISSING,
                *_parts(budgets.get(preset)),
            ]
        )
    head = ["preset", "position error, as the step is refined", "at", "whole", "iteration", "step", "model"]
    return table(head, rows, right=head[2:])


def _parts(budget: ErrorBudget | None) -> list[str]:
    """Steps, the position error at them, and its parts."""
    if budget is None:
        return [numbers.MISSING] * 5
    norms = {part.name: part.norms[QUANTITY] for part in budget.parts if part.norms is not None}
    sizes = [
        numbers.MISSING if norm is None else numbers.measured(norm.max) if norm.resolved else "not resolved"
        for norm in map(norms.get, ("total", "iteration", "step", "model"))
    ]
    steps = budget.settings.get("steps_per_revolution", numbers.MISSING)
    return [str(steps), *sizes]


def knobs_table(study: SweepStudy) -> Table:
    """What each knob is worth: the cheapest settings for a position error of 1e-6, and without it."""
    rules = {(rule.engine, rule.name): rule for rule in study.rules}
    rows = []
    for engine in timed_engines(study):
        best = cheapest_within(study.points, QUANTITY, ALLOWED, engine)
        if best is None:
            continue
        for knob, value in rules[engine, best.rule].knobs.items():
            others = [p for p in study.points if p.engine == engine and _way(p, knob, rules) != _way(best, knob, rules)]
            other = cheapest_within(others, QUANTITY, ALLOWED, engine)
            if other:
                factor = (other.cost or 0.0) / (best.cost or 1.0)
                order, other_order = (
                    numbers.order(rules[engine, p.rule].orders[QUANTITY].claimed) for p in (best, other)
                )
                setting = f"{rule_of(other)}, {other.steps_per_revolution} steps ({other.label})"
                cells = [
                    value,
                    order,
                    setting,
                    other_order,
                    f"{numbers.duration(other.cost)} (x {numbers.measured(factor)})",
                ]
            elif others:
                cells = [value, numbers.MISSING, "none reaches it", *[numbers.MISSING] * 2]
            else:
                continue
            rows.append([engine_title(engine), f"`{knob}`", *cells])
    head = ["engine", "knob", "set to", "order", "cheapest where it is set otherwise", "order then", "cost then"]
    return table(head, rows)


def _way(point: SweptPoint, knob: str, rules: Mapping[tuple[str, str], SweptRule]) -> str | None:
    """What a knob is set to; `hardened 1e-9` and `hardened 1e-6` are one way of setting it."""
    value = rules[point.engine, point.rule].knobs.get(knob)
    word = (value or "").partition(" ")[0]
    return word if word.isalpha() else value


# -- the grid ----------------------------------------------------------------------------------------------------------


def failures_table(study: SweepStudy) -> Table:
    """Rules with runs that did not complete, and how these end at which numbers of steps."""
    rows = []
    for rule in study.rules:
        points = study.points_of(rule)
        failed = sum(not point.completed for point in points)
        if failed:
            ends = [_span(list(group)) for _, group in groupby(points, lambda p: p.outcome)]
            counted = f"{failed} of {len(points)}"
            rows.append([engine_title(rule.engine), rule.name, counted, "; ".join(filter(None, ends))])
    return table(["engine", "settings", "runs that did not complete", f"{STEPS}: how they ended"], rows)


def _span(group: Sequence[SweptPoint]) -> str:
    """Neighbouring numbers of steps with one outcome: `20 to 100: diverged`; empty where the runs completed."""
    first, last = group[0], group[-1]
    if first.completed:
        return ""
    steps = dict.fromkeys(point.steps_per_revolution for point in (first, last))
    reasons = {point.reason for point in group if point.outcome == "unsupported"}
    reason = f" ({reasons.pop()})" if len(reasons) == 1 else ""
    return f"{' to '.join(map(str, steps))}: {first.outcome}{reason}"


def counts_table(study: SweepStudy) -> Table:
    """Numbers of settings and runs of each engine, and what a sweep has that it lacks."""
    rows = []
    for engine in study.engines:
        points = [point for point in study.points if point.engine == engine]
        counts = (len({point.rule for point in points}), len(points), sum(point.completed for point in points))
        rows.append([engine_title(engine), *map(str, counts), study.unsupported.get(engine, "")])
    rows += [[engine_title(e), *["0"] * 3, why] for e, why in study.unsupported.items() if e not in study.engines]
    return table(
        ["engine", "settings", "runs", "completed", "unsupported"], rows, right=["settings", "runs", "completed"]
    )
