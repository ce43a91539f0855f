"""Linear systems of one sparse structure at many samples: an entry is a number, or an array over the samples.

Most entries of joint equations are the numbers +-1 with which a pin or a slide ties the places of two bodies
together. Elimination along them costs next to nothing, and leaves a small block that closes the mechanism's loops: one
unknown in a slider-crank, two in a four-bar linkage.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from conrod.motion import Array

Entry = float | Array
Pivots = tuple[tuple[int, int], ...]
# A number smaller than this may be a rounding error, or small beside other entries: it is no pivot.
LEAST_PIVOT = 0.5


@dataclass(frozen=True)
class _Step:
    """One unknown eliminated: the pivot, the others in its row, and what was subtracted times its row from which."""

    row: int
    column: int
    pivot: float
    others: Mapping[int, Entry]
    factors: tuple[tuple[int, Entry], ...]


class Elimination:
    """The factors of a batch of square matrices.

    Args:
        rows: of the matrix, each its entries by column.
        samples: length of the entries that are arrays.
        pivots: of matrices whose numbers are the same and stand at the same places; None looks for them, which takes
            longer than to eliminate.
    """

    def __init__(self, rows: Sequence[Mapping[int, Entry]], samples: int, pivots: Pivots | None = None) -> None:
        self._samples, self._size = samples, len(rows)
        left = {i: {c: v for c, v in row.items() if not _is_zero(v)} for i, row in enumerate(rows)}
        self._steps: list[_Step] = [_eliminate(left, *place) for place in pivots or ()]
        while pivots is None and (place := _constant_pivot(left)) is not None:
            self._steps.append(_eliminate(left, *place))
        gone = {step.column for step in self._steps}
        self._rows, self._columns = list(left), [c for c in range(self._size) if c not in gone]
        self._block = np.zeros((samples, len(left), len(left)))
        for i, row in enumerate(left.values()):
            for c, value in row.items():
                self._block[:, i, self._columns.index(c)] = value

    @property
    def pivots(self) -> Pivots:
        """Row and column of each number that was eliminated along, in order."""
        return tuple((step.row, step.column) for step in self._steps)

    def solve(self, right: Sequence[Entry]) -> Array:
        """Solutions (T, n) for one right-hand side, given row by row; not finite where the matrix is singular."""
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            known = list(right)
            for step in self._steps:
                for row, factor in step.factors:
                    known[row] = known[row] - factor * known[step.row]
            unknown: list[Entry] = [0.0] * self._size
            for column, value in zip(self._columns, self._solve_block([known[i] for i in self._rows]), strict=True):
                unknown[column] = value
            for step in reversed(self._steps):
                total = known[step.row]
                for column, value in step.others.items():
                    total = total - value * unknown[column]
                unknown[step.column] = total if step.pivot == 1.0 else total / step.pivot
        solution = np.empty((self._samples, self._size))
        for column, value in enumerate(unknown):
            solution[:, column] = value
        return solution

    def determinant_sign(self) -> Array:
        """Sign of the determinant (T,); 0 where the matrix is singular."""
        order = np.empty(self._size, dtype=int)
        order[[*(s.row for s in self._steps), *self._rows]] = [*(s.column for s in self._steps), *self._columns]
        constant = np.prod([step.pivot for step in self._steps]) * np.linalg.det(np.eye(self._size)[order])
        return np.asarray(np.sign(constant) * np.sign(np.linalg.det(self._block)), dtype=float)

    def _solve_block(self, right: list[Entry]) -> list[Entry]:
        if len(right) <= 1:
            return [value / self._block[:, 0, 0] for value in right]
        stacked = np.stack([np.broadcast_to(value, self._samples) for value in right], axis=1)
        return list((self._inverse @ stacked[:, :, None])[:, :, 0].T)

    @cached_property
    def _inverse(self) -> Array:
        try:
            return np.asarray(np.linalg.inv(self._block))
        except np.linalg.LinAlgError:
            return np.full_like(self._block, np.nan)


def _is_zero(entry: Entry) -> bool:
    return isinstance(entry, float | int) and entry == 0.0


def _constant_pivot(left: dict[int, dict[int, Entry]]) -> tuple[int, int] | None:
    """Row and column of the number whose elimination touches fewest entries; None if no number is left to take."""
    uses: dict[int, int] = {}
    for row in left.values():
        for column in row:
            uses[column] = uses.get(column, 0) + 1
    places = [
        ((len(row) - 1) * (uses[column] - 1), i, column)
        for i, row in left.items()
        for column, value in row.items()
        if isinstance(value, float | int) and abs(value) >= LEAST_PIVOT
    ]
    return min(places)[1:] if places else None


def _eliminate(left: dict[int, dict[int, Entry]], row: int, column: int) -> _Step:
    """Take a row out, and its pivot's unknown out of the others."""
    others = left.pop(row)
    pivot = float(others.pop(column))
    factors = []
    for i, entries in left.items():
        if column in entries:
            factor = entries.pop(column) / pivot
            factors.append((i, factor))
            for c, value in others.items():
                entries[c] = entries.get(c, 0.0) - factor * value
                if _is_zero(entries[c]):
                    del entries[c]
    return _Step(row, column, pivot, others, tuple(factors))
