"""A report as one HTML file: it asks for nothing, what users name stays text, and it is written whole or not at all."""

from __future__ import annotations

import base64
import hashlib
import json
import os
import re
import shutil
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import pytest
from command_line import conrod
from html_pages import Found, found_in

from conrod.execution.writing import Batch
from conrod.report.html.markdown import Place, render_html
from conrod.report.html.page import html_report, image_html

REPORTS = Path(__file__).parents[2] / "reports"
# Kinds of reports that are committed, by a folder of each.
FOLDERS = ("limits", "sweep", "space/loops.json", "space/space.json")  # of several reports in one the file is named
RIGHT_TO_LEFT = "\U0001f529 \u05e9\u05dc\u05d5\u05dd"
HOSTILE = (
    f"</script><script>a()</script> \"'><img src=x onerror=a()> {RIGHT_TO_LEFT} [a](http://e) ![b](http://e/b.png)"
)


def place(**given: Any) -> Place:
    return Place(**{"anchor": "p", "shift": 0, "figure": lambda *_: None, "target": lambda _: None, **given})


def small_copy(folder: Path, source: Path = REPORTS) -> Path:
    """A report of the first part of another, which is a folder or the file of its results."""
    (results,) = [source] if source.suffix == ".json" else source.glob("*.json")
    source = results.parent
    document = json.loads(results.read_text())
    name, entry = next(iter(document["parts"].items()))
    (folder / "data").mkdir(parents=True)
    shutil.copy(source / entry["data"], folder / entry["data"])
    (folder / results.name).write_text(json.dumps({**document, "parts": {name: entry}}))
    return folder


def check_self_contained(found: Found) -> None:
    """No address but of places within the page or of pages that a reader may open; nothing that a policy forbids."""
    assert all(source.startswith("data:image/svg+xml,<svg") for source in found.values("src"))
    assert all(href.startswith(("#", "data:,", "https://")) for href in found.values("href"))
    assert not any("style" in a or any(name.startswith("on") for name in a) for _, a in found.elements)
    ids = found.values("id")
    assert len(ids) == len(set(ids))
    assert {href[1:] for href in found.values("href") if href.startswith("#")} <= set(ids)
    assert not re.search(r"@import|url\(", "".join(found.texts["style"]))


@pytest.mark.parametrize("name", FOLDERS)
@pytest.mark.usefixtures("undrawn")
def test_report_of_each_kind_is_one_self_contained_page(name: str, tmp_path: Path) -> None:
    file = tmp_path / "r.html"
    done = conrod("report", str(small_copy(tmp_path / "r", REPORTS / name)), "--html", str(file))
    assert (done.returncode, done.stderr, done.stdout) == (0, "", f"wrote {file}\n")
    page = file.read_text()
    assert not list((tmp_path / "r").glob("*.md"))  # the folder is as it was
    found = found_in(page)
    check_self_contained(found)
    tags = [tag for tag, _ in found.elements]
    assert tags.count("main") == tags.count("h1") == 1
    assert tags.count("section") == 2
    for kind in ("style", "script"):
        text = found.texts[kind][-1]  # before it data, which is no script
        digest = base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()
        assert f"{kind}-src 'sha256-{digest}'" in page


def test_page_contains_its_figures_with_alternative_texts() -> None:
    part = json.loads((REPORTS / "results.json").read_text())["parts"]["shear-press"]
    files = {name: (REPORTS / name).read_text() for name in ("results.json", *part["files"])}
    found = found_in(html_report([Batch(REPORTS, files)]))
    check_self_contained(found)
    pictures = [a for tag, a in found.elements if tag in ("svg", "img")]
    assert len(pictures) > 5
    assert all(a.get("aria-label") or a.get("aria-hidden") or a.get("alt") for a in pictures)


def test_a_picture_is_its_drawing_and_cannot_leave_its_attribute() -> None:
    drawing = """<svg a="100%">'#" & <script>a()</script>\n</svg>\n"""
    ((_, image),) = found_in(image_html(drawing, '"x"')).elements[1:]
    assert unquote(image["src"]) == f"data:image/svg+xml,{drawing.strip().replace(chr(10), '')}"
    assert image["alt"] == '"x"'


def test_hostile_names_stay_text_in_html() -> None:
    page = render_html(
        f"# {HOSTILE}\n\n{HOSTILE}\n\n| a | b |\n| --- | ---: |\n| {HOSTILE} | 1 |\n", place(command="c")
    )
    found = found_in(page)
    assert {tag for tag, _ in found.elements} == {
        "h1", "p", "a", "div", "table", "thead", "tbody", "tr", "th", "td"
    }  # fmt: skip
    assert set(found.values("href")) == {"http://e", "#c"}
    assert RIGHT_TO_LEFT in page


def test_folded_details_are_open_and_other_markup_stays_text() -> None:
    page = render_html("<details><summary>Every <b> & run</summary>\n\n| a |\n| --- |\n| 1 |\n\n</details>\n", place())
    assert "<details" not in page  # a name within the words is no words
    page = render_html("<details>\n<summary>Every run</summary>\n\nText <details> in it\n\n</details>\n", place())
    assert page.startswith("<details open><summary>Every run</summary>\n")
    assert page.count("<details") == page.count("</details>") == 1


def test_a_number_links_to_the_command_of_its_page() -> None:
    page = render_html(
        "| machine | x |\n| --- | ---: |\n| 3 saws | 1.0 |\n| none | n/a |\n", place(command="p--command")
    )
    assert re.findall(r'href="([^"]*)">([^<]*)', page) == [("#p--command", "1.0")]


def _set_entry(name: str, value: Any) -> Any:
    def change(folder: Path) -> None:
        file = folder / "results.json"
        file.write_text(json.dumps({**json.loads(file.read_text()), name: value}))

    return change


def _move_data_elsewhere(folder: Path) -> None:
    file = folder / "results.json"
    file.write_text(file.read_text().replace("data/", "../data/"))


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (_set_entry("schema", 99), "another version of conrod"),
        (_set_entry("parts", []), "it was changed since conrod wrote it"),
        (_set_entry("kind", "nothing"), "no report that can be rendered"),
        (lambda folder: (folder / "results.json").write_text('{"schema": 1, "conrod": "0.1.0"}'), "earlier conrod"),
        (_move_data_elsewhere, "is not in its folder"),
        (lambda folder: os.truncate(folder / "results.json", 100_000_000), "100 MB; conrod writes at most 50 MB"),
        (lambda folder: (folder / "data" / "shear-press.json").write_text("{}"), "do not fit"),
        (lambda folder: (folder / "data" / "shear-press.json").unlink(), "cannot be read"),
    ],
)
def test_a_folder_that_was_changed_is_refused_in_one_line(change: Any, said: str, tmp_path: Path) -> None:
    change(small_copy(tmp_path / "r"))
    done = conrod("report", str(tmp_path / "r"), "--html", str(tmp_path / "r.html"))
    assert (done.returncode, done.stdout, done.stderr.count("\n")) == (2, "", 1)
    assert said in done.stderr
    assert sorted(p.name for p in tmp_path.iterdir()) == ["r"]


@pytest.mark.usefixtures("undrawn")
def test_validate_writes_the_page_alone_or_beside_a_folder(tmp_path: Path) -> None:
    asked = ("validate", "saw-500rpm", "--engine", "pymunk", "--preset", "stock", "--steps-per-rev", "60")
    assert conrod(*asked, "--html", "a.html", cwd=tmp_path).stdout.endswith("report: a.html\n")
    assert conrod(*asked, "--html", "b.html", "--out", "r", cwd=tmp_path).returncode == 0
    assert sorted(p.name for p in tmp_path.iterdir()) == ["a.html", "b.html", "r"]
    page = (tmp_path / "a.html").read_text()
    check_self_contained(found_in(page))
    assert re.search("conrod validate saw-500rpm [^<]* --steps-per-rev 60 --html a.html</code>", page)
    assert " --out r</code>" in (tmp_path / "b.html").read_text()
