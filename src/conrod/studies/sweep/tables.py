"""Tables of a sweep, and its points by preset, by cost and by tolerance."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import groupby

from conrod.comparison.convergence import ObservedOrder
from conrod.comparison.trajectory import Outcome
from conrod.engines.engine import STOCK
from conrod.exact.motion import QUANTITIES
from conrod.report import numbers
from conrod.report.charts.styles import engine_title
from conrod.report.table import Table, table
from conrod.studies.sweep.findings import SweepStudy, SweptPoint

COMPARED_QUANTITY, COMPARED_ERROR = "position", 1e-6  # the error at which engines are compared
UNSUPPORTED = Outcome.UNSUPPORTED.slug
TOLERANCES = (1e-3, 1e-6, 1e-9)
STEPS = "steps per revolution"
COST_HEAD = ["CPU time a revolution", "in steps of the reference loop"]
CHEAPEST_HEAD = ["within", "engine", "cheapest settings", STEPS, "error", *COST_HEAD]
FRONT_HEAD = ["point", "setting", "steps/rev", "position", "[mm]", "velocity", "accel.", "ms/rev", "ratio"]
RATIO_NOTE = "ratio: a revolution costs as much as so many steps of the engine's fixed reference loop"


# -- points ------------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class PresetCurve:
    """The points of an engine's preset at increasing numbers of steps, failed runs included."""

    engine: str
    preset: str
    points: tuple[SweptPoint, ...]

    @property
    def rule(self) -> str:
        """The name of the preset's rule; where several rules share its points, the most frequent."""
        names = [point.rule for point in self.points]
        return max(names, key=names.count)


def preset_curves(study: SweepStudy) -> tuple[PresetCurve, ...]:
    """Return a curve for each engine and preset of the sweep."""
    curves = []
    for engine in study.engines:
        of_engine = [p for p in study.points if p.engine == engine and p.preset is not None]
        for preset in dict.fromkeys(p.preset or "" for p in of_engine):
            # Two rules may share a run: it is one point of the curve.
            runs = {p.key: p for p in of_engine if p.preset == preset}.values()
            curves.append(PresetCurve(engine, preset, tuple(sorted(runs, key=lambda p: p.steps_per_revolution))))
    return tuple(curves)


def cheapest_within(points: Iterable[SweptPoint], quantity: str, allowed: float, engine: str) -> SweptPoint | None:
    """Return an engine's cheapest point with an error within a tolerance, or None."""
    timed = (p for p in points if p.engine == engine and p.completed and p.cost is not None)
    within = [p for p in timed if (p.error(quantity) or 0.0) <= allowed]
    return min(within, key=lambda p: (p.cost or 0.0, p.error(quantity) or 0.0), default=None)


def least_error(study: SweepStudy, quantity: str, engine: str, preset: str | None = None) -> float | None:
    """Return the least error of a quantity among an engine's completed runs, or None."""
    runs = [p for p in study.points if p.completed and p.engine == engine and preset in (None, p.preset)]
    return min((p.error(quantity) or 0.0 for p in runs), default=None)


def timed_points(study: SweepStudy) -> list[SweptPoint]:
    """Completed runs with a cost; the cost of a failed run means nothing."""
    return [point for point in study.points if point.completed and point.cost is not None]


def timed_engines(study: SweepStudy) -> list[str]:
    """Engines with at least one timed point."""
    timed = {point.engine for point in timed_points(study)}
    return [engine for engine in study.engines if engine in timed]


def tolerance_text(value: float) -> str:
    """Return a tolerance as text: `1e-6`."""
    return f"{value:.0e}".replace("e-0", "e-")


def rule_of(point: SweptPoint) -> str:
    """Return the name of a point's rule, marked if it is a preset."""
    return rule_title(point.rule, point.preset)


def rule_title(rule: str, preset: str | None) -> str:
    """Return a rule's name, with its preset: ``tuned rule (`tuned`)``."""
    if preset is None:
        return rule
    return f"`{preset}`" if rule == preset else f"{rule} (`{preset}`)"


# -- choices -----------------------------------------------------------------------------------------------------------


def front_table(study: SweepStudy, title: str = "") -> Table:
    """Return a row for each point on its engine's Pareto front of cost and position error."""
    rows = [
        [
            point.label,
            f"{engine_title(engine)}: {rule_of(point)}",
            str(point.steps_per_revolution),
            *_error_cells(study, point),
            *(
                numbers.measured_text(None if point.cost is None else 1e3 * point.cost),
                numbers.measured_text(point.ratio),
            ),
        ]
        for engine in study.engines
        for point in study.front(COMPARED_QUANTITY, engine)
    ]
    return table(FRONT_HEAD, rows, right=FRONT_HEAD[2:], title=title)


def _error_cells(study: SweepStudy, point: SweptPoint) -> list[str]:
    position, *others = (numbers.measured_text(point.error(quantity)) for quantity in QUANTITIES)
    return [position, numbers.in_mm(point.error(COMPARED_QUANTITY), study.lengths), *others]


def cheapest_rows(study: SweepStudy, quantity: str) -> list[list[str]]:
    """Return for each tolerance and engine the cheapest setting within it, or the least error.

    An engine that a tolerance is too tight for is left out of tighter ones.
    """
    rows, beyond = [], set[str]()
    for allowed in TOLERANCES:
        for engine in (e for e in timed_engines(study) if e not in beyond):
            best = cheapest_within(study.points, quantity, allowed, engine)
            if best is None:
                beyond.add(engine)
                least = numbers.measured_text(least_error(study, quantity, engine))
                choice = [f"none of the grid; the least error is {least}", *[numbers.MISSING] * 4]
            else:
                choice = [f"{rule_of(best)} ({best.label})", str(best.steps_per_revolution)]
                choice += [numbers.error(quantity, best.error(quantity), study.lengths)]
                choice += [numbers.duration(best.cost), numbers.measured_text(best.ratio)]
            rows.append([tolerance_text(allowed), engine_title(engine), *choice])
    return rows


def cheapest_table(study: SweepStudy) -> Table:
    """Return the cheapest setting of each engine for several tolerances of each quantity."""
    rows = [[q, *row] for q in QUANTITIES for row in cheapest_rows(study, q)]
    return table(["error of", *CHEAPEST_HEAD], rows, right=CHEAPEST_HEAD[3:])


def findings(study: SweepStudy) -> list[str]:
    """Say for each timed engine which setting is the cheapest within 1e-6 L."""
    found = []
    for engine in timed_engines(study):
        best = cheapest_within(study.points, COMPARED_QUANTITY, COMPARED_ERROR, engine)
        least, stock = (least_error(study, COMPARED_QUANTITY, engine, preset) for preset in (None, STOCK))
        title, error = engine_title(engine), f"position error of {tolerance_text(COMPARED_ERROR)} L"
        if best is None:
            text = f"**No setting of {title} in the grid has a {error} or less**"
            text += f"; the least is {numbers.measured_text(least)}."
        else:
            setting = f"{rule_of(best)}, at {best.steps_per_revolution} steps per revolution ({best.label})"
            cost = numbers.duration(best.cost)
            text = f"**The cheapest setting of {title} for a {error}** is {setting}: {cost} of CPU time a revolution."
        never = f" The {STOCK} settings never get there: their least error is {numbers.measured_text(stock)} L."
        found.append(text + (never if stock is not None and stock > COMPARED_ERROR else ""))
    return found


# -- orders ------------------------------------------------------------------------------------------------------------


def order_words(found: ObservedOrder) -> str:
    """Return the observed order, or the plateau at which the error stops falling."""
    if found.plateau is not None:
        return f"plateau {numbers.measured_text(found.plateau)}"
    return numbers.MISSING if found.claimed is None else numbers.order(found.claimed)


def orders_table(study: SweepStudy) -> Table:
    """Return a row for each preset: order or plateau by quantity, and how its runs ended."""
    presets = {(curve.engine, curve.rule): curve.preset for curve in preset_curves(study)}
    rows = [
        [
            engine_title(rule.engine),
            rule_title(rule.name, presets[rule.engine, rule.name]),
            *(order_words(rule.orders[quantity]) for quantity in QUANTITIES),
            "; ".join(filter(None, outcome_ranges(study.points_of(rule)))) or "completed",
        ]
        for rule in study.rules
        if (rule.engine, rule.name) in presets
    ]
    return table(["engine", "settings", *QUANTITIES, f"{STEPS}: outcome"], rows)


# -- how runs ended ----------------------------------------------------------------------------------------------------


def end_words(study: SweepStudy) -> str:
    """Return the counts of runs by outcome: `90 completed, 10 opened`."""
    counts = Counter(point.outcome for point in study.points)
    return ", ".join(f"{n} {slug}" for slug, n in counts.most_common())


def outcome_ranges(points: Sequence[SweptPoint]) -> Iterator[str]:
    """Yield the outcome of each range of steps, `20 to 100: diverged`, empty if completed."""
    for outcome, group in groupby(points, lambda point: point.outcome):
        own = list(group)
        steps = dict.fromkeys(point.steps_per_revolution for point in (own[0], own[-1]))
        reasons = {point.reason for point in own if outcome == UNSUPPORTED}
        reason = f" ({reasons.pop()})" if len(reasons) == 1 else ""
        yield "" if own[0].completed else f"{' to '.join(map(str, steps))}: {outcome}{reason}"
