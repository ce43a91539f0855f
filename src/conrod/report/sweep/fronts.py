"""Tables of what is worth choosing: the points that a diagram names, and the cheapest within tolerances."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from conrod.report import numbers
from conrod.report.charts.styles import engine_title
from conrod.report.sweep.choice import cheapest_within, labelled_points, most_accurate
from conrod.report.sweep.naming import costs_of, rule_of, tolerance
from conrod.report.sweep.placing import placed_points
from conrod.report.tables import table
from conrod.studies.frame.measurement import QUANTITIES
from conrod.studies.sweep.results import SweepStudy, SweptPoint

TOLERANCES = (1e-3, 1e-6, 1e-9)
MORE_TOLERANCES = (1e-2, 1e-3, 1e-4, 1e-6, 1e-9)
COST_HEAD = ["CPU time a revolution", "in steps of the reference loop"]


def labelled_table(study: SweepStudy) -> str:
    """Every point that the diagram names."""
    rows = [
        [
            point.label,
            engine_title(point.engine),
            rule_of(point),
            str(point.steps_per_revolution),
            *(numbers.measured(point.error(quantity)) for quantity in QUANTITIES),
            *costs_of(point),
            ", ".join(f"**{q}**" if "all" in fronts[q] else q for q in QUANTITIES if q in fronts),
        ]
        for point, fronts in labelled_points(study)
    ]
    head = ["point", "engine", "settings", "steps per revolution", *(f"{q} error" for q in QUANTITIES), *COST_HEAD]
    return table([*head, "on the front for"], rows)


def cheapest_rows(study: SweepStudy, quantity: str, tolerances: Sequence[float]) -> list[list[str]]:
    """For each tolerance and engine the cheapest setting within it, or how near it comes; none without costs.

    An engine that a tolerance is too tight for is left out of tighter ones.
    """
    rows, beyond = [], set[str]()
    for allowed in sorted(tolerances, reverse=True):
        for engine in (e for e in study.engines if e not in beyond):
            among = _of(engine)
            if not any(among(p) and p.completed and p.cost is not None for p in study.points):
                continue
            best = cheapest_within(study, quantity, allowed, engine)
            if best is None:
                beyond.add(engine)
            rows.append([tolerance(allowed), engine_title(engine), *_choice(study, quantity, best, among)])
    return rows


def _choice(
    study: SweepStudy, quantity: str, best: SweptPoint | None, among: Callable[[SweptPoint], bool]
) -> list[str]:
    if best is None:
        nearest = most_accurate(study, quantity, among)
        reached = numbers.measured(None if nearest is None else nearest.error(quantity))
        return [f"none of the grid; the least error is {reached}", *[numbers.MISSING] * 4]
    steps, error = str(best.steps_per_revolution), numbers.measured(best.error(quantity))
    return [f"{rule_of(best)} ({best.label})", steps, error, *costs_of(best)]


def _of(engine: str) -> Callable[[SweptPoint], bool]:
    return lambda point: point.engine == engine


def cheapest_table(study: SweepStudy) -> str:
    """The cheapest setting of each engine for several tolerances of each quantity."""
    rows = [[q, *row] for q in QUANTITIES for row in cheapest_rows(study, q, MORE_TOLERANCES)]
    head = ["error of", "within", "engine", "cheapest settings", "steps per revolution", "error", *COST_HEAD]
    return table(head, rows)


def counted(study: SweepStudy) -> str:
    """How many points the diagram holds, and which of them stand at an estimated cost."""
    placed = placed_points(study)
    failed = sum(not p.point.completed for p in placed)
    untimed = sum(p.estimated and p.point.completed for p in placed)
    unplaced = len(study.points) - len(placed)
    text = f"{len(placed)} runs are drawn, of which {failed} did not complete."
    if untimed:
        text += f" {untimed} that completed were not timed: they stand at an estimated cost, and on no front."
    if unplaced:
        text += f" {unplaced} runs of engines of which nothing was timed are not drawn."
    return text
