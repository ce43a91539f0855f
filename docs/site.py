"""The site, made from the committed results and pages: `python docs/site.py site`."""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Callable, Iterator
from pathlib import Path, PurePosixPath

from conrod.report.html.markdown import Place, render_html
from conrod.report.html.page import PageSection, html_document, image_html, page_sections, tiles_html
from conrod.report.kind import KINDS
from conrod.execution.writing import Batch, write_together

ROOT = Path(__file__).parents[1]
ENTRANCE, DOCS, REPORTS = "README.md", "docs", "reports"
MACHINES = ("reports", "reports/catalogue")  # whose pages the entrance leads to


def pages() -> dict[str, str]:
    """The file of the site that each page of the repository is, by its path."""
    found = [ENTRANCE, *(f"{top}/{p.relative_to(ROOT / top).as_posix()}" for top in (DOCS, REPORTS) for p in (ROOT / top).rglob("*.md"))]
    return {name: "index.html" if name == ENTRANCE else f"{name.removesuffix('.md')}.html" for name in found}


def addresses(page: str, site: dict[str, str]) -> Callable[[str], str | None]:
    """Where a link of a page leads within the site; None where the site does not have it."""

    def target(link: str) -> str | None:
        path, _, place = link.partition("#")
        wanted = os.path.normpath(PurePosixPath(page).parent / path).replace(os.sep, "/") if path else page
        if wanted not in site:
            return None
        there = os.path.relpath(site[wanted], PurePosixPath(site[page]).parent).replace(os.sep, "/")
        return f"{there}#{PurePosixPath(wanted).stem}--{place}" if place else there

    return target


def reports() -> Iterator[tuple[str, Batch]]:
    """Each page of a committed report with the files that it is made of."""
    for file in sorted((ROOT / REPORTS).rglob("*.json")):
        document_ = json.loads(file.read_text()) if file.parent.name != "data" else {}
        if document_.get("kind") not in KINDS:
            continue
        folder, shared = file.parent, {file.name: file.read_text()}
        tiled = [name for part in document_["parts"].values() for name in part["files"] if name.endswith("-moving.svg")]
        for names in (document_["files"] + tiled, *(part["files"] for part in document_["parts"].values())):
            for page in (name for name in names if name.endswith(".md")):
                texts = {name: (folder / name).read_text() for name in names if (folder / name).suffix in (".md", ".svg", ".json")}
                yield (folder / page).relative_to(ROOT).as_posix(), Batch(folder, {**shared, **texts})


def plain(page: str, target: Callable[[str], str | None]) -> PageSection:
    """A page that no study made."""

    def figure(name: str, alt: str) -> str | None:
        file = (ROOT / page).parent / name
        return image_html(file.read_text(), alt) if file.suffix == ".svg" else None

    place = Place(PurePosixPath(page).stem, 0, figure, target)
    html = render_html((ROOT / page).read_text(), place)
    return PageSection(place.anchor, place.title, html)


def machines(site: dict[str, str]) -> str:
    """All machines in motion, each leading to its page."""
    files = [file for folder in MACHINES for file in sorted((ROOT / folder / "figures").glob("*-moving.svg"))]
    names = [(file.parents[1].relative_to(ROOT).as_posix(), file.stem.removesuffix("-moving"), file) for file in files]
    return tiles_html((site[f"{folder}/{name}.md"], name, file.read_text()) for folder, name, file in names)


def build(out: Path) -> None:
    """Write the site into a folder."""
    site, studies = pages(), dict(reports())
    files = {}
    for page, file in site.items():
        target = addresses(page, site)
        sections = page_sections(studies[page], outside=target) if page in studies else [plain(page, target)]
        if page == ENTRANCE:
            head, end, rest = sections[0].html.partition("</p>\n")
            sections = [PageSection("top", sections[0].title, f'{head}{end}<h2 id="top">Machines</h2>{machines(site)}{rest}')]
        files[file] = html_document(sections, home="" if page == ENTRANCE else target(os.path.relpath(ENTRANCE, PurePosixPath(page).parent)) or "")
    write_together([Batch(out, files)])


if __name__ == "__main__":
    build(Path(sys.argv[1]))
