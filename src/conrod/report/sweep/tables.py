"""Tables of a sweep: choices, orders, what each knob does, what failed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import groupby

from conrod.engines.engine import STOCK
from conrod.report import numbers
from conrod.report.charts.styles import engine_title
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
from conrod.studies.sweep.findings import SweepStudy, SweptPoint, SweptRule

# A fitted floor is one where the errors come this near to it; far below them it is nothing that a run has shown.
NEAR_FLOOR = 20.0
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


# -- orders and knobs --------------------------------------------------------------------------------------------------


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


def orders_table(study: SweepStudy, presets_alone: bool = False) -> Table:
    """Order, plateau and floor of every rule, or of those that are presets."""
    presets = {(curve.engine, curve.rule): f" (`{curve.preset}`)" for curve in preset_curves(study)}
    rows = [
        [
            engine_title(rule.engine),
            rule.name + presets.get((rule.engine, rule.name), ""),
            rule.path,
            *(order_words(rule, study.points_of(rule), quantity) for quantity in QUANTITIES),
        ]
        for rule in study.rules
        if not presets_alone or (rule.engine, rule.name) in presets
    ]
    return table(["engine", "settings", "refined", *QUANTITIES], rows)


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
            ends = [span_words(list(group)) for _, group in groupby(points, lambda p: p.outcome)]
            counted = f"{failed} of {len(points)}"
            rows.append([engine_title(rule.engine), rule.name, counted, "; ".join(filter(None, ends))])
    return table(["engine", "settings", "runs that did not complete", f"{STEPS}: how they ended"], rows)


def span_words(group: Sequence[SweptPoint]) -> str:
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
