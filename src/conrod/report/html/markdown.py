"""Render Markdown pages as sections of one HTML page, with inline figures and internal links."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any
from urllib.parse import unquote

from markdown_it import MarkdownIt
from markdown_it.common.utils import escapeHtml
from markdown_it.renderer import RendererHTML
from markdown_it.rules_core import StateCore
from markdown_it.token import Token

from conrod.report.table import VERDICT

OUTWARD = ("https://", "http://")
# The only HTML in Markdown pages, on separate lines; names from users are escaped and cannot look like it.
NUMBER_CELL = re.compile(r"\**[<-]?\s*\d")
DETAILS = re.compile(r"<details>\s*<summary>([^<]+)</summary>|</details>")


@dataclass
class Place:
    """A Markdown page's place in the HTML document, and the state of its rendering.

    Attributes:
        anchor: id of the page, and prefix of the ids of its headings.
        shift: levels by which its headings are lowered.
        figure: returns the markup of a figure by the name of its file; None if the report has no such file.
        target: returns the address of a link; None if its page is missing, then only its text is shown.
        title: text of its first heading.
        level: level of the open heading.
        anchors: ids in use.
        links: stack that says of each open link or cell whether it has an <a> tag to close.
        command: id of the command that reproduces the page's numbers; empty for none.
    """

    anchor: str
    shift: int
    figure: Callable[[str, str], str | None]
    target: Callable[[str], str | None]
    title: str = ""
    level: int = 1
    anchors: set[str] = field(default_factory=set)
    links: list[bool] = field(default_factory=list)
    command: str = ""


def render_html(text: str, place: Place) -> str:
    """Render Markdown as HTML; no HTML in it is kept, except `<details>` on separate lines."""
    return str(_parser().render(text, {"place": place}))


def _parser() -> MarkdownIt:
    parser = MarkdownIt("commonmark", {"html": False}, renderer_cls=_Renderer).enable("table")
    parser.core.ruler.after("block", "details", _find_details)
    parser.core.ruler.after("block", "verdicts", _put_verdicts_first)
    return parser


CELL_TOKENS = 3  # tokens of a cell: its opening, its content, its end


def _put_verdicts_first(state: StateCore) -> None:
    """Move the column of verdicts before a table's numbers, where a small screen shows it."""
    move: tuple[int, int] | None = None
    for at, token in enumerate(state.tokens):
        if token.type != "tr_open":
            continue
        end = next(k for k in range(at, len(state.tokens)) if state.tokens[k].type == "tr_close")
        cells = [state.tokens[k : k + CELL_TOKENS] for k in range(at + 1, end, CELL_TOKENS)]
        if cells[0][0].type == "th_open":
            heads = [cell[1].content for cell in cells]
            numbers = [k for k, cell in enumerate(cells) if _alignment_class(cell[0])]
            to = numbers[0] if numbers else 1
            move = (heads.index(VERDICT), to) if VERDICT in heads and heads.index(VERDICT) > to else None
        if move is not None:
            cells.insert(move[1], cells.pop(move[0]))
            state.tokens[at + 1 : end] = [token for cell in cells for token in cell]


def _find_details(state: StateCore) -> None:
    for before, inline, after in zip(state.tokens, state.tokens[1:], state.tokens[2:], strict=False):
        if before.type == "paragraph_open" and DETAILS.fullmatch(inline.content):
            inline.type, before.hidden, after.hidden = "details", True, True


class _Renderer(RendererHTML):
    """Rendering rules that differ from markdown-it's; each renders the token of its name."""

    def heading_open(self, tokens: Sequence[Token], idx: int, options: Any, env: Any) -> str:
        place, token = env["place"], tokens[idx]
        again = token.tag == "h1" and bool(place.anchors)
        level = place.level = min(6, int(token.tag[1]) + place.shift + again)
        words = self.renderInlineAsText(tokens[idx + 1].children, options, env)
        name = re.sub(r"\W+", "-", words.lower()).strip("-")
        place.title = place.title or words
        anchor = f"{place.anchor}--{name}" if place.anchors else place.anchor
        while anchor in place.anchors:
            anchor += "-"
        place.anchors.add(anchor)
        return f'<h{level} id="{escapeHtml(anchor)}">'

    def heading_close(self, tokens: Sequence[Token], idx: int, options: Any, env: Any) -> str:
        return f"</h{env['place'].level}>\n"

    def table_open(self, tokens: Sequence[Token], idx: int, options: Any, env: Any) -> str:
        first = next(token.content for token in tokens[idx:] if token.type == "inline")
        # A table that is wider than the screen is scrolled in its box, also by the keyboard.
        label = escapeHtml(f"table by {first}")
        return f'<div class="scroll" role="group" tabindex="0" aria-label="{label}"><table>\n'

    def table_close(self, tokens: Sequence[Token], idx: int, options: Any, env: Any) -> str:
        return "</table></div>\n"

    def th_open(self, tokens: Sequence[Token], idx: int, options: Any, env: Any) -> str:
        # Without a text it is no heading.
        return f'<th scope="col"{_alignment_class(tokens[idx])}>' if tokens[idx + 1].content else "<td>"

    def th_close(self, tokens: Sequence[Token], idx: int, options: Any, env: Any) -> str:
        return "</th>\n" if tokens[idx - 1].content else "</td>\n"

    def td_open(self, tokens: Sequence[Token], idx: int, options: Any, env: Any) -> str:
        place, side = env["place"], _alignment_class(tokens[idx])
        place.links.append(bool(side and place.command and NUMBER_CELL.match(tokens[idx + 1].content)))
        # Not a stop for the Tab key: each page has its command once more, as text.
        link = f'<a class="n" tabindex="-1" href="#{escapeHtml(place.command)}">' if place.links[-1] else ""
        return f"<td{side}>{link}"

    def td_close(self, tokens: Sequence[Token], idx: int, options: Any, env: Any) -> str:
        return "</a></td>\n" if env["place"].links.pop() else "</td>\n"

    def link_open(self, tokens: Sequence[Token], idx: int, options: Any, env: Any) -> str:
        place, wanted = env["place"], str(tokens[idx].attrs["href"])
        target = wanted if wanted.startswith(OUTWARD) else place.target(unquote(wanted))
        place.links.append(target is not None)
        return "" if target is None else f'<a href="{escapeHtml(target)}">'

    def link_close(self, tokens: Sequence[Token], idx: int, options: Any, env: Any) -> str:
        return "</a>" if env["place"].links.pop() else ""

    def details(self, tokens: Sequence[Token], idx: int, options: Any, env: Any) -> str:
        found = DETAILS.fullmatch(tokens[idx].content)
        # Open, so that it is printed on paper and links lead into it.
        words = found and found[1]
        return f"<details open><summary>{escapeHtml(words)}</summary>\n" if words else "</details>\n"

    def fence(self, tokens: Sequence[Token], idx: int, options: Any, env: Any) -> str:
        return super().fence(tokens, idx, options, env).replace("<pre>", '<pre tabindex="0">', 1)

    def code_block(self, tokens: Sequence[Token], idx: int, options: Any, env: Any) -> str:
        return super().code_block(tokens, idx, options, env).replace("<pre>", '<pre tabindex="0">', 1)

    def image(self, tokens: Sequence[Token], idx: int, options: Any, env: Any) -> str:
        alt = self.renderInlineAsText(tokens[idx].children, options, env)
        shown = env["place"].figure(unquote(str(tokens[idx].attrs["src"])), alt)
        return escapeHtml(alt) if shown is None else shown


def _alignment_class(token: Token) -> str:
    """Return a right-aligned cell's class; the page's policy forbids markdown-it's style."""
    return ' class="right"' if "right" in str(token.attrs.get("style", "")) else ""
