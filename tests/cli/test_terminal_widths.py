"""At any width from 60 columns on, and in a pipe, what verbs print is whole: names, verdicts, numbers."""

from __future__ import annotations

import json
import re
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import click
import pytest
from command_line import conrod

from conrod.models.harden.study import harden_file
from conrod.models.harden.verb import hardening_to_print
from conrod.models.lint.linting import lint
from conrod.models.lint.verb import report_to_print
from conrod.report.folder import restore_findings
from conrod.report.kind import kind_named
from conrod.report.terminal import PrintedPart, print_parts

ROOT = Path(__file__).parents[2]
WIDTHS = (60, 100)
VERDICTS = ("within tolerance", "measured, not judged", "out of tolerance", "unsupported")
# Headings that a record does without.
NAMES = {"scene", "engine", "preset", "axis", "name", "parameter", "point", "link", "driven", "ingredient"}
NUMBER = re.compile(r"[<>-]?\d[\d.]*(e-?\d+)?")
Print = Callable[[], object]


@cache
def saved_findings(folder: str, kind: str) -> list[Any]:
    files = sorted((ROOT / "reports" / folder / "data").glob("*.json"))
    return [restore_findings(kind_named(kind).findings, json.loads(file.read_text())) for file in files]


@cache
def found_in_model() -> tuple[Any, Any]:
    file = ROOT / "mjcf" / "saw-500rpm.xml"
    return harden_file(file, seconds=0.024, content=False), lint(file, seconds=0.024)


def parts_to_print(kind: str, found: Sequence[Any]) -> Iterable[PrintedPart]:
    return kind_named(kind).printed(found)


PRINTED: dict[str, Callable[[], Iterable[PrintedPart]]] = {
    "validate": lambda: parts_to_print(
        "validation", [*saved_findings(".", "validation"), *saved_findings("catalogue", "validation")[::3]]
    ),
    "sweep": lambda: parts_to_print("sweep", saved_findings("sweep", "sweep")),
    "limits": lambda: parts_to_print("limits", saved_findings("limits", "limits")),
    "ablate": lambda: parts_to_print("ablate", saved_findings("ablate", "ablate")),
    "harden": lambda: hardening_to_print(replace(found_in_model()[0], lines=""), None),
    "lint": lambda: report_to_print(found_in_model()[1], None),
}
COMMANDS = {"show": ("show",), "show SCENE": ("show", "inverted-slider-crank", "--angle", "60deg")}


def lines_of(what: Print, width: int | None, capsys: pytest.CaptureFixture[str]) -> list[str]:
    """Lines that something prints on a terminal of a width, or in a pipe."""
    with pytest.MonkeyPatch.context() as patch:
        if width is not None:
            for name, value in (("FORCE_COLOR", "1"), ("TERM", "xterm"), ("COLUMNS", str(width)), ("LINES", "40")):
                patch.setenv(name, value)
        capsys.readouterr()
        done = what()
    text = done.stdout if hasattr(done, "stdout") else capsys.readouterr().out
    return click.unstyle(text).splitlines()


def numbers_in(lines: Sequence[str]) -> Counter[str]:
    words = (word.strip("();:,") for line in lines for word in line.split())
    return Counter(word for word in words if NUMBER.fullmatch(word))


def check_whole(narrow: Sequence[str], piped: Sequence[str], width: int) -> None:
    """Every word of the pipe is on the terminal, no number or verdict less often, and no line is too long."""
    assert max(map(len, narrow)) <= width
    words, wanted = ({word.strip(";:,") for line in lines for word in line.split()} for lines in (narrow, piped))
    assert {word for word in wanted - words - {*NAMES, "verdict"} if "─" not in word} == set()
    assert not numbers_in(piped) - numbers_in(narrow)
    for verdict in VERDICTS:
        assert " ".join(narrow).count(verdict) >= " ".join(piped).count(verdict), verdict
    for lines in (narrow, piped):
        assert not any("…" in line for line in lines)


@pytest.mark.parametrize("verb", [*PRINTED, *COMMANDS])
def test_output_of_each_verb_is_whole_at_any_width(verb: str, capsys: pytest.CaptureFixture[str]) -> None:
    what = (lambda: print_parts(PRINTED[verb]())) if verb in PRINTED else lambda: conrod(*COMMANDS[verb])
    piped = lines_of(what, None, capsys)
    assert [line for line in piped if line != line.rstrip()] == []
    for width in WIDTHS:
        check_whole(lines_of(what, width, capsys), piped, width)


def test_cut_line_or_lost_word_is_detected(capsys: pytest.CaptureFixture[str]) -> None:
    # Negative control.
    piped = lines_of(lambda: print_parts(PRINTED["sweep"]()), None, capsys)
    for width, narrow in ((60, piped), (60, [line[:60] for line in piped])):
        with pytest.raises(AssertionError):
            check_whole(narrow, piped, width)
    check_whole(piped, piped, max(map(len, piped)))
