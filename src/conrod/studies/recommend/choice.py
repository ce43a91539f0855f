"""The cheapest setting within given tolerances, confirmed on runs that the grid does not contain."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Protocol

from conrod.engines import Engine
from conrod.engines.capabilities import Lacking, Pasted, capability
from conrod.engines.presets import STOCK
from conrod.errors import InvalidInput
from conrod.mechanism.units import check_number
from conrod.scenes import Scene
from conrod.studies.frame.measurement import Measurement
from conrod.studies.frame.run import RunCase
from conrod.studies.frame.timing import Timing
from conrod.studies.recommend.recommendation import (
    Confirmation,
    Recommendation,
    Refusal,
    Rejected,
    compared_with_stock,
    groups_of,
)
from conrod.studies.sweep.plan import SweepPlan, SweptRule

LARGEST_TOLERANCE = 1e6
SMALLEST_TOLERANCE = 1e-15
# Between two steps of the grid, one is tried at which the error should be this much below what is allowed.
AIMED_MARGIN = 1.25
STEP_UNIT = 4  # steps per revolution are multiples of this
# Runs that the grid does not contain.
OTHER_START = math.radians(37.0)
MORE_REVOLUTIONS = 5.0
OTHER_SPEEDS = (0.9, 1.1)


class Runs(Protocol):
    """Runs and times cells, and keeps what it finds."""

    def run(self, cells: list[RunCase], description: str = ...) -> dict[str, Measurement]:
        """Measurements by key."""
        ...

    def time(self, cells: list[RunCase], description: str = ...) -> dict[str, Timing]:
        """Timings by key, of those cells that can be timed."""
        ...


@dataclass(frozen=True)
class Candidate:
    """A setting within the tolerances: the coarsest step of its rule."""

    swept: SweptRule = field(repr=False)
    cell: RunCase
    measurement: Measurement


def check_tolerances(tolerances: Mapping[str, float | None]) -> dict[str, float]:
    """The tolerances that were given, of normalised errors.

    Raises:
        InvalidInput: none is, or one that no run can meet, or that means nothing.
    """
    given = {quantity: value for quantity, value in tolerances.items() if value is not None}
    if not given:
        raise InvalidInput(
            "no tolerance: give at least one of --position, --velocity, --acceleration, e.g. --position 1e-6"
        )
    for quantity, value in given.items():
        check_number(f"--{quantity}", value, SMALLEST_TOLERANCE, LARGEST_TOLERANCE)
    return given


def recommend_for(plan: SweepPlan, allowed: Mapping[str, float], runs: Runs) -> list[Recommendation | Refusal]:
    """For each engine of the plan its cheapest confirmed setting, or what is nearest.

    Args:
        plan: of the sweep of one scene; its cells are run where they are missing.
        allowed: largest error by quantity.
    """
    measurements = runs.run(list(plan.grid_cells), f"{plan.name} grid")
    engines = dict.fromkeys(rule.engine.name for rule in plan.rules)
    return [_for_engine([r for r in plan.rules if r.engine.name == e], measurements, allowed, runs) for e in engines]


def _for_engine(
    rules: Sequence[SweptRule], measurements: Mapping[str, Measurement], allowed: Mapping[str, float], runs: Runs
) -> Recommendation | Refusal:
    waiting = {c.cell.key: c for c in _with_finer_steps(rules, measurements, allowed, runs)}
    timings = runs.time([c.cell for c in waiting.values()], f"{rules[0].engine.name} costs")
    rejected: list[Rejected] = []
    # What cannot be timed cannot be called the cheapest.
    while waiting := {key: c for key, c in waiting.items() if key in timings}:
        candidate = waiting.pop(min(waiting, key=lambda key: timings[key].ratio))
        confirmations = _confirmed(candidate, allowed, runs)
        lost = [c for c in confirmations if not c.held]
        if not lost:
            return _recommendation(candidate, rules, measurements, allowed, runs, confirmations, tuple(rejected))
        steps = candidate.cell.settings.steps_per_revolution
        rejected.append(Rejected(candidate.swept.rule.name, steps, "; ".join(_in_words(c) for c in lost)))
        finer = _next_finer(candidate, measurements, allowed)
        if finer is not None and finer.cell.key not in waiting:
            waiting[finer.cell.key] = finer
            timings = timings | runs.time([finer.cell], f"{rules[0].engine.name} costs")
    return _refusal(rules, measurements, allowed, tuple(rejected))


def _next_finer(
    candidate: Candidate, measurements: Mapping[str, Measurement], allowed: Mapping[str, float]
) -> Candidate | None:
    """The next finer step of the same rule that the grid has within tolerance."""
    steps = candidate.cell.settings.steps_per_revolution
    for cell in candidate.swept.cells:
        if cell.settings.steps_per_revolution > steps and excess(measurements[cell.key], allowed) <= 1.0:
            return Candidate(candidate.swept, cell, measurements[cell.key])
    return None


def _in_words(confirmation: Confirmation) -> str:
    if confirmation.errors is None:
        return f"{confirmation.what}: {confirmation.outcome}"
    found = ", ".join(f"{quantity} {error:.1e}" for quantity, error in confirmation.errors.items())
    return f"{confirmation.what}: {found}"


# -- candidates ------------------------------------------------------------------------------------------------------


def excess(measurement: Measurement, allowed: Mapping[str, float]) -> float:
    """Largest error over what is allowed; infinite unless the run completed."""
    found = [(measurement.largest(quantity), limit) for quantity, limit in allowed.items()]
    return max(math.inf if error is None else error / limit for error, limit in found)


def _with_finer_steps(
    rules: Sequence[SweptRule], measurements: Mapping[str, Measurement], allowed: Mapping[str, float], runs: Runs
) -> list[Candidate]:
    """The coarsest step of each rule that is within tolerance: of the grid, or better between two of the grid."""
    candidates, tries = [], {}
    for swept in rules:
        excesses = [excess(measurements[cell.key], allowed) for cell in swept.cells]
        k = next((k for k, e in enumerate(excesses) if e <= 1.0), None)
        if k is None:
            continue
        grid = Candidate(swept, swept.cells[k], measurements[swept.cells[k].key])
        candidates.append(grid)
        between = None if k == 0 else _between(swept, k, excesses)
        if between is not None:
            tries[between.key] = (swept, between)
    found = runs.run([cell for _, cell in tries.values()], "between the grid's steps") if tries else {}
    candidates += [Candidate(s, c, found[key]) for key, (s, c) in tries.items() if excess(found[key], allowed) <= 1.0]
    return candidates


def _between(swept: SweptRule, k: int, excesses: Sequence[float]) -> RunCase | None:
    """The step between the last one that is out and the first one within, at which the error should just do."""
    (out, within), (low, high) = (
        excesses[k - 1 : k + 1],
        (c.settings.steps_per_revolution for c in swept.cells[k - 1 : k + 1]),
    )
    if not math.isfinite(out) or within <= 0.0:
        return None
    share = math.log(out * AIMED_MARGIN) / math.log(out / within)
    steps = STEP_UNIT * math.ceil(low * (high / low) ** share / STEP_UNIT)
    if not low < steps < high:
        return None
    cell = swept.cells[k]
    return RunCase(cell.name, cell.scene, swept.rule.settings(cell.scene, steps))


# -- confirmation ----------------------------------------------------------------------------------------------------


def _confirmed(candidate: Candidate, allowed: Mapping[str, float], runs: Runs) -> tuple[Confirmation, ...]:
    cells = dict(confirming_cells(candidate.swept, candidate.cell))
    found = runs.run(list(cells.values()), "confirmation")
    return tuple(_confirmation(what, found[cell.key], allowed) for what, cell in cells.items())


def confirming_cells(swept: SweptRule, cell: RunCase) -> Iterator[tuple[str, RunCase]]:
    """Runs that the grid does not contain: another start, more revolutions, other speeds.

    An input that makes one pass has one start and one length of a run: it makes the pass backwards instead.
    """
    steps = cell.settings.steps_per_revolution
    backwards = []
    if cell.scene.kinematics.mechanism.driver.span is None:
        yield "start at 37 deg", RunCase(cell.name, cell.scene, cell.settings, start_angle=OTHER_START)
        yield "five revolutions", RunCase(cell.name, cell.scene, cell.settings, revolutions=MORE_REVOLUTIONS)
    else:
        backwards = [("the pass backwards", -1.0)]
    for what, factor in [*backwards, *((f"speed {factor - 1.0:+.0%}", factor) for factor in OTHER_SPEEDS)]:
        scene: Scene = cell.scene.with_parameters(speed=factor * cell.scene.speed)
        yield what, RunCase(cell.name, scene, swept.rule.settings(scene, steps))


def _confirmation(what: str, measurement: Measurement, allowed: Mapping[str, float]) -> Confirmation:
    errors = {q: e for q in allowed if (e := measurement.largest(q)) is not None}
    return Confirmation(what, measurement.outcome, errors or None, excess(measurement, allowed) <= 1.0)


# -- results ---------------------------------------------------------------------------------------------------------


def _recommendation(
    candidate: Candidate,
    rules: Sequence[SweptRule],
    measurements: Mapping[str, Measurement],
    allowed: Mapping[str, float],
    runs: Runs,
    confirmations: tuple[Confirmation, ...],
    rejected: tuple[Rejected, ...],
) -> Recommendation:
    swept, cell = candidate.swept, candidate.cell
    stock = [c for rule in rules for c in rule.cells if c.settings.preset == STOCK]
    completed = [c for c in stock if measurements[c.key].errors is not None]
    timings = runs.time([*completed, cell], "stock costs")
    return Recommendation(
        engine=swept.engine.name,
        rule=swept.rule.name,
        preset=None if cell.settings.preset == "custom" else cell.settings.preset,
        cell=cell,
        errors={q: candidate.measurement.largest(q) or 0.0 for q in allowed},
        margin=1.0 / max(excess(candidate.measurement, allowed), 1e-300),
        timing=timings[cell.key],
        confirmations=confirmations,
        rejected=rejected,
        stock=compared_with_stock(candidate.measurement, timings[cell.key], completed, measurements, timings, allowed),
        groups=groups_of(cell.scene, cell.settings),
        paste=_paste(swept.engine, cell),
    )


def _paste(engine: Engine[Any], cell: RunCase) -> str:
    """The settings as lines for the user; the reason where the engine gives none."""
    pasted = capability(engine, Pasted)
    return f"# {pasted.reason}" if isinstance(pasted, Lacking) else pasted.paste(cell.scene, cell.settings)


def _refusal(
    rules: Sequence[SweptRule],
    measurements: Mapping[str, Measurement],
    allowed: Mapping[str, float],
    rejected: tuple[Rejected, ...],
) -> Refusal:
    cells = [(rule, cell) for rule in rules for cell in rule.cells]
    rule, cell = min(cells, key=lambda pair: excess(measurements[pair[1].key], allowed))
    nearest, engine = measurements[cell.key], rules[0].engine.name
    if nearest.errors is None:
        return Refusal(engine, "", 0, {}, {}, rejected, "no run of the grid completed")
    errors = {q: nearest.largest(q) or 0.0 for q in allowed}
    over = {q: errors[q] / limit for q, limit in allowed.items() if errors[q] > limit}
    return Refusal(engine, rule.rule.name, cell.settings.steps_per_revolution, errors, over, rejected)
