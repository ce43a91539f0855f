"""Points of a sweep by what makes them worth naming: on a front, of a preset, the cheapest within a tolerance."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from conrod.engines.registry import presets_of
from conrod.studies.frame.measurement import QUANTITIES
from conrod.studies.sweep.results import SweepStudy, SweptPoint


@dataclass(frozen=True)
class Curve:
    """The points of one preset of one engine, at increasing numbers of steps; failed ones among them."""

    engine: str
    preset: str
    points: tuple[SweptPoint, ...]

    @property
    def rule(self) -> str:
        """The name of the rule that the preset is; of most of its points, where several rules share them."""
        names = [point.rule for point in self.points]
        return max(names, key=names.count)


def preset_curves(study: SweepStudy) -> tuple[Curve, ...]:
    """A curve for each engine and preset that the sweep holds, engines in their order, presets from soft to stiff."""
    curves = []
    for engine in study.engines:
        of_engine = [p for p in study.points if p.engine == engine and p.preset is not None]
        known = [name for name in presets_of(engine) if any(p.preset == name for p in of_engine)]
        for preset in dict.fromkeys([*known, *(p.preset or "" for p in of_engine)]):
            # Two rules may share a cell: it is one point of the curve.
            cells = {p.key: p for p in of_engine if p.preset == preset}.values()
            curves.append(Curve(engine, preset, tuple(sorted(cells, key=lambda p: p.steps_per_revolution))))
    return tuple(curves)


def preset_curve(study: SweepStudy, engine: str, preset: str) -> Curve | None:
    """The curve of one preset; None where the sweep does not hold it."""
    return next((c for c in preset_curves(study) if (c.engine, c.preset) == (engine, preset)), None)


def labelled_points(study: SweepStudy) -> tuple[tuple[SweptPoint, Mapping[str, tuple[str, ...]]], ...]:
    """Every point that a work-precision diagram names, with the fronts it is on, cheapest first within its engine.

    Returns:
        Points, each with quantity -> `own` where it is on the front of its engine, and `all` where it is on the
        front of all engines too.
    """
    named: dict[str, tuple[SweptPoint, dict[str, tuple[str, ...]]]] = {}
    for quantity in QUANTITIES:
        overall = {p.label for p in study.front(quantity)}
        for engine in study.engines:
            for point in study.front(quantity, engine):
                _, fronts = named.setdefault(point.label, (point, {}))
                fronts[quantity] = ("own", "all") if point.label in overall else ("own",)
    order = {engine: k for k, engine in enumerate(study.engines)}
    return tuple(sorted(named.values(), key=lambda entry: (order[entry[0].engine], entry[0].cost or 0.0)))


def cheapest_within(
    study: SweepStudy,
    quantity: str,
    allowed: float,
    engine: str | None = None,
    among: Callable[[SweptPoint], bool] = lambda point: True,
) -> SweptPoint | None:
    """The cheapest point whose largest error of a quantity is within a tolerance; None where there is none."""
    within = [
        point
        for point in study.points
        if engine in (None, point.engine)
        and point.cost is not None
        and among(point)
        and _within(point, quantity, allowed)
    ]
    return min(within, key=lambda p: (p.cost or 0.0, p.error(quantity) or 0.0), default=None)


def most_accurate(study: SweepStudy, quantity: str, among: Callable[[SweptPoint], bool]) -> SweptPoint | None:
    """The completed point with the least error of a quantity; None where there is none."""
    completed = [p for p in study.points if p.completed and among(p)]
    return min(completed, key=lambda p: p.error(quantity) or 0.0, default=None)


def _within(point: SweptPoint, quantity: str, allowed: float) -> bool:
    error = point.error(quantity)
    return error is not None and error <= allowed
