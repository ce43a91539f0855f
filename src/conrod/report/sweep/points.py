"""Points of a sweep that are worth naming: of a preset, on a front, the cheapest within a tolerance."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from conrod.studies.sweep.findings import SweepStudy, SweptPoint


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
    """A curve for each engine and preset that the sweep holds, both in their order."""
    curves = []
    for engine in study.engines:
        of_engine = [p for p in study.points if p.engine == engine and p.preset is not None]
        for preset in dict.fromkeys(p.preset or "" for p in of_engine):
            # Two rules may share a run: it is one point of the curve.
            runs = {p.key: p for p in of_engine if p.preset == preset}.values()
            curves.append(Curve(engine, preset, tuple(sorted(runs, key=lambda p: p.steps_per_revolution))))
    return tuple(curves)


def cheapest_within(points: Iterable[SweptPoint], quantity: str, allowed: float, engine: str) -> SweptPoint | None:
    """The cheapest point of an engine whose error of a quantity is within a tolerance; None where there is none."""
    timed = (p for p in points if p.engine == engine and p.completed and p.cost is not None)
    within = [p for p in timed if (p.error(quantity) or 0.0) <= allowed]
    return min(within, key=lambda p: (p.cost or 0.0, p.error(quantity) or 0.0), default=None)


def least_error(study: SweepStudy, quantity: str, engine: str, preset: str | None = None) -> float | None:
    """The least error of a quantity that any completed run of an engine has, or one of a preset; None without runs."""
    runs = [p for p in study.points if p.completed and p.engine == engine and preset in (None, p.preset)]
    return min((p.error(quantity) or 0.0 for p in runs), default=None)


def timed_points(study: SweepStudy) -> list[SweptPoint]:
    """Completed runs with a cost; that of a run that did not complete means nothing."""
    return [point for point in study.points if point.completed and point.cost is not None]


def timed_engines(study: SweepStudy) -> list[str]:
    """Engines of which a completed run was timed."""
    timed = {point.engine for point in timed_points(study)}
    return [engine for engine in study.engines if engine in timed]


# -- names -------------------------------------------------------------------------------------------------------------


def tolerance(value: float) -> str:
    """A given tolerance: `1e-6`."""
    return f"{value:.0e}".replace("e-0", "e-")


def rule_of(point: SweptPoint) -> str:
    """The rule, marked where it is a preset."""
    return named(point.rule, point.preset)


def named(rule: str, preset: str | None) -> str:
    """A rule, with the preset that it is."""
    if preset is None:
        return rule
    return f"`{preset}`" if rule == preset else f"{rule} (`{preset}`)"
