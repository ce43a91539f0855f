"""What a tolerance costs, in sentences: the cheapest settings and what they are cheaper than."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from conrod.engines.presets import STOCK
from conrod.report import numbers
from conrod.report.charts.styles import engine_title
from conrod.report.sweep.choice import cheapest_within, most_accurate
from conrod.report.sweep.naming import setting_of, tolerance, with_unit
from conrod.studies.sweep.results import SweepStudy, SweptPoint

QUANTITY, ALLOWED = "position", 1e-6
# Integrators whose error in a smooth motion is of first order in the state of one instant.
LOW_ORDER = ("Euler", "implicit", "implicitfast")
HARDENED = "hardened"

Among = Callable[[SweptPoint], bool]


def economies(study: SweepStudy) -> Iterator[str]:
    """For each engine with timings: the cheapest setting within the tolerance, and the cheapest of other kinds."""
    for engine in study.engines:
        own = _all_of(engine)
        if not any(own(p) and p.completed and p.cost is not None for p in study.points):
            continue
        best = cheapest_within(study, QUANTITY, ALLOWED, engine)
        yield _out_of_reach(study, engine, own) if best is None else _cheapest(study, engine, best)


def _all_of(engine: str) -> Among:
    return lambda point: point.engine == engine


def _out_of_reach(study: SweepStudy, engine: str, own: Among) -> str:
    nearest = most_accurate(study, QUANTITY, own)
    least = (
        ""
        if nearest is None
        else f" The least is {with_unit(nearest.error(QUANTITY), QUANTITY)}: {setting_of(nearest)}."
    )
    name = engine_title(engine)
    return f"**No setting of {name} in the grid reaches a {QUANTITY} error of {tolerance(ALLOWED)}.**{least}"


def _cheapest(study: SweepStudy, engine: str, best: SweptPoint) -> str:
    said = [
        f"**The cheapest setting of {engine_title(engine)} for a {QUANTITY} error of {tolerance(ALLOWED)}** is "
        f"{setting_of(best)}: {numbers.duration(best.cost)} of CPU time a revolution."
    ]
    kinds: dict[str, Among] = {
        f"with {', '.join(LOW_ORDER[:-1])} or {LOW_ORDER[-1]}": _of_low_order,
        "without hardening": _not_hardened,
    }
    for words, among in kinds.items():
        if any(p.engine == engine and among(p) for p in study.points):
            said.append(_compared(study, engine, best, words, among))
    stock = [p for p in study.points if p.engine == engine and p.preset == STOCK and p.completed]
    if stock and not any((p.error(QUANTITY) or 0.0) <= ALLOWED for p in stock):
        least = min(p.error(QUANTITY) or 0.0 for p in stock)
        said.append(f"The stock settings never get there: their least error is {with_unit(least, QUANTITY)}.")
    return " ".join(sentence for sentence in said if sentence)


def _of_low_order(point: SweptPoint) -> bool:
    return point.knobs.get("integrator") in LOW_ORDER


def _not_hardened(point: SweptPoint) -> bool:
    return "regularisation" in point.knobs and not point.knobs["regularisation"].startswith(HARDENED)


def _compared(study: SweepStudy, engine: str, best: SweptPoint, words: str, among: Among) -> str:
    """How much more the cheapest of a kind costs; nothing where the best is of that kind itself."""
    if among(best):
        return ""
    other = cheapest_within(study, QUANTITY, ALLOWED, engine, among)
    if other is None:
        return f"No setting {words} reaches it."
    factor = (other.cost or 0.0) / (best.cost or 1.0)
    cost = f"{numbers.duration(other.cost)}, **{numbers.measured(factor)} times as much**"
    return f"The cheapest {words} is {setting_of(other)}: {cost}."
