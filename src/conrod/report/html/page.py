"""A report as one self-contained HTML file, from the pages and figures of its folder."""

from __future__ import annotations

import base64
import hashlib
import json
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from typing import Any, NamedTuple

from jinja2 import Environment, PackageLoader, StrictUndefined, Template
from markupsafe import Markup, escape

from conrod.execution.writing import Batch
from conrod.report.figure import FOLDER as FIGURES
from conrod.report.figure import with_spots
from conrod.report.folder import restore_findings
from conrod.report.html.markdown import Place, render_html
from conrod.report.kind import Kind, Part, kind_named
from conrod.report.table import safe_html

TEMPLATES = "conrod.report.html"
PAGE_SUFFIX = ".md"
# Names of further scripts and styles, by the tag whose presence on a page requires them.
ASSET_MARKERS = {
    "machine": '<div class="machine"', "links": '<div class="links"', "spots": '<span class="spots"',
    "search": '<div class="search"',
}  # fmt: skip


@dataclass(frozen=True)
class PageSection:
    """A page of a report as a section of the HTML document.

    Attributes:
        anchor: its id.
        title: its title in lists of pages.
        html: its markup.
        command: command that reproduces it; empty if it takes several.
    """

    anchor: str
    title: str
    html: str
    command: str = ""


class SitePlace(NamedTuple):
    """A part of a site, linked from the head of each page.

    Attributes:
        name: its name in the head.
        address: where it begins, from the page.
        here: True if the page belongs to it."""

    name: str
    address: str
    here: bool


def html_report(batches: Sequence[Batch]) -> str:
    """Return the reports of a folder as one HTML file."""
    return html_document([section for number, batch in enumerate(batches) for section in page_sections(batch, number)])


def html_document(sections: Sequence[PageSection], places: Sequence[SitePlace] = ()) -> str:
    """Return an HTML file of some sections, with the title of the first.

    Args:
        sections: sections of the page, at least one.
        places: parts of the site that the page leads to; empty for a page that stands alone.
    """
    used = ["page", *(name for name, tag in ASSET_MARKERS.items() if any(tag in section.html for section in sections))]
    style, script = ("\n".join(_read_asset(f"{name}.{end}") for name in used) for end in ("css", "js"))
    return safe_html(
        html_template("page.html.jinja").render(
            sections=sections, style=style, script=script, style_hash=_policy_hash(style),
            script_hash=_policy_hash(script),
            places=places,
        )
    )  # fmt: skip


def page_sections(
    batch: Batch, number: int = 0, outside: Callable[[str], str | None] = lambda _: None
) -> list[PageSection]:
    """Return the sections of one report.

    Args:
        batch: files of the report.
        number: number of the report in a document of several.
        outside: returns the address of a page outside the document; None if it has none.
    """
    texts = {name: text for name, text in batch.files.items() if isinstance(text, str)}
    report = next(json.loads(text) for name, text in texts.items() if name.endswith(".json") and "/" not in name)
    kind, parts = kind_named(report["kind"]), report["parts"]
    pages = {entry["page"]: name for name, entry in parts.items() if entry["page"] in texts}
    first = [kind.index_file] if not kind.one_part and kind.index_file in texts else []
    # A report with only one part begins with that part.
    anchors = _anchors([*pages, *first] if len(pages) == 1 else [*first, *pages], f"-{number}" if number else "")
    found = []
    for file in anchors:
        entry: Mapping[str, Any] = parts[pages[file]] if file in pages else report
        place = _page_place(file, anchors, texts, outside, entry["command"] or "")
        if file in pages:
            live = _add_live_part(kind, pages[file], entry, texts, place)
        else:
            live = tiles_html(_tile_pictures(kind, parts, texts, place)) if len(parts) > 1 else ""
        verdict, end, rest = render_html(texts[file], place).partition("</p>\n")
        found.append(PageSection(place.anchor, place.title, verdict + end + live + rest, entry["command"] or ""))
    return found


def _add_live_part(kind: Kind[Any], name: str, entry: Mapping[str, Any], texts: Mapping[str, str], place: Place) -> str:
    """Return a part's interactive HTML, and drop the figures that it replaces from the page."""
    findings, shown = restore_findings(kind.findings, json.loads(texts[entry["data"]])), place.figure
    part = Part(name, findings, entry["command"], entry["conrod"])
    live = kind.live_html(part, place.anchor) if kind.live_html else ""
    figures = {figure.file: figure for figure in kind.page_of(part).figures}

    def figure(file: str, alt: str) -> str | None:
        if live and file.endswith(kind.replaced_figures):
            return ""
        found, spots = shown(file, alt), figures[file].laid_out_spots() if file in figures else []
        return with_spots(found, spots) if found and spots else found

    place.figure = figure
    return live


def image_html(svg: str, alt: str) -> str:
    """Return a figure as an HTML image, whose content can neither run scripts nor load files."""
    # Characters that would end the address or the attribute, and line ends, which an address loses.
    address = svg.strip().replace(">\n<", "><")
    for letter, written in {"%": "%25", "#": "%23", "\n": " ", "&": "&amp;", "'": "&#39;"}.items():
        address = address.replace(letter, written)
    kind = "figure moving" if "<animate" in svg else "figure"
    return f'<span class="{kind}"><img src=\'data:image/svg+xml,{address}\' alt="{escape(alt)}"></span>'


def inline_svg(svg: str, prefix: str) -> str:
    """Prepare an animated SVG with ids `b0`, `b1`, ... for a page, with a prefix that keeps its ids unique."""
    shapes = re.sub("<style>.*?</style>", "", svg, flags=re.DOTALL)
    shapes = shapes.replace("<svg ", '<svg aria-hidden="true" ', 1)
    return shapes.replace('id="b', f'id="{prefix}b').replace('href="#b', f'href="#{prefix}b')


def tiles_html(pictures: Iterable[tuple[str, str, str]]) -> str:
    """Return an HTML list of small animated links, empty without pictures.

    Args:
        pictures: address, name and SVG of each."""
    found = [
        Markup('<li><a href="{}">{} {}</a></li>').format(where, Markup(inline_svg(svg, f"tile{k}-")), name)
        for k, (where, name, svg) in enumerate(pictures)
    ]
    return str(Markup('<ul class="tiles">{}</ul>\n').format(Markup("").join(found))) if found else ""


def _tile_pictures(kind: Kind[Any], parts: Mapping[str, Any], texts: Mapping[str, str], place: Place) -> Iterable[Any]:
    for name, entry in parts.items() if kind.tile else ():
        where, svg = place.target(entry["page"]), texts.get(f"{FIGURES}/{name}{kind.tile}")
        if where and svg:
            yield where, name, svg


def _anchors(names: Sequence[str], end: str) -> dict[str, str]:
    """Return a unique id for each file of a page, made from its name."""
    found: dict[str, str] = {}
    for name in names:
        anchor = re.sub(r"[^\w.]+", "-", name.removesuffix(PAGE_SUFFIX)).strip("-") + end
        found[name] = anchor if anchor and anchor not in found.values() else f"{anchor}-page{len(found)}"
    return found


def _page_place(
    file: str,
    anchors: Mapping[str, str],
    texts: Mapping[str, str],
    outside: Callable[[str], str | None],
    command: str,
) -> Place:
    def figure(name: str, alt: str) -> str | None:
        return image_html(texts[name], alt) if name in texts else None

    def target(name: str) -> str | None:
        return f"#{anchors[name]}" if name in anchors else outside(name)

    return Place(
        anchors[file], int(file != next(iter(anchors))), figure, target, command=command and f"{anchors[file]}--command"
    )


def _read_asset(name: str) -> str:
    return files(TEMPLATES).joinpath("templates", name).read_text(encoding="utf-8")


def _policy_hash(text: str) -> str:
    """Return the hash by which a page's security policy allows a script or a style."""
    return "sha256-" + base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()


def html_template(name: str) -> Template:
    """Return an HTML template, which escapes its variables unless they are `Markup`."""
    return _environment().get_template(name)


@cache
def _environment() -> Environment:
    return Environment(
        loader=PackageLoader(TEMPLATES), undefined=StrictUndefined, autoescape=True, trim_blocks=True,
        lstrip_blocks=True,
    )  # fmt: skip
