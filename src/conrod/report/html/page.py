"""A report as one self-contained HTML file, made of the very pages and figures that its folder has."""

from __future__ import annotations

import base64
import hashlib
import json
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined, Template
from markupsafe import Markup, escape

from conrod.report.figure import FOLDER as FIGURES
from conrod.report.figure import with_spots
from conrod.report.folder import restore_findings
from conrod.report.html.markdown import Place, render_html
from conrod.report.html.moving import inline_svg
from conrod.report.kind import Kind, Part, kind_named
from conrod.report.table import safe_html
from conrod.studies.frame.writing import Batch

TEMPLATES = "conrod.report.html"
PAGE_SUFFIX = ".md"
# What a page has a script and styles for, beyond those of every page, where a tag says that it is there.
ASSET_MARKERS = {"machine": '<div class="machine"', "spots": '<span class="spots"'}


@dataclass(frozen=True)
class PageSection:
    """A page of a report as a part of the document.

    Attributes:
        anchor: its id.
        title: as lists of pages have it.
        html: its markup.
        command: what reproduces it; empty where that is not one command.
    """

    anchor: str
    title: str
    html: str
    command: str = ""


def html_report(batches: Sequence[Batch]) -> str:
    """The reports of a folder as one HTML file: their first pages, then the page of each part."""
    return html_document([section for number, batch in enumerate(batches) for section in page_sections(batch, number)])


def html_document(sections: Sequence[PageSection], home: str = "") -> str:
    """A whole HTML file of some sections, the first of which gives it its title.

    Args:
        home: address of the page that this one belongs to; empty for none.
    """
    used = ["page", *(name for name, tag in ASSET_MARKERS.items() if any(tag in section.html for section in sections))]
    style, script = ("\n".join(_asset(f"{name}.{end}") for name in used) for end in ("css", "js"))
    return safe_html(
        html_template("page.html.jinja").render(
            sections=sections, style=style, script=script, style_hash=_policy_hash(style),
            script_hash=_policy_hash(script),
            home=home,
        )
    )  # fmt: skip


def page_sections(
    batch: Batch, number: int = 0, outside: Callable[[str], str | None] = lambda _: None
) -> list[PageSection]:
    """The sections of one report, from the files that it consists of.

    Args:
        number: of the report, where several kinds are in one document.
        outside: address of a page that is not in the document; None where it has none.
    """
    texts = {name: text for name, text in batch.files.items() if isinstance(text, str)}
    report = next(json.loads(text) for name, text in texts.items() if name.endswith(".json") and "/" not in name)
    kind, parts = kind_named(report["kind"]), report["parts"]
    pages = {entry["page"]: name for name, entry in parts.items() if entry["page"] in texts}
    first = [kind.index_file] if not kind.one_part and kind.index_file in texts else []
    # What has one part is opened for that.
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
    """Tables and drawings of a part's page beside its text; figures that this makes needless are then left out."""
    findings, shown = restore_findings(kind.findings, json.loads(texts[entry["data"]])), place.figure
    part = Part(name, findings, entry["command"], entry["conrod"])
    live = kind.live(part, place.anchor) if kind.live else ""
    figures = {figure.file: figure for figure in kind.page_of(part).figures}

    def figure(file: str, alt: str) -> str | None:
        if live and file.endswith(kind.in_live):
            return ""
        found, spots = shown(file, alt), figures[file].laid_out_spots() if file in figures else []
        return with_spots(found, spots) if found and spots else found

    place.figure = figure
    return live


def image_html(svg: str, alt: str) -> str:
    """A figure as an image, which runs, loads and styles nothing beside itself."""
    # What an address or the attribute would end at, and line ends, which an address loses.
    address = svg.strip().replace(">\n<", "><")
    for letter, written in {"%": "%25", "#": "%23", "\n": " ", "&": "&amp;", "'": "&#39;"}.items():
        address = address.replace(letter, written)
    return f'<span class="figure"><img src=\'data:image/svg+xml,{address}\' alt="{escape(alt)}"></span>'


def tiles_html(pictures: Iterable[tuple[str, str, str]]) -> str:
    """Small moving pictures that lead somewhere: address, name and SVG of each; empty where there are none."""
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
    """An id for each file of a page, that is its name where that can be one."""
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


def _asset(name: str) -> str:
    return files(TEMPLATES).joinpath("templates", name).read_text(encoding="utf-8")


def _policy_hash(text: str) -> str:
    """The hash by which a page's policy allows a script or a style."""
    return "sha256-" + base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()


def html_template(name: str) -> Template:
    """A template of HTML; what it is given is escaped unless it is `Markup`."""
    return _environment().get_template(name)


@cache
def _environment() -> Environment:
    return Environment(
        loader=PackageLoader(TEMPLATES), undefined=StrictUndefined, autoescape=True, trim_blocks=True,
        lstrip_blocks=True,
    )  # fmt: skip
