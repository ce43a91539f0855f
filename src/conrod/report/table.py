"""Tables as values, and texts made safe for a terminal, Markdown, HTML and SVG.

Nothing in a text from a user's file may act on a terminal, a browser or a reader, such as control characters or links.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Literal, TypeAlias

from conrod.errors import COMMANDING_CHARACTERS

MAX_ERROR_CHARACTERS = 640  # of an error's line: room for two long paths and the causes
# In Markdown: the start of a tag, of an image, or of a link that leads out of the report.
_HAZARD = re.compile(r"<(?=[A-Za-z/!?])|!(?=\[)|\](?=\([^)]*([:&]|//)|:\s*(<[^>]*|\S*)([:&]|//))")
_ENTITIES = {"<": "&lt;", "!": "&#33;", "]": "&#93;"}


def visible_text(text: str) -> str:
    """Replace control characters by question marks; tabs and line ends stay."""
    return text.translate(COMMANDING_CHARACTERS)


def safe_markdown(text: str) -> str:
    """Escape HTML, images and outward links in Markdown; its other marks stay."""
    # Entities, not backslashes: a backslash before them would escape them.
    return _HAZARD.sub(lambda found: _ENTITIES[found[0]], visible_text(text))


def safe_html(page: str) -> str:
    """Replace control characters in a whole page, whose maker has escaped the names in it."""
    return visible_text(page)


def safe_svg(drawing: str) -> str:
    """Replace control characters in a drawing."""
    return visible_text(drawing)


class Verbatim(str):
    """Text for a fenced block of code, where Markdown decodes no entities."""


def verbatim(text: str) -> Verbatim:
    """Make text safe for a fenced block, so that it cannot close the fence."""
    return Verbatim(visible_text(text).replace("```", "`` `"))


def one_line(message: str) -> str:
    """Return an error message on one line, cut in the middle if it is too long."""
    line = visible_text(" ".join(message.split()))
    return (
        line
        if len(line) <= MAX_ERROR_CHARACTERS
        else f"{line[: MAX_ERROR_CHARACTERS // 2]} ... {line[-MAX_ERROR_CHARACTERS // 2 + 5 :]}"
    )


Tone = Literal["good", "bad", "odd"]
VERDICT = "verdict"  # heading of the column of verdicts


@dataclass(frozen=True)
class ColouredCell:
    """A coloured cell: `good` within tolerance, `bad` out of it, `odd` for a failed run."""

    text: str
    tone: Tone


Cell: TypeAlias = str | ColouredCell


@dataclass(frozen=True)
class Table:
    """Rows of texts under headings.

    Attributes:
        headings: headings of the columns.
        rows: cells, one for each heading.
        right: headings of the columns that are set flush right, as numbers are.
        title: title above the table; empty for none.
        names: number of leading columns that name a row.
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
    """Make a table from rows of cells.

    Raises:
        ValueError: a row has more or fewer cells than the table has headings.
    """
    body = tuple(tuple(row) for row in rows)
    if any(len(row) != len(headings) for row in body):
        raise ValueError(f"rows do not fit the headings {', '.join(headings)}")
    return Table(tuple(headings), body, frozenset(right), title, names)


def cell_text(cell: Cell) -> str:
    """Return the text of a cell."""
    return cell.text if isinstance(cell, ColouredCell) else cell
