"""What a user's file says is shown, and commands nothing: no terminal, no browser, no reader of a page."""

from __future__ import annotations

import json
import re
from html.parser import HTMLParser
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest
from cell_tasks import print_hostile
from command_line import conrod
from matplotlib.figure import Figure as Canvas

from conrod.cli import say
from conrod.errors import COMMANDING_CHARACTERS
from conrod.execution.local import call_isolated
from conrod.models.lint.findings import Finding, Report, Severity, sarif
from conrod.report.charts.canvas import drawing_style, svg_text
from conrod.report.figure import Figure
from conrod.report.folder import restore_findings
from conrod.report.html import page as html_page
from conrod.report.html.markdown import Place, render_html
from conrod.report.kind import KINDS, Part, kind_named
from conrod.report.table import MAX_ERROR_CHARACTERS, ColouredCell, table, verbatim
from conrod.report.template import _environment
from conrod.report.terminal import console, print_lines, print_table
from conrod.verification.page import Verification, VerificationSection, read_verification, sealed_page, valid_seal

TITLE = "\x1b]0;owned\x07\x9b2J <script>alert(1)</script> <img src=x onerror=a()> [a](javascript:a()) \u202egnp"
ESCAPES = {"\x1b", "\x07", "\x9b", "\u202e"}
REPORTS = Path(__file__).parents[2] / "reports"
SAW = REPORTS.parent / "mjcf" / "saw-500rpm.xml"


# One list for every medium: each names a column, a body or a file, and none is to do more than stand there.
HOSTILE = [
    TITLE,
    "![x](http://example.org/x.png)",
    "![x](//example.org/x.png)",
    "![x][y]\n\n[y]: http://example.org/x.png",
    "[x](http://example.org)",
    "[x](//example.org)",
    "[x](javascript:alert(1))",
    "<http://example.org>",
    "<img src=http://example.org/x.png>",
    "<!-- hidden",
    "x](http://example.org) ![y",
    "\\![x](http://example.org/x.png)",
    "a|b ![x](http://example.org/x.png)",
    "</script><script>alert(1)</script>",
    "]]></text><script>alert(1)</script>",
    '" onload="alert(1)',
    "{{ 7 * 7 }} {% raw %}",
    "\x1b[2J\x07\x9b\x00\x7f\x85",
    "\u202egnp\u2066\u200f\u061c",
    "a\u2028b\u2029c\ufff9\U000e0041",
    "half \ud800",
    "a\rb\x0cc",
]
MUST_NOT = {chr(code) for code in COMMANDING_CHARACTERS} - {"\t", "\n"}


class Loading(HTMLParser):
    """What a browser would load, run or follow outside of a page."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.found: list[str] = []
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        for name, value in attrs:
            outside = name in ("src", "href") and not (value or "").startswith(("data:", "#"))
            if outside or name.startswith("on"):
                self.found.append(f"{tag} {name}={value}")


@pytest.mark.usefixtures("undrawn")
@pytest.mark.parametrize("kind", KINDS)
def test_no_kind_of_report_takes_a_name_as_markup(kind: str, tmp_path: Path) -> None:
    """Every committed report, and one of each other kind, with its texts made hostile."""
    source = next((f for f in sorted(REPORTS.rglob("*.json")) if kind_of(f) == kind), None)
    if source is None:
        pytest.skip(f"no committed report is of the kind {kind}")
    document = json.loads(source.read_text(encoding="utf-8"))
    name, entry = min(document["parts"].items(), key=lambda one: (source.parent / one[1]["data"]).stat().st_size)
    values = json.loads((source.parent / entry["data"]).read_text(encoding="utf-8"))
    shown = 0
    for hostile in HOSTILE:
        text = hostile.replace("\ud800", "?")
        head = {"title": text, "command": text, "conrod": text}
        found = Part(name, restore_findings(kind_named(kind).findings, hostile_values(values, text)), text, text)
        try:
            page = kind_named(kind).page_of(found)
        except (ValueError, KeyError):  # a text that is a key of another table
            continue
        shown += 1
        html = document_of(kind, name, entry | head, page.text)
        assert MUST_NOT.isdisjoint(page.text)
        assert MUST_NOT.isdisjoint(html)
        assert Loading(html).found == []
        assert "<script>alert" not in html
    assert shown


FREE_TEXTS = {"title", "reason", "note", "notes", "description", "model", "file", "source", "quantity"}


def hostile_values(values: Any, text: str) -> Any:
    """Findings whose free texts are hostile."""
    if isinstance(values, dict):
        return {
            key: text if key in FREE_TEXTS and isinstance(value, str) else hostile_values(value, text)
            for key, value in values.items()
        }
    return [hostile_values(value, text) for value in values] if isinstance(values, list) else values


def kind_of(file: Path) -> str | None:
    document = json.loads(file.read_text(encoding="utf-8")) if file.parent.name != "data" else None
    return document.get("kind") if isinstance(document, dict) and document.get("parts") else None


def document_of(kind: str, name: str, entry: dict[str, Any], text: str) -> str:
    place = Place("page", 0, lambda file, alt: None, lambda file: None)
    return html_page.html_document(
        [html_page.PageSection("page", entry["title"], render_html(text, place), entry["command"])]
    )


@pytest.mark.parametrize("text", HOSTILE)
def test_no_value_of_a_template_is_an_image_or_leads_outside(text: str) -> None:
    for value in (
        text,
        table(("point", text), [(text, ColouredCell(text, "bad"))], title=text),
        Figure("x", text, str),
    ):
        page = _environment().from_string("{{ value }}").render(value=value, shown_figures={})
        html = document_of("", "", {"title": text, "command": text}, page)
        assert Loading(html).found == []
        assert MUST_NOT.isdisjoint(html)
        assert MUST_NOT.isdisjoint(page)


def test_a_link_within_the_report_and_a_templates_own_stay() -> None:
    # Negative control.
    page = _environment().from_string("[own](https://example.org) {{ value }}").render(value="[x](saw.md)")
    assert page == "[own](https://example.org) [x](saw.md)"
    assert Loading("<a href='https://example.org'>").found
    assert Loading("<p onload=a()>").found


@pytest.mark.parametrize("text", HOSTILE)
def test_figure_log_and_line_hold_no_control_characters(text: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert MUST_NOT.isdisjoint(Figure("x", "", lambda: f"<svg>{text}</svg>").svg())
    found = Finding(rule=text, subjects=(text,), what=text, severity=Severity.ERROR, evidence={}, why=text, fix=text)
    log = json.loads(sarif([Report(str(SAW), text, (found,))]))
    assert MUST_NOT.isdisjoint(json.dumps(log, ensure_ascii=False))
    say(text)
    print_lines(console(), [text])
    assert MUST_NOT.isdisjoint(capsys.readouterr().out)


@pytest.mark.parametrize("text", [one for one in HOSTILE if "\ud800" not in one])
def test_verification_report_keeps_its_data_and_runs_nothing(text: str) -> None:
    names = ("criteria", "code", "solution", "validation", "inputs", "software", "settings", "validity", "invariances")
    sections = {
        name: VerificationSection((table(("a", text), [(text, text)]),), (text,)) for name in (*names, "parameters")
    }
    page = sealed_page(Verification(text, text, "2026-01-01 00:00 UTC", text, sections, (text,)))
    assert valid_seal(page)
    assert read_verification(page).subject == text
    assert MUST_NOT.isdisjoint(page.decode())
    assert Loading(page.decode()).found == []


def test_engine_output_holds_no_control_characters(capfd: pytest.CaptureFixture[str]) -> None:
    assert call_isolated(print_hostile) is None
    shown = capfd.readouterr().err
    assert shown.count("gnp") == 2
    assert MUST_NOT.isdisjoint(shown)


@pytest.mark.parametrize("terminal", [False, True])
def test_a_terminal_shows_control_characters_as_question_marks(
    terminal: bool, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    if terminal:
        monkeypatch.setenv("FORCE_COLOR", "1")
    out = console()
    print_table(out, table(("body", TITLE), [(TITLE, ColouredCell(TITLE, "bad"))], title=TITLE))
    print_lines(out, [TITLE])
    shown = capsys.readouterr().out
    assert shown.count("?]0;owned?") >= 4
    assert ("\x1b[31m" in shown) is terminal  # conrod's own colours stay
    assert ESCAPES.isdisjoint(re.sub("\x1b\\[[0-9;]*m", "", shown))


def test_an_error_is_one_line_without_control_characters() -> None:
    done = conrod("show", f"{TITLE}{'x' * 5000}\n\n")
    assert done.returncode == 2
    assert done.stderr.count("\n") == 1
    assert len(done.stderr) < MAX_ERROR_CHARACTERS + 50
    assert ESCAPES.isdisjoint(done.stderr)


@pytest.mark.parametrize("kind", ["pipe", "terminal"])
def test_file_names_are_cleaned_and_piped_data_is_unchanged(
    kind: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("sys.stdout.isatty", lambda: kind == "terminal")
    say(f"report: {TITLE}")
    assert ESCAPES.isdisjoint(capsys.readouterr().out)
    say("\u202edata", nl=False)
    assert capsys.readouterr().out == ("?data" if kind == "terminal" else "\u202edata")


def test_figure_with_a_hostile_name_is_valid_xml() -> None:
    with drawing_style():
        canvas = Canvas()
        canvas.add_subplot(title=TITLE, xlabel="-- a & b --")
        text = svg_text(canvas)
    assert ESCAPES.isdisjoint(text)
    assert ElementTree.fromstring(text).tag.endswith("svg")
    assert "<script" not in text.replace("&lt;script", "")


@pytest.mark.parametrize(
    "value",
    [
        TITLE,
        table(("point", TITLE), [(TITLE, "1")], title=TITLE),
        Figure("x", TITLE, str),
        "\\<script>",
        "[a](\n java&#115;cript:a())",
    ],
)
def test_a_page_has_no_html_or_running_link_of_a_value(value: object) -> None:
    page = _environment().from_string("# <b>{{ value }}</b>").render(value=value, shown_figures={})
    assert page.startswith("# <b>")  # a template's own is left
    inner = page.removeprefix("# <b>").removesuffix("</b>")
    assert "<" not in inner
    assert "](j" not in inner.replace("\n ", "")
    assert "]: j" not in inner
    assert ESCAPES.isdisjoint(inner)


def test_code_to_paste_stays_as_it_is_and_cannot_end_its_block() -> None:
    assert str(verbatim('<option timestep="0.001"/>')) == '<option timestep="0.001"/>'
    assert "```" not in verbatim("```\n<script>")
