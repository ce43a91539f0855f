"""Tables of a sweep: points worth choosing, runs that failed, knobs, masses and gravity, transfers, predictions."""

from __future__ import annotations

from collections.abc import Sequence

from conrod.report import numbers
from conrod.report.charts.styles import engine_title
from conrod.report.sweep.selection import (
    cheapest_within,
    labelled_points,
    most_accurate,
    rule_of,
    timed_engines,
    tolerance,
)
from conrod.report.table import Table, table
from conrod.studies.frame.measurement import QUANTITIES
from conrod.studies.recommend.transfer import Transfer
from conrod.studies.sweep.findings import COMPLETED, SweepStudy, SweptPoint
from conrod.studies.sweep.sensitivity import GRAVITY, Sensitivity, Variation

MORE_TOLERANCES = (1e-2, 1e-3, 1e-4, 1e-6, 1e-9)
STEPS = "steps per revolution"
COST_HEAD = ["CPU time a revolution", "in steps of the reference loop"]
CHEAPEST_HEAD = ["within", "engine", "cheapest settings", STEPS, "error", *COST_HEAD]


FRONT_HEAD = ["point", "setting", "steps/rev", "position", "velocity", "accel.", "ms/rev", "ratio"]
RATIO = "ratio: a revolution costs as much as so many steps of the engine's fixed reference loop"


def front_table(study: SweepStudy) -> Table:
    """For a terminal, in 80 columns: settings of each engine that no other one beats in both cost and position."""
    rows = [
        [
            point.label,
            f"{point.engine}: {point.rule}" + (f" [{point.preset}]" if point.preset else ""),
            str(point.steps_per_revolution),
            *(numbers.measured(point.error(quantity)) for quantity in QUANTITIES),
            *(numbers.measured(None if point.cost is None else 1e3 * point.cost), numbers.measured(point.ratio)),
        ]
        for point, _ in labelled_points(study, ("position",))
    ]
    title = f"{study.name}: settings that none beats in both cost and position"
    return table(FRONT_HEAD, rows, right=FRONT_HEAD[2:], title=title)


def labelled_table(study: SweepStudy) -> Table:
    """Every point on the front of its engine for a quantity: those that the diagram names."""
    rows = [
        [
            point.label,
            engine_title(point.engine),
            rule_of(point),
            str(point.steps_per_revolution),
            *(numbers.measured(point.error(quantity)) for quantity in QUANTITIES),
            *costs_of(point),
            ", ".join(f"**{q}**" if on_all else q for q, on_all in fronts.items()),
        ]
        for point, fronts in labelled_points(study)
    ]
    head = ["point", "engine", "settings", STEPS, *(f"{q} error" for q in QUANTITIES), *COST_HEAD]
    return table([*head, "on the front for"], rows, right=head[3:])


def costs_of(point: SweptPoint) -> list[str]:
    """Two cells: CPU time of a revolution, and the same in steps of the engine's reference loop."""
    return [numbers.duration(point.cost), numbers.measured(point.ratio)]


def cheapest_rows(study: SweepStudy, quantity: str, tolerances: Sequence[float]) -> list[list[str]]:
    """For each tolerance and engine the cheapest setting within it, or how near it comes; none without costs.

    An engine that a tolerance is too tight for is left out of tighter ones.
    """
    rows, beyond = [], set[str]()
    for allowed in sorted(tolerances, reverse=True):
        for engine in (e for e in timed_engines(study) if e not in beyond):
            best = cheapest_within(study, quantity, allowed, engine)
            rows.append([tolerance(allowed), engine_title(engine), *_choice(study, quantity, best, engine)])
            if best is None:
                beyond.add(engine)
    return rows


def _choice(study: SweepStudy, quantity: str, best: SweptPoint | None, engine: str) -> list[str]:
    if best is None:
        nearest = most_accurate(study, quantity, engine)
        reached = numbers.measured(None if nearest is None else nearest.error(quantity))
        return [f"none of the grid; the least error is {reached}", *[numbers.MISSING] * 4]
    steps, error = str(best.steps_per_revolution), numbers.measured(best.error(quantity))
    return [f"{rule_of(best)} ({best.label})", steps, error, *costs_of(best)]


def cheapest_table(study: SweepStudy, quantities: Sequence[str] = QUANTITIES) -> Table:
    """The cheapest setting of each engine for several tolerances of each quantity."""
    rows = [[q, *row] for q in quantities for row in cheapest_rows(study, q, MORE_TOLERANCES)]
    return table(["error of", *CHEAPEST_HEAD], rows, right=CHEAPEST_HEAD[3:])


# -- the grid ----------------------------------------------------------------------------------------------------------


def failures_table(study: SweepStudy) -> Table:
    """Rules with runs that did not complete, and how these end at which numbers of steps."""
    rows = []
    for rule in study.rules:
        points = study.points_of(rule)
        failed = sum(not point.completed for point in points)
        if failed:
            counted = f"{failed} of {len(points)}"
            rows.append([engine_title(rule.engine), rule.name, counted, "; ".join(outcome_spans(points))])
    return table(["engine", "settings", "runs that did not complete", f"{STEPS}: how they ended"], rows)


def outcome_spans(points: Sequence[SweptPoint]) -> list[str]:
    """Neighbouring numbers of steps with one outcome, together: `20 to 100: diverged`."""
    groups: list[list[SweptPoint]] = []
    for point in points:
        if groups and groups[-1][0].outcome == point.outcome:
            groups[-1].append(point)
        else:
            groups.append([point])
    spans = []
    for group in (group for group in groups if not group[0].completed):
        first, last = group[0].steps_per_revolution, group[-1].steps_per_revolution
        reasons = {point.reason for point in group if point.outcome == "unsupported"}
        reason = f" ({next(iter(reasons))})" if len(reasons) == 1 else ""
        spans.append(f"{first if first == last else f'{first} to {last}'}: {group[0].outcome}{reason}")
    return spans


def knobs_table(study: SweepStudy) -> Table:
    """Knobs and their values, the number of steps among them."""
    rows = []
    for engine in study.engines:
        steps = sorted({point.steps_per_revolution for point in study.points if point.engine == engine})
        rows.append([engine_title(engine), STEPS, ", ".join(map(str, steps))])
        rules = [rule for rule in study.rules if rule.engine == engine]
        for knob in dict.fromkeys(name for rule in rules for name in rule.knobs):
            values = dict.fromkeys(rule.knobs[knob] for rule in rules if knob in rule.knobs)
            rows.append([engine_title(engine), f"`{knob}`", ", ".join(values)])
    return table(["engine", "knob", "values"], rows)


def grid_words(study: SweepStudy) -> str:
    """Numbers of settings and runs, in a sentence."""
    parts = []
    for engine in study.engines:
        points = [point for point in study.points if point.engine == engine]
        completed, rules = sum(point.completed for point in points), len({point.rule for point in points})
        parts.append(f"{engine_title(engine)} {rules} settings in {len(points)} runs, of which {completed} completed")
    parts += [f"{engine_title(engine)} unsupported: {why}" for engine, why in study.unsupported.items()]
    return f"The grid `{study.grid}`: " + "; ".join(parts) + "."


# -- masses, gravity and transfers -------------------------------------------------------------------------------------


def variations_table(study: SweepStudy) -> Table:
    """Errors of each setting with another mass or gravity, and their ratios to those as it is."""
    rows = []
    for sensitivity in study.sensitivities:
        steps = str(sensitivity.settings.get("steps_per_revolution", numbers.MISSING))
        for variation in sensitivity.variations:
            name = variation_name(sensitivity, variation)
            errors = [_error(variation, quantity) for quantity in QUANTITIES]
            rows.append([engine_title(sensitivity.engine), sensitivity.preset, steps, name, *errors, _drive(variation)])
    head = ["engine", "preset", STEPS, "change", *(f"{q} error (ratio)" for q in QUANTITIES)]
    return table([*head, "ripple of the drive"], rows)


def variation_name(sensitivity: Sensitivity, variation: Variation) -> str:
    """The change in words; gravity as it was switched."""
    if variation.name == GRAVITY:
        return "gravity off" if sensitivity.settings.get("gravity") else "gravity on"
    return variation.name if variation.value is None else f"{variation.name} ({numbers.quantity(variation.value)} kg)"


def _error(variation: Variation, quantity: str) -> str:
    if variation.errors is None:
        return variation.outcome
    ratio = variation.ratios.get(quantity)
    factor = "" if ratio is None else f" (x {numbers.measured(ratio)})"
    return f"{numbers.measured(variation.errors[quantity])}{factor}"


def _drive(variation: Variation) -> str:
    if variation.outcome != COMPLETED:
        return numbers.MISSING
    return numbers.measured(variation.drive) + ("" if variation.drive_kept else ": too much, no statement")


def transfers_table(transfers: Sequence[Transfer]) -> Table:
    """A row for each scene left out, engine and tolerance."""
    rows = [
        [
            found.left_out,
            engine_title(found.engine),
            f"{found.quantity} {tolerance(found.allowed)}",
            found.rule,
            str(found.steps_per_revolution),
            "; ".join(f"{scene} {numbers.measured(error)}" for scene, error in found.errors.items()),
            "did not complete" if found.error is None else numbers.measured(found.error),
            "yes" if found.held else "**no**",
            numbers.MISSING if found.best is None or not found.held else numbers.measured(1.0 / found.best),
        ]
        for found in transfers
    ]
    head = ["left out", "engine", "within", "cheapest settings of the others", STEPS, "errors there"]
    return table([*head, "error on the one left out", "held", "cost over its own cheapest"], rows)
