"""Tables of engines beside each other: what their presets cost at equal error, and which is the cheapest."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import groupby

from conrod.report import numbers
from conrod.report.charts.styles import engine_title
from conrod.report.sweep.points import tolerance, within_all
from conrod.report.sweep.tables import order_words, span_words
from conrod.report.table import Table, table
from conrod.runs.trajectory import Outcome
from conrod.studies.frame.measurement import QUANTITIES
from conrod.studies.sweep.equal_error import BARS, KEPT
from conrod.studies.sweep.findings import SweepStudy, SweptPoint, SweptRule

KEPT_HEADS = ("position", "position and velocity", "position, velocity and acceleration")
UNSUPPORTED = Outcome.UNSUPPORTED.slug
POSITION, *_, ALL = KEPT
WINNERS_HEAD = ("every error below", *KEPT_HEADS)
PRESETS_HEAD = ("engine", "preset", "steps", *QUANTITIES, "order", *(f"below {tolerance(b)}" for b in BARS), "outcome")


# -- the cheapest ------------------------------------------------------------------------------------------------------


def cheapest(study: SweepStudy, kept: Sequence[str], bar: float) -> SweptPoint | None:
    """The cheapest preset at the fewest steps that keep all errors of some quantities below a bar, if any does."""
    allowed = dict.fromkeys(kept, bar)
    within = [p for rule in study.rules for p in within_all(study.points_of(rule), allowed)[:1]]
    return min(within, key=lambda point: point.cost or math.inf, default=None)


def cost_words(study: SweepStudy, point: SweptPoint) -> str:
    """CPU seconds per simulated second, and the steps of a revolution: `0.0063 (20)`."""
    return f"{numbers.measured((point.cost or 0.0) / study.period)} ({point.steps_per_revolution})"


def winners_table(studies: Sequence[SweepStudy]) -> Table:
    """For each machine and bar the engine and preset that keeps it at the least cost."""
    rows = [(s, [tolerance(bar), *(_winner(s, kept, bar) for kept in KEPT)]) for s in studies for bar in BARS]
    return _of_machines(WINNERS_HEAD, rows)


def _of_machines(head: Sequence[str], rows: Sequence[tuple[SweepStudy, Sequence[str]]]) -> Table:
    """A table whose rows name their machines, where there are several."""
    if len({study.name for study, _ in rows}) == 1:
        return table(head, [row for _, row in rows])
    return table(("machine", *head), [(study.name, *row) for study, row in rows], names=2)


def _winner(study: SweepStudy, kept: Sequence[str], bar: float) -> str:
    best = cheapest(study, kept, bar)
    if best is not None:
        return f"{engine_title(best.engine)} `{best.preset}`: {cost_words(study, best)}"
    worst = (max(point.error(q) or 0.0 for q in kept) for point in study.points if point.completed)
    return f"none; the least is {numbers.measured(min(worst, default=None))}"


def winners_lines(studies: Sequence[SweepStudy]) -> list[str]:
    """For each bar the engines that keep it at the least cost, in all quantities and in position alone."""
    words = [[", ".join(_won(studies, kept, bar)) for kept in (ALL, POSITION)] for bar in BARS]
    return [
        f"{tolerance(bar)}: {both}; position alone: {place}" for bar, (both, place) in zip(BARS, words, strict=True)
    ]


def _won(studies: Sequence[SweepStudy], kept: Sequence[str], bar: float) -> Iterator[str]:
    """The engines that win, that of most machines first, and where none keeps the bar."""
    machines: dict[str, list[str]] = {}
    for study in studies:
        best = cheapest(study, kept, bar)
        machines.setdefault("" if best is None else best.engine, []).append(study.name)
    for engine, names in sorted(machines.items(), key=lambda item: (item[0] == "", -len(item[1]))):
        where = f"{len(names)} of {len(studies)}" if len(names) > 2 else " and ".join(names)
        yield f"{engine_title(engine)} ({where})" if engine else f"none keeps it on {where}"


# -- presets -----------------------------------------------------------------------------------------------------------


def presets_table(studies: Sequence[SweepStudy]) -> Table:
    """Every engine and preset on every machine: error, order, cost at equal error of all quantities, outcome."""
    return _of_machines(PRESETS_HEAD, [(study, row) for study in studies for row in _rows(study)])


def _rows(study: SweepStudy) -> Iterator[list[str]]:
    for rule in study.rules:
        points = study.points_of(rule)
        usual = min(points, key=lambda p: abs(math.log(p.steps_per_revolution / study.usual_steps)))
        errors = [numbers.measured(usual.error(quantity)) for quantity in QUANTITIES]
        yield [
            engine_title(rule.engine),
            f"`{rule.name}`",
            str(usual.steps_per_revolution),
            *errors,
            ", ".join(_order(rule, usual, quantity) for quantity in QUANTITIES),
            *(_cost(study, points, bar) for bar in BARS),
            outcome_words(points, study.unsupported.get(rule.engine)),
        ]


def _order(rule: SweptRule, usual: SweptPoint, quantity: str) -> str:
    """The order that is claimed; `exact` where the run at the usual steps is off by rounding alone."""
    error = usual.error(quantity)
    return "exact" if error is not None and error < numbers.ROUNDING else order_words(rule.orders[quantity])


def _cost(study: SweepStudy, points: Sequence[SweptPoint], bar: float) -> str:
    within = within_all(points, dict.fromkeys(ALL, bar))
    none = "no" if any(point.completed for point in points) else numbers.MISSING
    return cost_words(study, within[0]) if within else none


def outcome_words(points: Sequence[SweptPoint], unsupported: str | None) -> str:
    """How runs at increasing steps ended: `completed`, or which did not; and why there are no costs."""
    refused = {point.reason if point.outcome == UNSUPPORTED else "" for point in points}
    if len(refused) == 1 and "" not in refused:
        return f"{UNSUPPORTED}: {refused.pop()}"
    ends = [words for _, group in groupby(points, lambda p: p.outcome) if (words := span_words(list(group)))]
    costs = [f"cost unsupported: {unsupported}"] if unsupported else []
    return "; ".join([*(ends or ["completed"]), *costs])


def reference_words(study: SweepStudy) -> str:
    """The usual time of a step of each engine's reference loop, and by how much its timings differ."""
    return ", ".join(
        f"{engine_title(name)} {numbers.duration(seconds)} (slowest over fastest {spread:.2f})"
        for name, seconds in study.reference_seconds.items()
        for spread in [study.reference_spread[name]]
    )
