"""Pages for readers who hear them, zoom them or have no pointer: names, headings, landmarks and contrast."""

from __future__ import annotations

import json
import re
import runpy
from itertools import pairwise
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from html_pages import Found, found_in

from conrod.execution.writing import Batch
from conrod.report.html.markdown import Place, render_html
from conrod.report.html.page import html_report

ROOT = Path(__file__).parents[2]
REPORTS = ROOT / "reports"
STYLES = ROOT / "src" / "conrod" / "report" / "html" / "templates"
MIN_CONTRAST = 4.5  # of text, by WCAG 2, 1.4.3


def defects(found: Found) -> list[str]:
    """What a page lacks for a reader who does not see it."""
    tags = [tag for tag, _ in found.elements]
    levels = [int(tag[1]) for tag in tags if re.fullmatch("h[1-6]", tag)]
    missing = {
        "a language": ("html", {"lang": "en"}) not in found.elements,
        "a title": not "".join(found.texts.get("title", [])).strip(),
        "one main part": tags.count("main") != 1,
        "one first heading": levels.count(1) != 1,
        "headings without gaps": any(after > before + 1 for before, after in pairwise(levels)),
        "a way past its head": found.elements[tags.index("a")][1].get("class") != "skip" if "a" in tags else True,
    }
    lacking = [name for name, lacks in missing.items() if lacks]
    for tag, a in found.elements:
        named = a.get("alt") or a.get("aria-label") or a.get("aria-labelledby")
        hidden = a.get("aria-hidden") == "true" or a.get("role") == "presentation"
        if tag in ("img", "nav", "section") or (tag == "svg" and a.get("role") == "img"):
            lacking += [] if named or hidden else [f"a name of <{tag}>"]
        if tag == "th" and a.get("scope") != "col":
            lacking.append("the scope of a heading")
        if tag == "div" and a.get("class") == "scroll" and not (a.get("tabindex") == "0" and named):
            lacking.append("keys that scroll a table")
    return lacking


def unlabelled_inputs(page: str) -> int:
    """How many inputs and lists of choices stand outside a label."""
    return len(re.findall(r"<(?:input|select)\b", re.sub(r"<label>.*?</label>", "", page, flags=re.DOTALL)))


@pytest.fixture(scope="module")
def pages() -> dict[str, str]:
    site: Any = SimpleNamespace(**runpy.run_path(str(ROOT / "docs" / "site.py")))
    known = site.pages()
    return {
        "entrance": site.html_document([site.entrance(known)], site.places("README.md", "index.html", known)),
        "search": site.search_page([("P", "p.html", "H", "text")], known),
        "verification": (REPORTS / "verification" / "saw-500rpm.html").read_text(),
    }


@pytest.mark.parametrize("name", ["entrance", "search", "verification"])
def test_page_has_names_headings_and_landmarks(name: str, pages: dict[str, str]) -> None:
    assert defects(found_in(pages[name])) == []
    assert unlabelled_inputs(pages[name]) == 0


@pytest.mark.slow  # its findings are read and its curves made; pages of the same parts are looked at above
def test_page_of_a_machine_has_names_headings_and_landmarks() -> None:
    part = json.loads((REPORTS / "results.json").read_text())["parts"]["shear-press"]
    files = {name: (REPORTS / name).read_text() for name in ("results.json", *part["files"])}
    page = html_report([Batch(REPORTS, files)])
    assert defects(found_in(page)) == []
    assert unlabelled_inputs(page) == 0


@pytest.mark.parametrize(
    ("was", "now", "lack"),
    [
        ('<html lang="en">', "<html>", "a language"),
        ("</main>", "</main><main></main>", "one main part"),
        ("<h2", "<h4", "headings without gaps"),
        (' scope="col"', "", "the scope of a heading"),
        ('tabindex="0" aria-label="table', 'aria-label="table', "keys that scroll a table"),
        (' alt="', ' lost="', "a name of <img>"),
    ],
)
def test_planted_defects_of_a_page_are_found(was: str, now: str, lack: str, pages: dict[str, str]) -> None:
    page = pages["verification"]
    assert lack in defects(found_in(page.replace(was, now)))
    assert unlabelled_inputs(page.replace("<main>", "<main><input>")) == 1


def test_a_corner_without_words_is_no_heading() -> None:
    place = Place("p", 0, lambda *_: None, lambda _: None)
    tags = re.findall(r"<(t[hd])\b", render_html("| | a |\n| --- | --- |\n| b | c |\n", place))
    assert tags == ["td", "th", "td", "td"]


@pytest.mark.parametrize("code", ["```\ntext\n```\n", "    text\n"])
def test_keys_scroll_each_block_of_code(code: str) -> None:
    place = Place("p", 0, lambda *_: None, lambda _: None)
    assert re.findall("<pre[^>]*>", render_html(code, place)) == ['<pre tabindex="0">']


def luminance(colour: str) -> float:
    """Relative luminance of a colour, by WCAG 2."""
    full = colour[1:] if len(colour) == 7 else "".join(2 * one for one in colour[1:])
    parts = [int(full[k : k + 2], 16) / 255.0 for k in (0, 2, 4)]
    linear = [one / 12.92 if one <= 0.04045 else ((one + 0.055) / 1.055) ** 2.4 for one in parts]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]


def contrast(one: str, other: str) -> float:
    """Contrast of two colours, from 1 to 21."""
    low, high = sorted((luminance(one), luminance(other)))
    return (high + 0.05) / (low + 0.05)


def test_texts_contrast_with_their_ground_in_light_and_dark() -> None:
    style = (STYLES / "page.css").read_text()
    roots = re.findall(r":root \{([^}]*)\}", style)[:2]
    assert len(roots) == 2
    for root in roots:
        colours = dict(re.findall(r"--(\w+): (#[0-9a-f]+)", root))
        for ink in ("ink", "faint", "link", "bad"):
            for ground in ("ground", "raised"):
                assert contrast(colours[ink], colours[ground]) >= MIN_CONTRAST, (ink, ground)
        # Negative control: the colour of lines is none for text.
        assert contrast(colours["line"], colours["ground"]) < MIN_CONTRAST
    assert contrast("#000", "#ffffff") == pytest.approx(21.0)
