"""How far a choice of settings carries: chosen on some scenes, tried on the one left out."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

from conrod.studies.sweep.results import SweepStudy, SweptPoint

TOLERANCES = (1e-3, 1e-5, 1e-7)


@dataclass(frozen=True)
class Transfer:
    """A setting chosen on all scenes but one, and what it does there.

    Attributes:
        allowed: largest error.
        errors: of the scenes that it was chosen on.
        error: on the scene that was left out; None unless the run completed.
        best: cost of the cheapest setting that the scene's own sweep knows for the same, over this one's; None where
            there is none, or no timing.
    """

    left_out: str
    engine: str
    quantity: str
    allowed: float
    rule: str
    steps_per_revolution: int
    errors: Mapping[str, float]
    error: float | None
    best: float | None

    @property
    def held(self) -> bool:
        """Whether the setting is within tolerance there too."""
        return self.error is not None and self.error <= self.allowed

    def as_dict(self) -> dict[str, Any]:
        """Plain values."""
        return {**asdict(self), "held": self.held}


def transfers(studies: Sequence[SweepStudy], quantity: str = "position") -> tuple[Transfer, ...]:
    """Leave one scene out at a time, for each engine and tolerance: scenes whose grids have the same rules."""
    return tuple(_transfers(studies, quantity))


def _transfers(studies: Sequence[SweepStudy], quantity: str) -> Iterator[Transfer]:
    tables = {study.name: _by_setting(study) for study in studies}
    for left_out, own in tables.items():
        # Contact has knobs of its own: a choice carries only to scenes with the same ones.
        others = {n: t for n, t in tables.items() if n != left_out and t.keys() & own.keys()}
        if not others:
            continue
        for engine in sorted({p.engine for p in own.values()}):
            for allowed in TOLERANCES:
                chosen = _cheapest(others, engine, quantity, allowed)
                if chosen is not None:
                    yield _tried(left_out, own, others, chosen, quantity, allowed)


Setting = tuple[str, str, int]  # engine, rule, steps per revolution: the same in period and step for all scenes


def _by_setting(study: SweepStudy) -> dict[Setting, SweptPoint]:
    return {(p.engine, p.rule, p.steps_per_revolution): p for p in study.points}


def _cheapest(
    tables: Mapping[str, Mapping[Setting, SweptPoint]], engine: str, quantity: str, allowed: float
) -> Setting | None:
    """The setting within tolerance on all scenes whose costs, in reference steps, have the least product."""
    first, *rest = tables.values()
    products: dict[Setting, float] = {}
    for setting in first:
        points = [table.get(setting) for table in (first, *rest)]
        if setting[0] != engine or not all(p is not None and _meets(p, quantity, allowed) for p in points):
            continue
        product = 1.0
        for point in points:
            product *= point.timing.ratio if point is not None and point.timing is not None else float("inf")
        products[setting] = product
    return min(products, key=lambda s: products[s], default=None)


def _meets(point: SweptPoint, quantity: str, allowed: float) -> bool:
    error = point.error(quantity)
    return error is not None and error <= allowed


def _tried(
    left_out: str,
    own: Mapping[Setting, SweptPoint],
    others: Mapping[str, Mapping[Setting, SweptPoint]],
    setting: Setting,
    quantity: str,
    allowed: float,
) -> Transfer:
    engine, rule, steps = setting
    point = own.get(setting)
    costs = [p.cost for p in own.values() if p.engine == engine and _meets(p, quantity, allowed) and p.cost is not None]
    cost = None if point is None else point.cost
    return Transfer(
        left_out=left_out,
        engine=engine,
        quantity=quantity,
        allowed=allowed,
        rule=rule,
        steps_per_revolution=steps,
        errors={name: table[setting].error(quantity) or 0.0 for name, table in others.items()},
        error=None if point is None else point.error(quantity),
        best=min(costs) / cost if costs and cost else None,
    )
