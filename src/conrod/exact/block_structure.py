"""The blocks of a sparse square matrix that can be solved one after the other.

Rows and columns are put in such an order that the matrix is block lower triangular, with blocks as small as its
structure allows (Dulmage and Mendelsohn; Duff, Erisman and Reid, Direct Methods for Sparse Matrices, 2nd ed., chapter
6: a transversal first, then the strong components by Tarjan's algorithm). Of a mechanism these are the Assur groups:
loops of a chain are closed one at a time, and only those that depend on each other are solved together.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

Block = tuple[tuple[int, ...], tuple[int, ...]]  # rows, and as many columns


def triangular_blocks(entries: Mapping[int, Sequence[int]]) -> tuple[Block, ...]:
    """Blocks in the order in which they are solved: what a row has outside of its own, stands in columns before.

    Args:
        entries: of each row the columns where it has some.

    Returns:
        One block of everything where no choice of one entry in each row meets every column: that is singular.
    """
    matched = _transversal(entries)
    if len(matched) < len(entries):
        return ((tuple(entries), tuple(sorted({c for columns in entries.values() for c in columns}))),)
    row_of = {column: row for row, column in matched.items()}
    needed = {row: [row_of[column] for column in columns] for row, columns in entries.items()}
    place = {row: k for k, row in enumerate(entries)}
    blocks = []
    for component in _components(needed):
        rows = sorted(component, key=place.__getitem__)
        blocks.append((tuple(rows), tuple(sorted(matched[row] for row in rows))))
    return tuple(blocks)


def _transversal(entries: Mapping[int, Sequence[int]]) -> dict[int, int]:
    """A column of its own for each row, by augmenting paths; fewer if there are none."""
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


def _components(needed: Mapping[int, Sequence[int]]) -> list[list[int]]:
    """Strong components of a graph, each after those that it needs (Tarjan, 1972)."""
    reached: dict[int, int] = {}
    lowest: dict[int, int] = {}
    pending: list[int] = []
    found: list[list[int]] = []

    def visit(node: int) -> None:
        reached[node] = lowest[node] = len(reached)
        pending.append(node)
        for other in needed[node]:
            if other not in reached:
                visit(other)
                lowest[node] = min(lowest[node], lowest[other])
            elif other in pending:
                lowest[node] = min(lowest[node], reached[other])
        if lowest[node] == reached[node]:
            first = pending.index(node)
            found.append(pending[first:])
            del pending[first:]

    for node in needed:
        if node not in reached:
            visit(node)
    return found
