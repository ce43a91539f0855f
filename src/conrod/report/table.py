"""A table as a value: what it says, not how a medium shows it."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Literal, TypeAlias

Tone = Literal["good", "bad", "odd"]
VERDICT = "verdict"  # the heading of what a row comes to


@dataclass(frozen=True)
class Toned:
    """A cell that stands out: `good` within tolerance, `bad` out of it, `odd` for a run that ended otherwise."""

    text: str
    tone: Tone


Cell: TypeAlias = str | Toned


@dataclass(frozen=True)
class Table:
    """Rows of texts under headings.

    Attributes:
        headings: one for each column.
        rows: cells, as many as there are headings.
        right: headings of the columns that are set flush right, as numbers are.
        title: above the table; empty where what stands around it says enough.
        names: number of the first columns, which name a row.
    """

    headings: tuple[str, ...]
    rows: tuple[tuple[Cell, ...], ...]
    right: frozenset[str] = frozenset()
    title: str = ""
    names: int = 1

    def __bool__(self) -> bool:
        return bool(self.rows)


def table(
    headings: Sequence[str], rows: Iterable[Sequence[Cell]], right: Iterable[str] = (), title: str = "", names: int = 1
) -> Table:
    """A table of rows of any kind.

    Raises:
        ValueError: a row has not as many cells as there are headings.
    """
    body = tuple(tuple(row) for row in rows)
    if any(len(row) != len(headings) for row in body):
        raise ValueError(f"rows do not fit the headings {', '.join(headings)}")
    return Table(tuple(headings), body, frozenset(right), title, names)


def text_of(cell: Cell) -> str:
    """The words of a cell."""
    return cell.text if isinstance(cell, Toned) else cell
