"""What a user's file says is shown, and commands nothing: no terminal, no browser, no reader of a page."""

from __future__ import annotations

import re
from xml.etree import ElementTree

import pytest
from command_line import conrod
from matplotlib.figure import Figure as Canvas

from conrod.cli import say
from conrod.report.charts.canvas import drawing_style, svg_text
from conrod.report.figure import Figure
from conrod.report.table import LONGEST, Toned, table, verbatim
from conrod.report.template import _environment
from conrod.report.terminal import console, print_lines, print_table

TITLE = "\x1b]0;owned\x07\x9b2J <script>alert(1)</script> <img src=x onerror=a()> [a](javascript:a()) \u202egnp"
COMMANDING = {"\x1b", "\x07", "\x9b", "\u202e"}


@pytest.mark.parametrize("terminal", [False, True])
def test_a_terminal_shows_control_characters_as_question_marks(
    terminal: bool, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    if terminal:
        monkeypatch.setenv("FORCE_COLOR", "1")
    out = console()
    print_table(out, table(("body", TITLE), [(TITLE, Toned(TITLE, "bad"))], title=TITLE))
    print_lines(out, [TITLE])
    shown = capsys.readouterr().out
    assert shown.count("?]0;owned?") >= 4
    assert ("\x1b[31m" in shown) is terminal  # conrod's own colours stay
    assert COMMANDING.isdisjoint(re.sub("\x1b\\[[0-9;]*m", "", shown))


def test_an_error_is_one_line_without_control_characters() -> None:
    done = conrod("show", f"{TITLE}{'x' * 5000}\n\n")
    assert done.returncode == 2
    assert done.stderr.count("\n") == 1
    assert len(done.stderr) < LONGEST + 50
    assert COMMANDING.isdisjoint(done.stderr)


@pytest.mark.parametrize("kind", ["pipe", "terminal"])
def test_names_of_files_command_no_terminal_and_data_in_a_pipe_stays(
    kind: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("sys.stdout.isatty", lambda: kind == "terminal")
    say(f"report: {TITLE}")
    assert COMMANDING.isdisjoint(capsys.readouterr().out)
    say("\u202edata", nl=False)
    assert capsys.readouterr().out == ("?data" if kind == "terminal" else "\u202edata")


def test_a_figure_is_xml_whatever_a_name_has_in_it() -> None:
    with drawing_style():
        canvas = Canvas()
        canvas.add_subplot(title=TITLE, xlabel="-- a & b --")
        text = svg_text(canvas)
    assert COMMANDING.isdisjoint(text)
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
    assert COMMANDING.isdisjoint(inner)


def test_code_to_paste_stays_as_it_is_and_cannot_end_its_block() -> None:
    assert str(verbatim('<option timestep="0.001"/>')) == '<option timestep="0.001"/>'
    assert "```" not in verbatim("```\n<script>")
