"""The committed report of the audits is what the code produces, and it opens with what an author needs first."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

from audits.__main__ import report
from conrod.report.writer import rendered_again

REPORT = Path(__file__).parents[2] / "reports" / "audit"
# The versions of what made a report stand in its results, and are others elsewhere.
MADE_BY = ("conrod", "environment")


@pytest.fixture(scope="module")
def files() -> dict[str, str]:
    return {name: str(content) for name, content in report(REPORT).files.items()}


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


def test_nothing_in_the_report_is_a_trace_of_rounding(files: dict[str, str]) -> None:
    for name, content in files.items():
        if name.endswith((".md", ".json")):
            assert not re.search(r"\de-1[0-9]", content), name
