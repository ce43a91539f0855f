"""The site of all committed pages: what its first page says first, where each page leads, and the search."""

from __future__ import annotations

import base64
import json
import re
import runpy
import zlib
from pathlib import Path, PurePosixPath
from types import SimpleNamespace
from typing import Any

import pytest
from browser import browser, complaints, open_page
from html_pages import found_in

from conrod.report.html.markdown import Place, render_html
from conrod.report.html.page import PageSection, html_document

ROOT = Path(__file__).parents[2]
ENTRIES = [
    ("Glossary", "docs/glossary.html#glossary--branch", "Branch", "One of several assemblies of the same lengths."),
    ("Limits", "reports/limits/README.html", "Limits", "Where an engine goes to another branch, and says nothing."),
]


@pytest.fixture(scope="module")
def site() -> Any:
    return SimpleNamespace(**runpy.run_path(str(ROOT / "docs" / "site.py")))


def test_first_page_says_what_and_for_whom_before_its_pictures(site: Any) -> None:
    html = site.entrance(site.pages()).html
    said = [
        "cross-validated against mechanisms whose motion is known exactly",
        "For engineers who use MuJoCo or pymunk",
        re.escape(site.finding("reports/README.md")),
        "data:image/svg",
        "grey exact, blue MuJoCo as it comes</p>",
        '<h2 id="machines">',
        '<ul class="tiles">',
        "Install",
    ]
    places = [re.search(one, html) for one in said]
    assert None not in places
    assert [one.start() for one in places if one] == sorted(one.start() for one in places if one)
    assert len(site.finding("reports/README.md")) > 40
    assert site.finding("docs/README.md") == ""


def test_every_page_leads_to_all_parts_of_the_site(site: Any) -> None:
    pages = site.pages()
    files = {*pages.values(), "search.html"}
    for page, file in pages.items():
        found = site.places(page, file, pages)
        assert [one.name for one in found] == [
            "Start", "Machines", "Studies", "Notebooks", "Documentation", "Search",
        ]  # fmt: skip
        assert sum(one.here for one in found) == 1, page
        for one in found:
            path = one.address.partition("#")[0]
            there = str(PurePosixPath("/", file).parent / path)
            assert (Path(there).resolve().as_posix()[1:]) in files, (page, one)
    here = {page: next(one.name for one in site.places(page, pages[page], pages) if one.here) for page in pages}
    assert here["README.md"] == "Start"
    assert here["reports/catalogue/geneva.md"] == "Machines"
    assert here["reports/limits/saw-500rpm.md"] == here["reports/README.md"] == "Studies"
    assert here["docs/limits.md"] == "Documentation"
    assert here["examples/judge_my_model.md"] == "Notebooks"


def test_head_of_a_page_marks_the_part_that_it_is_of(site: Any) -> None:
    pages = site.pages()
    page = html_document([PageSection("p", "P", '<h1 id="p">P</h1>')], site.places("docs/ci.md", "docs/ci.html", pages))
    marked = [a["href"] for tag, a in found_in(page).elements if a.get("aria-current")]
    assert marked == ["README.html"]
    # A report that stands alone leads nowhere.
    assert "<nav" not in html_document([PageSection("p", "P", '<h1 id="p">P</h1>')])


def test_search_has_headings_and_texts_but_no_numbers_of_reports(site: Any) -> None:
    text = "# Title\n\nWords of it.\n\n## A part\n\n| machine | error |\n| --- | ---: |\n| saw | 7.9 |\n"
    html = render_html(text, Place("title", 0, lambda *_: None, lambda _: None))
    section = PageSection("title", "Title", html)
    found = [*site.entries("a/b.html", [section], tables=True)]
    assert found == [
        ("Title", "a/b.html#title", "Title", "Words of it."),
        ("Title", "a/b.html#title--a-part", "A part", "machine error saw 7.9"),
    ]
    assert [*site.entries("a/b.html", [section], tables=False)][1][3] == "machine error"
    page = site.search_page(ENTRIES, site.pages())
    (packed,) = re.findall('octet-stream">(.*?)</script>', page)
    assert [tuple(one) for one in json.loads(zlib.decompress(base64.b64decode(packed)))] == ENTRIES
    known = {one.address for one in site.places("search.html", "search.html", site.pages())}
    assert {href for href in found_in(page).values("href") if not href.startswith(("#", "data:,"))} == known


@pytest.mark.slow  # a browser; what the page has is looked at above
def test_search_lists_places_with_all_words_the_best_first(site: Any, tmp_path: Path) -> None:
    (tmp_path / "search.html").write_text(site.search_page(ENTRIES, site.pages()))
    hrefs = "return [...document.querySelectorAll('.search li a')].map((a) => a.getAttribute('href'))"
    with browser(width=400) as page:
        open_page(page, tmp_path / "search.html")
        box = page.find_element("css selector", ".search input")
        for words, links in {"branch": [0, 1], "branch nothing": [1], "branch xyz": [], "": []}.items():
            box.clear()
            box.send_keys(words + " ")
            found = page.execute_script(hrefs)
            assert found == [ENTRIES[k][1] for k in links], words
        assert complaints(page) == []


def lost_links(folder: Path) -> list[tuple[str, str]]:
    """Links of a site's pages, and addresses of its search, that lead to no file or no place in it."""
    pages = {file.resolve(): found_in(file.read_text()) for file in folder.rglob("*.html")}
    ids = {file: set(found.values("id")) for file, found in pages.items()}
    links = [(file, href) for file, found in pages.items() for href in found.values("href")]
    (packed,) = re.findall('octet-stream">(.*?)</script>', (folder / "search.html").read_text())
    entries = json.loads(zlib.decompress(base64.b64decode(packed)))
    links += [((folder / "search.html").resolve(), address) for _, address, *_ in entries]
    lost = []
    for file, link in links:
        path, _, place = link.partition("#")
        there = (file.parent / path).resolve() if path else file
        if not link.startswith(("https:", "data:")) and (there not in ids or (place and place not in ids[there])):
            lost.append((file.name, link))
    return lost


@pytest.mark.slow  # builds the whole site; its parts are looked at above
def test_links_and_search_of_the_whole_site_lead_somewhere(site: Any, tmp_path: Path) -> None:
    site.build(tmp_path)
    assert lost_links(tmp_path) == []
    # Negative control: a page less.
    (tmp_path / "docs" / "glossary.html").unlink()
    assert ("search.html", "docs/glossary.html#glossary") in lost_links(tmp_path)


def test_verdicts_stand_before_the_numbers_of_a_table() -> None:
    place = Place("p", 0, lambda *_: None, lambda _: None)
    table = "| engine | error | more | {} |\n| --- | ---: | --- | --- |\n| MuJoCo | 7.9 | m | out |\n"
    rows = re.findall(r"<t[hd]\b[^>]*>([^<]*)", render_html(table.format("verdict"), place))
    assert rows == ["engine", "verdict", "error", "more", "MuJoCo", "out", "7.9", "m"]
    # Negative control: another column stays where it is.
    rows = re.findall(r"<t[hd]\b[^>]*>([^<]*)", render_html(table.format("reason"), place))
    assert rows == ["engine", "error", "more", "reason", "MuJoCo", "7.9", "m", "out"]
