"""A report as one self-contained HTML file, made of the very pages and figures that its folder has."""

from __future__ import annotations

import base64
import hashlib
import json
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined, Template
from markupsafe import Markup, escape

from conrod.report.html.markdown import Place, html_of
from conrod.report.html.svg import inlined
from conrod.report.kind import Kind, Part, kind_named
from conrod.report.saved import restore
from conrod.studies.frame.writing import Batch

TEMPLATES = "conrod.report.html"
ENDED = ".md"
SCRIPTS = ("page.js", "machine.js")


@dataclass(frozen=True)
class Section:
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
    return document([section for number, batch in enumerate(batches) for section in _sections(batch, number)])


def document(sections: Sequence[Section], home: str = "") -> str:
    """A whole HTML file of some sections, the first of which gives it its title.

    Args:
        home: address of the page that this one belongs to; empty for none.
    """
    style, script = _asset("page.css"), "\n".join(map(_asset, SCRIPTS))
    return template("page.html.jinja").render(
        sections=sections, style=style, script=script, style_hash=_digest(style), script_hash=_digest(script), home=home
    )  # fmt: skip


def _sections(batch: Batch, number: int) -> Iterable[Section]:
    """The sections of one report, from the files that it consists of; reports of several kinds are numbered."""
    texts = {name: text for name, text in batch.files.items() if isinstance(text, str)}
    report = next(json.loads(text) for name, text in texts.items() if name.endswith(".json") and "/" not in name)
    kind, parts = kind_named(report["kind"]), report["parts"]
    pages = {entry["page"]: name for name, entry in parts.items() if entry["page"] in texts}
    first = [kind.index_file] if kind.index is not None and kind.index_file in texts else []
    # What has one part is opened for that.
    anchors = _anchors([*pages, *first] if len(pages) == 1 else [*first, *pages], f"-{number}" if number else "")
    for file in anchors:
        entry: Mapping[str, Any] = parts[pages[file]] if file in pages else report
        place = _place(file, anchors, texts, deeper=file != next(iter(anchors)), numbers=bool(entry["command"]))
        live = _live(kind, pages[file], entry, texts, place) if file in pages else ""
        verdict, end, rest = html_of(texts[file], place).partition("</p>\n")
        yield Section(place.anchor, place.title, verdict + end + live + rest, entry["command"] or "")


def _live(kind: Kind[Any], name: str, entry: Mapping[str, Any], texts: Mapping[str, str], place: Place) -> str:
    """What a part's page shows beside its text; figures that this makes needless are then left out."""
    if kind.live is None:
        return ""
    findings = restore(kind.findings, json.loads(texts[entry["data"]]))
    live = kind.live(Part(name, findings, entry["command"], entry["conrod"], entry["options"]), place.anchor)
    if live:
        shown = place.figure
        above = Markup(f'<a href="#{escape(place.anchor)}--machine">In the curves above.</a>')
        place.figure = lambda file, alt: above if file.endswith(kind.in_live) else shown(file, alt)
    return live


def _anchors(names: Sequence[str], end: str) -> dict[str, str]:
    """An id for each file of a page, that is its name where that can be one."""
    found: dict[str, str] = {}
    for name in names:
        anchor = re.sub(r"[^\w.]+", "-", name.removesuffix(ENDED)).strip("-") + end
        found[name] = anchor if anchor and anchor not in found.values() else f"{anchor}-page{len(found)}"
    return found


def _place(file: str, anchors: Mapping[str, str], texts: Mapping[str, str], deeper: bool, numbers: bool) -> Place:
    def figure(name: str, alt: str) -> str | None:
        if name not in texts:
            return None
        number = sorted(texts).index(name)
        return f'<span class="figure">{inlined(texts[name], f"f{number}-", alt)}</span>'

    def target(name: str) -> str | None:
        return f"#{anchors[name]}" if name in anchors else None

    return Place(anchors[file], int(deeper), figure, target, f"{anchors[file]}--command" if numbers else "")


def _asset(name: str) -> str:
    return files(TEMPLATES).joinpath("templates", name).read_text(encoding="utf-8")


def _digest(text: str) -> str:
    """The hash by which a page's policy allows a script or a style."""
    return "sha256-" + base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()


def template(name: str) -> Template:
    """A template of HTML; what it is given is escaped unless it is `Markup`."""
    return _environment().get_template(name)


@cache
def _environment() -> Environment:
    return Environment(
        loader=PackageLoader(TEMPLATES), undefined=StrictUndefined, autoescape=True, trim_blocks=True,
        lstrip_blocks=True,
    )  # fmt: skip
