"""Transfer of a choice of settings: chosen on some scenes, tried on the one left out."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from conrod.studies.sweep.findings import SweepStudy, SweptPoint

TOLERANCES = (1e-3, 1e-5, 1e-7)

Setting = tuple[str, str, int]  # engine, rule, steps per revolution: the same in period and step for all scenes
Table = Mapping[Setting, SweptPoint]


@dataclass(frozen=True)
class Transfer:
    """A setting chosen on all scenes but one, and its error there.

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
        """True if the setting is within tolerance there too."""
        return self.error is not None and self.error <= self.allowed


def transfers(studies: Sequence[SweepStudy], quantity: str = "position") -> Iterator[Transfer]:
    """Leave one scene out at a time, for each engine and tolerance: scenes whose grids have the same rules."""
    tables = {s.name: {(p.engine, p.rule, p.steps_per_revolution): p for p in s.points} for s in studies}
    for left_out, own in tables.items():
        # Contact has knobs of its own: a choice carries only to scenes with the same ones.
        others = {n: t for n, t in tables.items() if n != left_out and t.keys() & own.keys()}
        for engine in sorted({p.engine for p in own.values()} if others else ()):
            for allowed in TOLERANCES:
                chosen = _cheapest(list(others.values()), engine, quantity, allowed)
                if chosen is not None:
                    yield _tried(left_out, own, others, chosen, quantity, allowed)


def _cheapest(tables: Sequence[Table], engine: str, quantity: str, allowed: float) -> Setting | None:
    """The setting within tolerance on all scenes whose costs, in reference steps, have the least product."""
    products = {}
    for setting in (setting for setting in tables[0] if setting[0] == engine):
        points = [table.get(setting) for table in tables]
        if all(_within(point, quantity, allowed) for point in points):
            products[setting] = math.prod(p.ratio if p and p.ratio is not None else math.inf for p in points)
    return min(products, key=lambda s: products[s], default=None)


def _within(point: SweptPoint | None, quantity: str, allowed: float) -> bool:
    error = None if point is None else point.error(quantity)
    return error is not None and error <= allowed


def _tried(
    left_out: str, own: Table, others: Mapping[str, Table], setting: Setting, quantity: str, allowed: float
) -> Transfer:
    engine, rule, steps = setting
    point = own.get(setting)
    costs = [
        p.cost for p in own.values() if p.engine == engine and _within(p, quantity, allowed) and p.cost is not None
    ]
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
