"""Observed orders along a refinement path: what falls with the step, at which order, and where it stops."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

from conrod.runs.convergence import PAIRS_AGREE, observed_order
from conrod.studies.frame.measurement import QUANTITIES, Measurement
from conrod.studies.validation.refinement import Family


@dataclass(frozen=True)
class PathPoint:
    """One run of a path: its largest error by quantity, over the observed points; None unless completed."""

    steps_per_revolution: int
    outcome: str
    errors: Mapping[str, float] | None


@dataclass(frozen=True)
class QuantityOrder:
    """How the largest error of one quantity falls.

    Attributes:
        claimed: order, where consecutive pairs agree clear of the floor (docs/design.md, 'Convergence order').
        pairs: order between completed neighbours, None where an error is zero.
        plateau: error of the finest run where it has stopped falling: the orders of the last two pairs have no size.
            None where it falls, or grows, to the end.
        floor: of the fit e = c h^p + floor; None where there are too few points.
    """

    claimed: float | None
    pairs: tuple[float | None, ...]
    plateau: float | None
    floor: float | None


@dataclass(frozen=True)
class ObservedOrders:
    """Orders of one family.

    Attributes:
        fixed: settings that stay the same along the path.
        following: names of the settings that follow the step.
        points: all runs, failed ones among them.
    """

    engine: str
    label: str
    path: str
    fixed: Mapping[str, Any]
    following: tuple[str, ...]
    points: tuple[PathPoint, ...]
    orders: Mapping[str, QuantityOrder]

    @property
    def failed(self) -> tuple[PathPoint, ...]:
        """The runs that did not complete."""
        return tuple(point for point in self.points if point.errors is None)

    def as_dict(self) -> dict[str, Any]:
        """All fields as plain values."""
        return asdict(self)


def orders_along(family: Family, measurements: Mapping[str, Measurement]) -> ObservedOrders:
    """Orders of a family from the measurements of its cells.

    Raises:
        KeyError: a cell of the family has not been measured.
    """
    points = tuple(
        _point(cell.settings.steps_per_revolution, measurements[cell.key])
        for cell in sorted(family.cells, key=lambda cell: cell.settings.steps_per_revolution)
    )
    completed = [(point.steps_per_revolution, point.errors) for point in points if point.errors is not None]
    steps = [n for n, _ in completed]
    return ObservedOrders(
        engine=family.engine,
        label=family.label,
        path=family.path,
        fixed=family.fixed,
        following=family.following,
        points=points,
        orders={q: order_of(steps, [errors[q] for _, errors in completed]) for q in QUANTITIES},
    )


def order_of(steps: Sequence[int], errors: Sequence[float]) -> QuantityOrder:
    """Order, plateau and floor of errors at increasing numbers of steps per revolution."""
    found = observed_order(steps, errors)
    return QuantityOrder(found.claimed, found.pairs, _plateau(found.pairs, errors), found.floor)


def _plateau(pairs: Sequence[float | None], errors: Sequence[float]) -> float | None:
    last = pairs[-2:]
    still = len(last) == 2 and all(order is not None and abs(order) <= PAIRS_AGREE for order in last)
    return errors[-1] if still else None


def _point(steps: int, measured: Measurement) -> PathPoint:
    if measured.errors is None:
        return PathPoint(steps, measured.outcome, None)
    sizes = {q: size for q in QUANTITIES if (size := measured.largest(q)) is not None}
    return PathPoint(steps, measured.outcome, sizes)
