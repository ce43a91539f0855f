"""Texts from users' files as each medium may show them: nothing in them commands a terminal, a browser or a reader."""

from __future__ import annotations

import re

LONGEST = 400  # characters of an error's line
# Control characters but tab and line end, and those that turn the direction of what follows.
_COMMANDING = [*range(0x09), *range(0x0B, 0x20), *range(0x7F, 0xA0), *range(0x202A, 0x202F), *range(0x2066, 0x206A)]
_VISIBLE = dict.fromkeys(_COMMANDING, "?")
# In Markdown: what opens a tag, and what makes a link of brackets, unless it leads to a file or a page.
_HAZARD = re.compile(r"<(?=[A-Za-z/!?])|\](?=\((?!\s*<?https?://)[^)]*[:&]|:(?!\s*<?https?://)\s*(<[^>]*|\S*)[:&])")


def visible(text: str) -> str:
    """The text with a question mark for each control character; tabs and line ends stay."""
    return text.translate(_VISIBLE)


def in_markdown(text: str) -> str:
    """The text without HTML of its own, and without links that run something; other marks stay."""
    # Entities, not backslashes: one that stands before would escape those.
    return _HAZARD.sub(lambda found: "&lt;" if found[0] == "<" else "&#93;", visible(text))


class Verbatim(str):
    """Text of a fenced block of code, in which an entity would be read as it is written."""


def verbatim(text: str) -> Verbatim:
    """The text as a fenced block shows it; nothing in it closes the fence."""
    return Verbatim(visible(text).replace("```", "`` `"))


def one_line(message: str) -> str:
    """The message of an error on one line of bounded length: its beginning, and its end with the nearest choice."""
    line = visible(" ".join(message.split()))
    return line if len(line) <= LONGEST else f"{line[: LONGEST // 2]} ... {line[-LONGEST // 2 + 5 :]}"
