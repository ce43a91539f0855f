"""Tables on a terminal, or as plain text where there is none."""

from __future__ import annotations

from collections.abc import Iterable

from rich import box
from rich.console import Console
from rich.table import Table as RichTable
from rich.text import Text

from conrod.report.table import Cell, Table, Toned

# Without a terminal there is no width to fit; tables then keep their columns whole.
PLAIN_WIDTH = 140
STYLES = {"good": "green", "bad": "red", "odd": "yellow"}
FRAME = box.HEAVY_HEAD


def console(plain_width: int = PLAIN_WIDTH) -> Console:
    """Standard output, as wide as the terminal, or wide enough where there is none."""
    # A user's file or body may be called ":key:".
    out = Console(highlight=False, emoji=False)
    return out if out.is_terminal else Console(highlight=False, emoji=False, width=plain_width)


def print_table(out: Console, table: Table, *, folding: Iterable[str] = (), framed: bool = True) -> None:
    """Print a table.

    Args:
        folding: headings of the columns whose cells may take several lines; others keep to one.
        framed: with lines around it.
    """
    shown = RichTable(
        title=Text(table.title) if table.title else None,
        title_justify="left",
        title_style="italic" if framed else "bold",
        box=FRAME if framed else None,
        pad_edge=framed,
    )
    folds = set(folding)
    for heading in table.headings:
        shown.add_column(
            Text(heading),  # brackets are units, not markup
            justify="right" if heading in table.right else "left",
            no_wrap=heading not in folds,
            overflow="fold" if heading in folds else "ellipsis",
        )
    for row in table.rows:
        shown.add_row(*(_text(cell) for cell in row))
    out.print(shown)


def print_lines(out: Console, lines: Iterable[str], indent: int = 0) -> None:
    """Print sentences as they are, each on a line of its own; a terminal wraps them."""
    for line in lines:
        out.print(" " * indent + line, markup=False, soft_wrap=True)


def _text(cell: Cell) -> Text:
    return Text(cell.text, STYLES[cell.tone]) if isinstance(cell, Toned) else Text(cell)
