"""A table as a value: what it says, not how a medium shows it; and texts that command no medium.

Texts from users' files are shown so that nothing in them commands a terminal, a browser or a reader.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Literal, TypeAlias

from conrod.errors import COMMANDING

MAX_ERROR_CHARACTERS = 640  # characters of an error's line: room for two long paths beside the causes
# In Markdown: what opens a tag or an image, and what makes a link of brackets, unless it leads to a file of the report.
_HAZARD = re.compile(r"<(?=[A-Za-z/!?])|!(?=\[)|\](?=\([^)]*([:&]|//)|:\s*(<[^>]*|\S*)([:&]|//))")
_ENTITIES = {"<": "&lt;", "!": "&#33;", "]": "&#93;"}


def visible_text(text: str) -> str:
    """The text with a question mark for each control character; tabs and line ends stay."""
    return text.translate(COMMANDING)


def safe_markdown(text: str) -> str:
    """The text without HTML and images of its own, and without links that leave the report; other marks stay."""
    # Entities, not backslashes: one that stands before would escape those.
    return _HAZARD.sub(lambda found: _ENTITIES[found[0]], visible_text(text))


def safe_html(page: str) -> str:
    """A whole page in which no character commands a reader; names in it are escaped by what makes the page."""
    return visible_text(page)


def safe_svg(drawing: str) -> str:
    """A whole drawing in which no character commands a reader."""
    return visible_text(drawing)


class Verbatim(str):
    """Text of a fenced block of code, in which an entity would be read as it is written."""


def verbatim(text: str) -> Verbatim:
    """The text as a fenced block shows it; nothing in it closes the fence."""
    return Verbatim(visible_text(text).replace("```", "`` `"))


def one_line(message: str) -> str:
    """The message of an error on one line of bounded length: its beginning, and its end with the nearest choice."""
    line = visible_text(" ".join(message.split()))
    return (
        line
        if len(line) <= MAX_ERROR_CHARACTERS
        else f"{line[: MAX_ERROR_CHARACTERS // 2]} ... {line[-MAX_ERROR_CHARACTERS // 2 + 5 :]}"
    )


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


def cell_text(cell: Cell) -> str:
    """The words of a cell."""
    return cell.text if isinstance(cell, Toned) else cell
