"""Columns that a verdict on a table rests on: those that move; and quantities that are not judged."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping

import numpy as np

from conrod.errors import InvalidInput, list_names
from conrod.exact.link_rotations import ROTATIONS
from conrod.models.tables.columns import AXES, CRANK_ANGLE, MOTION
from conrod.models.tables.errors import ERRORS, TableComparison

RMS = "velocity_rms"
MAX_LISTED_COLUMNS = 6  # columns that an error or a verdict names


def limited_quantity(tolerance: str) -> str:
    """The quantity of `MOTION` that a tolerance limits, as `position` for `total`; `phase` for itself."""
    return ERRORS.get(tolerance.removesuffix("_rms"), tolerance)


def exact_travels(table: TableComparison, quantity: str) -> dict[str, float]:
    """Normalised travel of each component of each point in the exact motion over the table's rows.

    That is the range of a position, and the largest size of a velocity or an acceleration: a column that has less
    travel than its tolerance is within that while nothing moves.
    """
    letter, travels = MOTION[quantity][0], dict[str, float]()
    for point in table.scene.lengths:
        exact = getattr(table.motion_at_nominal_crank.point(point), quantity) / table.normalising_size(quantity, point)
        sizes = np.ptp(exact, axis=0) if quantity == "position" else np.abs(exact).max(axis=0)
        travels |= {f"{point}.{letter}{axis}": float(size) for axis, size in zip(AXES, sizes, strict=True)}
    return travels


def check_moving(table: TableComparison, tolerance: Mapping[str, float], asked: Collection[str]) -> None:
    """Refuse a tolerance that limits no moving column: a column that stands still is always within it.

    Args:
        tolerance: allowed errors by name, see `clock_limits`.
        asked: names of the tolerances that the user gave.

    Raises:
        InvalidInput: names the columns that stand still, and some that move.
    """
    for name in asked:
        quantity, allowed = limited_quantity(name), tolerance[name]
        if quantity not in MOTION:
            continue
        travels = exact_travels(table, quantity)
        moving = [column for column, travel in travels.items() if travel > allowed]
        still = [column for column in travels if column in table.values]
        if not set(moving) & set(still):
            what = f"{', '.join(still[:MAX_LISTED_COLUMNS])} {'moves' if len(still) == 1 else 'move'}"
            give = f"; give a column that moves: {', '.join(moving[:MAX_LISTED_COLUMNS])}" if moving else ""
            raise InvalidInput(
                f"--tolerance {name}={allowed:g}: it judges nothing, for the exact {what} by no more than that{give}"
            )


def still_columns(table: TableComparison, travel: float) -> list[str]:
    """Columns of the quantities whose columns all travel less than a limit, normalised, in the exact motion."""
    still = list[str]()
    for quantity in MOTION:
        own = {name: size for name, size in exact_travels(table, quantity).items() if name in table.values}
        if own and max(own.values()) <= travel:
            still += own
    return still


def unjudged_quantities(table: TableComparison, tolerance: Mapping[str, float]) -> tuple[str, ...]:
    """Quantities that a table and its tolerances leave unjudged, as `position of M.y`, `velocity`."""
    return tuple(_list_unjudged(table, tolerance)) if tolerance else ()


def _list_unjudged(table: TableComparison, tolerance: Mapping[str, float]) -> Iterator[str]:
    """Yield the quantities that are not judged, in words."""
    for quantity in MOTION:
        limits = [allowed for name, allowed in tolerance.items() if limited_quantity(name) == quantity]
        if not limits:
            yield quantity
        elif missing := _missing_columns(table, quantity, min(limits)):
            yield f"{quantity} of {list_names(missing, MAX_LISTED_COLUMNS)}"
    for quantity in ROTATIONS:
        if (links := table.links(quantity)) and quantity not in tolerance:
            yield f"{quantity.replace('_', ' ')} of {', '.join(links[:MAX_LISTED_COLUMNS])}"
    if CRANK_ANGLE not in table.values or "phase" not in tolerance:
        yield "crank angle"


def _missing_columns(table: TableComparison, quantity: str, allowed: float) -> list[str]:
    """Points, or single components of points, that move by more than is allowed and have no column."""
    travels, letter, found = exact_travels(table, quantity), MOTION[quantity][0], list[str]()
    for point in table.scene.lengths:
        own = [f"{point}.{letter}{axis}" for axis in AXES]
        missing = [column for column in own if travels[column] > allowed and column not in table.values]
        judged = [column for column in own if travels[column] > allowed and column in table.values]
        still = [column for column in own if column in table.values and column not in judged]
        if missing and not judged:
            found.append(f"{point} ({', '.join(still)} stands still)" if still else point)
        else:
            found += missing
    return found
