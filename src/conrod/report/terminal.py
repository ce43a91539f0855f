"""Print tables and sentences on a terminal of any width, or as plain text, without cutting any."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import TypeAlias

from rich.cells import cell_len
from rich.console import Console, ConsoleOptions, RenderableType
from rich.segment import Segment
from rich.text import Text

from conrod.crash import OutputClosed
from conrod.errors import name_file_in_os_errors
from conrod.report.table import VERDICT, Cell, ColouredCell, Table, Verbatim, cell_text, visible_text

PrintedPart: TypeAlias = Table | str | Text  # a table, or a line; a `Verbatim` line is to be copied

UNBOUNDED_WIDTH = 100_000  # columns, where there is no terminal
MIN_FOLDED_WIDTH = 24  # columns; verdicts of two words then stay on a line
COLUMN_GAP, INDENT = "  ", "  "
STYLES = {"good": "green", "bad": "red", "odd": "yellow"}


class _SafeConsole(Console):
    """A console that prints no control characters of users' texts: see `conrod.report.table`."""

    def on_broken_pipe(self) -> None:
        """Raise: rich would end the command with the status of a verdict."""
        raise OutputClosed

    def render(self, renderable: RenderableType, options: ConsoleOptions | None = None) -> Iterator[Segment]:
        for one in super().render(renderable, options):
            yield one if one.control else Segment(visible_text(one.text), one.style)


def console(*, stderr: bool = False) -> Console:
    """Return a console on standard output or error, as wide as its terminal."""
    # A user's file or body may be called ":key:".
    out = _SafeConsole(highlight=False, emoji=False, stderr=stderr)
    return out if out.is_terminal else _SafeConsole(highlight=False, emoji=False, stderr=stderr, width=UNBOUNDED_WIDTH)


def print_parts(parts: Iterable[PrintedPart]) -> None:
    """Print tables and lines on standard output, in their order."""
    out = console()
    with name_file_in_os_errors("standard output"):
        for part in parts:
            if isinstance(part, Table):
                print_table(out, part)
            else:
                print_lines(out, [part], verbatim=isinstance(part, Verbatim))


def verdict_line(text: str, passed: bool | None) -> Text:
    """Return a verdict's line in green if it passed, in red if not."""
    return Text(text, {True: "green", False: "red", None: "default"}[passed])


def indented_under(subject: str, lines: Iterable[str]) -> list[PrintedPart]:
    """Return a subject with sentences indented under it, or nothing without sentences."""
    indented = [f"  {line}" for line in lines]
    return ["", subject, *indented] if indented else []


def print_table(out: Console, table: Table) -> None:
    """Print a table as a grid, or as records if the terminal is too narrow."""
    if table:
        print_lines(out, [Text(table.title, "bold")] if table.title else [])
        for line in _grid(out, table) or _records(out, table):
            line.rstrip()
            out.print(line, soft_wrap=True)


def print_lines(out: Console, lines: Iterable[str | Text], indent: int = 0, *, verbatim: bool = False) -> None:
    """Print each sentence on a new line, wrapped between words.

    Args:
        out: where to print.
        lines: the sentences.
        indent: columns to indent them by.
        verbatim: True for lines to be copied, which are not wrapped.
    """
    for line in lines:
        text = line if isinstance(line, Text) else Text(line)
        begin = indent + len(text.plain) - len(text.plain.lstrip())
        for part in [text] if verbatim else _wrapped_lines(out, text[begin - indent :], out.width - begin):
            part.rstrip()
            out.print(" " * (indent if verbatim else begin) if part else "", part, sep="", soft_wrap=True)


def _grid(out: Console, table: Table) -> list[Text] | None:
    """Return the lines of a table as a grid; None if it is wider than the console."""
    natural = [max(map(cell_len, map(cell_text, column))) for column in zip(table.headings, *table.rows, strict=True)]
    widths = [min(whole, _min_column_width(table, k)) for k, whole in enumerate(natural)]
    spare = out.width - sum(widths) - len(COLUMN_GAP) * (len(widths) - 1)
    if spare < 0:
        return None
    for k, whole in enumerate(natural):
        more = min(whole - widths[k], spare)
        widths[k], spare = widths[k] + more, spare - more
    rule = Text(COLUMN_GAP.join("─" * width for width in widths))
    lines = [line for row in table.rows for line in _row(out, table, row, widths)]
    return [*_row(out, table, table.headings, widths), rule, *lines]


def _min_column_width(table: Table, column: int) -> int:
    """Return the least width of a column that breaks no word, and only long sentences."""
    cells = [cell_text(row[column]) for row in table.rows]
    heading, longest = table.headings[column], max(map(cell_len, cells))
    if column >= table.names and heading not in table.right and longest > MIN_FOLDED_WIDTH:
        longest = max(MIN_FOLDED_WIDTH, *(cell_len(word) for cell in cells for word in cell.split()))
    return max(longest, *map(cell_len, heading.split() or [""]))


def _row(out: Console, table: Table, row: Sequence[Cell], widths: Sequence[int]) -> list[Text]:
    """Return the lines of a row, whose cells may take several lines."""
    cells = [_wrapped_lines(out, _styled_text(cell), width) for cell, width in zip(row, widths, strict=True)]
    lines = []
    for k in range(max(map(len, cells))):
        parts = [cell[k] if k < len(cell) else Text() for cell in cells]
        for part, heading, width in zip(parts, table.headings, widths, strict=True):
            part.align("right" if heading in table.right else "left", width)
        lines.append(Text(COLUMN_GAP).join(parts))
    return lines


def _records(out: Console, table: Table) -> list[Text]:
    """Return each row as a record: name and verdict on a line, the figures below."""
    lines = list[Text]()
    for row in table.rows:
        verdict = [k for k, heading in enumerate(table.headings) if heading == VERDICT]
        name = Text(", ").join(filter(None, map(_styled_text, row[: table.names])))
        head = Text(": ").join(filter(None, (name, *(_styled_text(row[k]) for k in verdict))))
        figures = Text("; ").join(
            Text(": ").join(filter(None, (Text(heading), _styled_text(cell))))
            for k, (heading, cell) in enumerate(zip(table.headings, row, strict=True))
            if k >= table.names and k not in verdict and cell_text(cell)
        )
        lines += _wrapped_lines(out, head, out.width)
        lines += [Text(INDENT) + line for line in _wrapped_lines(out, figures, out.width - len(INDENT)) if line]
    return lines


def _wrapped_lines(out: Console, text: Text, width: int) -> Sequence[Text]:
    """Wrap text into lines between words."""
    return list(text.wrap(out, width)) or [text]


def _styled_text(cell: Cell) -> Text:
    return Text(cell.text, STYLES[cell.tone]) if isinstance(cell, ColouredCell) else Text(cell)
