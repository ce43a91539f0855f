"""Transfer of a choice of settings: chosen on some scenes, tried on the one left out."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from conrod.studies.sweep.findings import SweepStudy, SweptPoint

QUANTITY, TOLERANCES = "position", (1e-3, 1e-5, 1e-7)

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


def transfers(studies: Sequence[SweepStudy]) -> Iterator[Transfer]:
    """Leave one scene out at a time, for each engine and tolerance: scenes whose grids have the same rules."""
    tables: dict[str, Table] = {
        s.name: {(p.engine, p.rule, p.steps_per_revolution): p for p in s.points} for s in studies
    }
    for left_out, own in tables.items():
        # Contact has knobs of its own: a choice carries only to scenes with the same ones.
        others = {n: t for n, t in tables.items() if n != left_out and t.keys() & own.keys()}
        for engine in sorted({p.engine for p in own.values()} if others else ()):
            for allowed in TOLERANCES:
                setting = _cheapest(list(others.values()), engine, allowed)
                if setting is None:
                    continue
                costs = [
                    p.cost for p in own.values() if p.engine == engine and _within(p, allowed) and p.cost is not None
                ]
                point = own.get(setting)
                cost = None if point is None else point.cost
                yield Transfer(
                    left_out=left_out,
                    engine=engine,
                    quantity=QUANTITY,
                    allowed=allowed,
                    rule=setting[1],
                    steps_per_revolution=setting[2],
                    errors={name: table[setting].error(QUANTITY) or 0.0 for name, table in others.items()},
                    error=None if point is None else point.error(QUANTITY),
                    best=min(costs) / cost if costs and cost else None,
                )


def _cheapest(tables: Sequence[Table], engine: str, allowed: float) -> Setting | None:
    """The setting within tolerance on all scenes whose costs, in reference steps, have the least product."""
    products = {}
    for setting in (setting for setting in tables[0] if setting[0] == engine):
        points = [table.get(setting) for table in tables]
        if all(_within(point, allowed) for point in points):
            products[setting] = math.prod(p.ratio if p and p.ratio is not None else math.inf for p in points)
    return min(products, key=lambda s: products[s], default=None)


def _within(point: SweptPoint | None, allowed: float) -> bool:
    error = None if point is None else point.error(QUANTITY)
    return error is not None and error <= allowed
