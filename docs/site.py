"""The site, made from the committed results and pages: `python docs/site.py site`."""

from __future__ import annotations

import base64
import json
import os
import re
import sys
import zlib
from collections.abc import Callable, Iterable, Iterator, Mapping
from html.parser import HTMLParser
from pathlib import Path, PurePosixPath

from markupsafe import Markup

from conrod.execution.writing import Batch, write_together
from conrod.report.html.markdown import Place, render_html
from conrod.report.html.page import PageSection, SitePlace, html_document, image_html, page_sections, tiles_html
from conrod.report.kind import KINDS

ROOT = Path(__file__).parents[1]
ENTRANCE, DOCS, REPORTS, FIRST_DOC, SEARCH = "README.md", "docs", "reports", "docs/README.md", "search.html"
EXAMPLES, FIRST_EXAMPLE = "examples", "examples/README.md"
FIRST_REPORT = "reports/README.md"
MACHINES = ("reports", "reports/catalogue")  # whose pages the entrance leads to


def pages() -> dict[str, str]:
    """The file of the site that each page of the repository is, by its path."""
    folders = (DOCS, EXAMPLES, REPORTS)
    found = [ENTRANCE, *(p.relative_to(ROOT).as_posix() for top in folders for p in (ROOT / top).rglob("*.md"))]
    return {name: "index.html" if name == ENTRANCE else f"{name.removesuffix('.md')}.html" for name in found}


def addresses(page: str, site: dict[str, str]) -> Callable[[str], str | None]:
    """Where a link of a page leads within the site; None where the site does not have it."""

    def target(link: str) -> str | None:
        path, _, place = link.partition("#")
        wanted = os.path.normpath(PurePosixPath(page).parent / path).replace(os.sep, "/") if path else page
        if wanted not in site:
            return None
        there = relative(site[wanted], site[page])
        return f"{there}#{PurePosixPath(wanted).stem}--{place}" if place else there

    return target


def relative(file: str, seen_from: str) -> str:
    """The address of a file of the site, seen from another."""
    return os.path.relpath(file, PurePosixPath(seen_from).parent).replace(os.sep, "/")


def reports() -> Iterator[tuple[str, Batch]]:
    """Each page of a committed report with the files that it is made of."""
    for file in sorted((ROOT / REPORTS).rglob("*.json")):
        document_ = json.loads(file.read_text()) if file.parent.name != "data" else {}
        if document_.get("kind") not in KINDS or "parts" not in document_:  # or only marks its folder
            continue
        folder, shared = file.parent, {file.name: file.read_text()}
        tiled = [name for part in document_["parts"].values() for name in part["files"] if name.endswith("-moving.svg")]
        for names in (document_["files"] + tiled, *(part["files"] for part in document_["parts"].values())):
            for page in (name for name in names if name.endswith(".md")):
                read = [name for name in names if (folder / name).suffix in (".md", ".svg", ".json")]
                texts = {name: (folder / name).read_text() for name in read}
                yield (folder / page).relative_to(ROOT).as_posix(), Batch(folder, {**shared, **texts})


def plain(page: str, target: Callable[[str], str | None]) -> PageSection:
    """A page that no study made."""

    def figure(name: str, alt: str) -> str | None:
        file = (ROOT / page).parent / name
        return image_html(file.read_text(), alt) if file.suffix == ".svg" else None

    place = Place(PurePosixPath(page).stem, 0, figure, target)
    html = render_html((ROOT / page).read_text(), place)
    return PageSection(place.anchor, place.title, html)


# -- the entrance ------------------------------------------------------------------------------------------------------


def machines(site: Mapping[str, str]) -> str:
    """All machines in motion, each leading to its page."""
    files = [file for folder in MACHINES for file in sorted((ROOT / folder / "figures").glob("*-moving.svg"))]
    names = [(file.parents[1].relative_to(ROOT).as_posix(), file.stem.removesuffix("-moving"), file) for file in files]
    return tiles_html((site[f"{folder}/{name}.md"], name, file.read_text()) for folder, name, file in names)


def finding(page: str) -> str:
    """What a page states first in bold."""
    found = re.search(r"^\*\*(.+?)\*\*", (ROOT / page).read_text(), re.MULTILINE)
    return found[1] if found else ""


def entrance(site: dict[str, str]) -> PageSection:
    """The first page: what conrod is and for whom, a finding, its picture, all machines, and then how it is used."""
    read = plain(ENTRANCE, addresses(ENTRANCE, site))
    head, rest = read.html.split("<h2", 1)
    words, picture = head.split('<p><span class="figure', 1)
    alt = re.search(r"!\[([^]]+)]", (ROOT / ENTRANCE).read_text())
    found = Markup('<p class="finding"><b>Found:</b> {} <a href="{}">All results</a></p>\n').format(
        finding(FIRST_REPORT), site[FIRST_REPORT]
    )
    caption = Markup('<p class="caption">{}</p>\n').format(alt[1] if alt else "")
    shown = f'{words}{found}<p><span class="figure{picture}{caption}'
    return PageSection(read.anchor, read.title, f'{shown}<h2 id="machines">Machines</h2>\n{machines(site)}<h2{rest}')


def places(page: str, file: str, site: Mapping[str, str]) -> list[SitePlace]:
    """The parts of the site that the head of a page leads to."""
    folder = PurePosixPath(page).parent.as_posix()
    of_machine = folder in MACHINES and page != FIRST_REPORT
    found = {
        "Start": (site[ENTRANCE], page == ENTRANCE),
        "Machines": (f"{site[ENTRANCE]}#machines", of_machine),
        "Studies": (f"{site[FIRST_REPORT]}#README--other-reports", page.startswith(REPORTS) and not of_machine),
        "Notebooks": (site[FIRST_EXAMPLE], page.startswith(EXAMPLES)),
        "Documentation": (site[FIRST_DOC], page.startswith(DOCS)),
        "Search": (SEARCH, page == SEARCH),
    }
    return [SitePlace(name, relative(to, file), here) for name, (to, here) in found.items()]


# -- the search --------------------------------------------------------------------------------------------------------


class _Texts(HTMLParser):
    """The text below each heading of a page, without tables of numbers, scripts and pictures."""

    HEADINGS = ("h1", "h2", "h3", "h4", "h5", "h6")
    LEFT_OUT = ("script", "style", "svg", "form")

    def __init__(self, tables: bool) -> None:
        super().__init__()
        self.found: list[tuple[str, list[str], list[str]]] = []  # anchor, heading and text
        self._hidden = (*self.LEFT_OUT, *(() if tables else ("tbody",)))
        self._within, self._in_heading = 0, False

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self._within += tag in self._hidden
        if tag in self.HEADINGS:
            self.found.append((dict(attrs).get("id") or "", [], []))
            self._in_heading = True

    def handle_endtag(self, tag: str) -> None:
        self._within -= tag in self._hidden
        self._in_heading = self._in_heading and tag not in self.HEADINGS

    def handle_data(self, data: str) -> None:
        if self.found and not self._within:
            _, heading, text = self.found[-1]
            (heading if self._in_heading else text).append(data)


def entries(file: str, sections: Iterable[PageSection], tables: bool) -> Iterator[tuple[str, str, str, str]]:
    """What a search finds of a page: its title, address, heading and text, for each heading."""
    for section in sections:
        texts = _Texts(tables)
        texts.feed(section.html)
        for anchor, *parts in texts.found:
            heading, text = (" ".join("".join(words).split()) for words in parts)
            yield section.title, f"{file}#{anchor}" if anchor else file, heading, text


def search_page(found: Iterable[tuple[str, str, str, str]], site: Mapping[str, str]) -> str:
    """The page that searches all others, with their texts in it."""
    data = base64.b64encode(zlib.compress(json.dumps([*found], separators=(",", ":")).encode(), 9)).decode()
    html = (
        '<h1 id="search">Search</h1>\n<div class="search"><form role="search"><label>Words '
        '<input type="search" autocomplete="off" autofocus></label></form>\n'
        "<p>Searches documentation, machines and studies of this site; nothing is loaded.</p>\n"
        f'<output></output>\n<ol></ol>\n<script type="application/octet-stream">{data}</script></div>\n'
    )
    return html_document([PageSection("search", "Search", html)], places(SEARCH, SEARCH, site))


def build(out: Path) -> None:
    """Write the site into a folder."""
    site, studies = pages(), dict(reports())
    files: dict[str, str] = {}
    found: list[tuple[str, str, str, str]] = []
    for page, file in site.items():
        target = addresses(page, site)
        sections = page_sections(studies[page], outside=target) if page in studies else [plain(page, target)]
        found += entries(file, sections, tables=page not in studies)
        if page == ENTRANCE:
            sections = [entrance(site)]
        files[file] = html_document(sections, places(page, file, site))
    write_together([Batch(out, {**files, SEARCH: search_page(found, site)})])


if __name__ == "__main__":
    build(Path(sys.argv[1]))
