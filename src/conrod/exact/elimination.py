"""Linear systems of one sparse structure at many samples: an entry is a number, or an array over the samples.

Most entries of joint equations are the numbers +-1 with which a pin or a slide ties the places of two bodies
together. Elimination along them costs next to nothing, and leaves what closes the mechanism's loops: one unknown in a
slider-crank, two in a four-bar linkage. Loops that follow each other are solved in that order, those that depend on
each other together: of a mechanism these are the Assur groups.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from conrod.exact.motion import Array

Entry = float | Array
Block = tuple[tuple[int, ...], tuple[int, ...]]  # rows, and as many columns
# A smaller number may be a rounding error, or small beside other entries, and is no pivot.
MIN_PIVOT = 0.5


@dataclass(frozen=True)
class _Step:
    """One unknown eliminated: its pivot, the rest of its row, and the multiples of it subtracted from other rows."""

    row: int
    column: int
    pivot: float
    others: Mapping[int, Entry]
    factors: tuple[tuple[int, Entry], ...]


@dataclass(frozen=True)
class PivotOrder:
    """Order of elimination: row and column of each constant pivot, then the blocks that remain."""

    pivots: tuple[tuple[int, int], ...]
    blocks: tuple[Block, ...]

    @cached_property
    def sign(self) -> float:
        """Sign of the permutation that brings rows and columns together: +1 even, -1 odd."""
        places = dict(self.pivots)
        for rows, columns in self.blocks:
            places |= zip(rows, columns, strict=True)
        return float(np.linalg.det(np.eye(len(places))[[places[row] for row in sorted(places)]]))


class Elimination:
    """The factors of a batch of square matrices.

    Args:
        rows: entries of each row by column.
        samples: length T of the entries that are arrays.
        order: from a matrix with the same numbers at the same places; None searches for one, which takes longer than to
            eliminate.
    """

    def __init__(self, rows: Sequence[Mapping[int, Entry]], samples: int, order: PivotOrder | None = None) -> None:
        self._samples, self._size = samples, len(rows)
        left = {i: {c: v for c, v in row.items() if not _is_zero(v)} for i, row in enumerate(rows)}
        self._steps: list[_Step] = [_eliminate(left, *place) for place in (order.pivots if order else ())]
        while order is None and (place := _constant_pivot(left)) is not None:
            self._steps.append(_eliminate(left, *place))
        if order is None:
            pivots = {step.row: step.column for step in self._steps}
            columns = [c for c in range(self._size) if c not in pivots.values()]
            blocks = triangular_blocks({i: tuple(sorted(row)) for i, row in left.items()}, columns)
            order = PivotOrder(tuple(pivots.items()), blocks)
        self.order = order
        self._blocks = [_Block(block, left, samples) for block in order.blocks]

    def solve(self, right: Sequence[Entry]) -> Array:
        """Solutions (T, n) for one right-hand side, given row by row; not finite where the matrix is singular."""
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            known = list(right)
            for step in self._steps:
                for row, factor in step.factors:
                    known[row] = known[row] - factor * known[step.row]
            unknown: list[Entry] = [0.0] * self._size
            for block in self._blocks:
                block.solve(known, unknown)
            for step in reversed(self._steps):
                total = known[step.row]
                for column, value in step.others.items():
                    total = total - value * unknown[column]
                unknown[step.column] = total if step.pivot == 1.0 else total / step.pivot
        return self._stack_columns(unknown)

    def solve_transposed(self, right: Sequence[Entry]) -> Array:
        """Solutions (T, n) of the transposed matrices, for one right-hand side given column by column of the matrix."""
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            known = list(right)
            unknown: list[Entry] = [0.0] * self._size
            for step in self._steps:
                unknown[step.row] = found = known[step.column] / step.pivot
                for column, value in step.others.items():
                    known[column] = known[column] - value * found
            for block in reversed(self._blocks):
                block.solve_transposed(known, unknown)
            for step in reversed(self._steps):
                for row, factor in step.factors:
                    unknown[step.row] = unknown[step.row] - factor * unknown[row]
        return self._stack_columns(unknown)

    def _stack_columns(self, unknown: Sequence[Entry]) -> Array:
        """Columns of a solution, numbers or arrays, as one array (T, n)."""
        solution = np.empty((self._samples, self._size))
        for column, value in enumerate(unknown):
            solution[:, column] = value
        return solution

    def determinant(self) -> Array:
        """Determinant (T,) of the matrix of the equations."""
        constant = math.prod([self.order.sign, *(step.pivot for step in self._steps)])
        return np.asarray(constant * self.block_determinants().prod(axis=1))

    def block_determinants(self) -> Array:
        """Determinants (T, k) of the blocks; the matrix is singular where one vanishes."""
        determinants = [np.linalg.det(block.matrix) for block in self._blocks]
        return np.stack(determinants, axis=1) if determinants else np.empty((self._samples, 0))


class _Block:
    """Equations that are solved together, after the blocks before them."""

    def __init__(self, block: Block, left: Mapping[int, Mapping[int, Entry]], samples: int) -> None:
        self._rows, self._columns = block
        self._samples = samples
        self.matrix = np.zeros((samples, len(self._rows), len(self._columns)))
        self._before: list[tuple[int, int, Entry]] = []
        for i, row in enumerate(self._rows):
            for column, value in left[row].items():
                if column in self._columns:
                    self.matrix[:, i, self._columns.index(column)] = value
                else:
                    self._before.append((row, column, value))

    def solve(self, known: list[Entry], unknown: list[Entry]) -> None:
        """Write the block's unknowns, after subtracting terms of earlier blocks from its right-hand sides."""
        for row, column, value in self._before:
            known[row] = known[row] - value * unknown[column]
        right = [known[row] for row in self._rows]
        if len(right) == 1:
            unknown[self._columns[0]] = right[0] / self.matrix[:, 0, 0]
            return
        for column, found in zip(self._columns, self._multiply(self._inverse, right), strict=True):
            unknown[column] = found

    def solve_transposed(self, known: list[Entry], unknown: list[Entry]) -> None:
        """Write the unknowns of the transposed block, and subtract them from earlier columns' right-hand sides."""
        transposed = np.swapaxes(self._inverse, 1, 2)
        found = self._multiply(transposed, [known[column] for column in self._columns])
        for row, values in zip(self._rows, found, strict=True):
            unknown[row] = values
        for row, column, value in self._before:
            known[column] = known[column] - value * unknown[row]

    def _multiply(self, inverse: Array, right: list[Entry]) -> Array:
        """Products (k, T) of matrices (T, k, k) and right-hand sides."""
        stacked = np.stack([np.broadcast_to(value, self._samples) for value in right], axis=1)
        return np.asarray((inverse @ stacked[:, :, None])[:, :, 0].T)

    @cached_property
    def _inverse(self) -> Array:
        try:
            return np.asarray(np.linalg.inv(self.matrix))
        except np.linalg.LinAlgError:
            return np.full_like(self.matrix, np.nan)


def _is_zero(entry: Entry) -> bool:
    return isinstance(entry, float | int) and entry == 0.0


def _constant_pivot(left: dict[int, dict[int, Entry]]) -> tuple[int, int] | None:
    """Row and column of the constant whose elimination changes fewest entries; None if no constant remains."""
    uses: dict[int, int] = {}
    for row in left.values():
        for column in row:
            uses[column] = uses.get(column, 0) + 1
    places = [
        ((len(row) - 1) * (uses[column] - 1), i, column)
        for i, row in left.items()
        for column, value in row.items()
        if isinstance(value, float | int) and abs(value) >= MIN_PIVOT
    ]
    return min(places)[1:] if places else None


def _eliminate(left: dict[int, dict[int, Entry]], row: int, column: int) -> _Step:
    """Remove a row, and its pivot's unknown from all other rows."""
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


# -- blocks that can be solved one after the other ---------------------------------------------------------------------
#
# Rows and columns are put in such an order that the matrix is block lower triangular, with blocks as small as its
# structure allows (Dulmage and Mendelsohn; Duff, Erisman and Reid, Direct Methods for Sparse Matrices, 2nd ed., chapter
# 6: a transversal first, then the strong components).


def triangular_blocks(entries: Mapping[int, Sequence[int]], columns: Sequence[int]) -> tuple[Block, ...]:
    """Blocks in the order of solution: entries of a block's rows outside its columns lie in earlier blocks.

    Args:
        entries: columns of the nonzero entries of each row.
        columns: number of columns, equal to that of rows.

    Returns:
        One block of everything if no choice of one entry in each row meets every column: the matrix is singular.
    """
    matched, rows = _transversal(entries), list(entries)
    if len(matched) < len(entries):
        return ((tuple(entries), tuple(columns)),)
    # needed[k, j]: row j has to be solved for the unknown of row k.
    needed = np.array([[matched[other] in entries[row] for other in rows] for row in rows], dtype=bool)
    needed = needed.reshape(len(rows), len(rows))
    for _ in range(len(rows).bit_length()):
        needed |= needed @ needed
    # Rows that need each other are a block; it needs more rows than any block that is solved before it for its sake.
    order = np.argsort(needed.sum(axis=1), kind="stable")
    blocks = dict.fromkeys(tuple(np.flatnonzero(needed[k] & needed[:, k])) for k in order)
    return tuple((tuple(rows[k] for k in block), tuple(sorted(matched[rows[k]] for k in block))) for block in blocks)


def _transversal(entries: Mapping[int, Sequence[int]]) -> dict[int, int]:
    """Match each row with a different column by augmenting paths; rows without a match are left out."""
    taken: dict[int, int] = {}

    def find(row: int, tried: set[int]) -> bool:
        for column in entries[row]:
            if column not in tried:
                tried.add(column)
                if column not in taken or find(taken[column], tried):
                    taken[column] = row
                    return True
        return False

    for row in entries:
        find(row, set())
    return {row: column for column, row in taken.items()}
