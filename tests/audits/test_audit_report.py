"""The committed report of the audits is what the code produces, and it opens with what an author needs first."""

from __future__ import annotations

import json
import re
from itertools import pairwise
from pathlib import Path

import pytest

from audits.__main__ import report
from audits.judged import DOCUMENTS, PAGES, audited
from audits.report.corrections import corrections, rank
from conrod.own.printed.verdicts import Audited
from conrod.report.writer import rendered_again

REPORT = Path(__file__).parents[2] / "reports" / "audit"
# The versions of what made a report stand in its results, and are others elsewhere.
MADE_BY = ("conrod", "environment")


@pytest.fixture(scope="module")
def files() -> dict[str, str]:
    return {name: str(content) for name, content in report(REPORT).files.items()}


@pytest.fixture(scope="module")
def audits() -> dict[str, Audited]:
    return {PAGES[number]: audited(number) for number in DOCUMENTS}


def without_versions(text: str) -> object:
    found = json.loads(text)
    parts = found.get("parts", {})
    for values in (found, *parts.values()):
        for name in MADE_BY:
            values.pop(name, None)
    return found


def test_the_committed_report_is_what_the_code_produces(files: dict[str, str]) -> None:
    committed = {str(path.relative_to(REPORT)): path for path in REPORT.rglob("*") if path.is_file()}
    assert sorted(committed) == sorted(files)
    for name, content in files.items():
        there = committed[name].read_text(encoding="utf-8")
        same = without_versions(there) == without_versions(content) if name.endswith(".json") else there == content
        assert same, f"{name}: make audit"


def test_it_is_rendered_again_from_what_it_saved(files: dict[str, str]) -> None:
    (again,) = rendered_again(REPORT)
    assert {name: text for name, text in again.files.items() if name.endswith(".md")} == {
        name: text for name, text in files.items() if name.endswith(".md")
    }


def test_every_item_stands_on_its_page_and_in_the_findings(audits: dict[str, Audited], files: dict[str, str]) -> None:
    for name, found in audits.items():
        page = files[f"{name}.md"]
        assert len(json.loads(files[f"data/{name}.json"])["verdicts"]) == len(found.verdicts)
        every = page[page.index("## Every number") :]
        assert len([line for line in every.splitlines() if re.match(r"\| \d", line)]) == len(found.verdicts)
    rows = [line for line in files["shear-press.md"].splitlines() if "| table of IV.2 |" in line]
    assert len(rows) == 584


def test_corrections_come_first_and_each_says_what_should_stand_there(
    audits: dict[str, Audited], files: dict[str, str]
) -> None:
    for name, found in audits.items():
        page = files[f"{name}.md"]
        assert page.index("## What to correct") < page.index("## Uncertainties") < page.index("## Every")
        assert page.count("read from a scan by a machine") == 1
        ranks = [rank(group[0]) for group in corrections(found.verdicts)]
        assert ranks == sorted(ranks)
        # A number that is wrong comes before a formula that is.
        assert all(a[0] != b[0] or a[1] <= b[1] for a, b in pairwise(ranks))
        assert all(group[0].should_be for group in corrections(found.verdicts))
    assert "only probable" in files["arc-cam.md"]
    assert "partly circular" in files["course-module.md"]


def test_nothing_in_the_report_is_a_trace_of_rounding(files: dict[str, str]) -> None:
    for name, content in files.items():
        if name.endswith((".md", ".json")):
            assert not re.search(r"\de-1[0-9]", content), name
