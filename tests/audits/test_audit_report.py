"""The committed report of the audit is what the code produces, and it says what an author needs first."""

from __future__ import annotations

import json
import re
from itertools import pairwise
from pathlib import Path

import pytest

from audits.__main__ import report
from audits.cam_survey import surveys
from audits.judged import DOCUMENTS, PAGES, audited
from conrod.own.printed.audited import Audited
from conrod.report.audit.corrections import corrections, rank
from conrod.studies.frame.files import Batch

REPORT = Path(__file__).parents[2] / "reports" / "audit"


@pytest.fixture(scope="module")
def audits() -> list[Audited]:
    return [audited(document) for document in DOCUMENTS]


@pytest.fixture(scope="module")
def batch() -> Batch:
    return report(REPORT)


def test_the_committed_report_is_what_the_code_produces(batch: Batch) -> None:
    committed = {str(path.relative_to(REPORT)): path for path in REPORT.rglob("*") if path.is_file()}
    assert sorted(committed) == sorted(batch.files)
    for name, content in batch.files.items():
        assert committed[name].read_text(encoding="utf-8") == content, f"{name}: make audit"
    assert batch.obsolete == ()


def test_all_584_cells_stand_on_the_press_page(batch: Batch) -> None:
    page = str(batch.files["shear-press.md"])
    rows = [line for line in page.splitlines() if "| table of IV.2 |" in line]
    assert len(rows) == 584
    angles = {re.search(r"theta = (\d+) deg", row).group(1) for row in rows}  # type: ignore[union-attr]  # all have one
    assert angles == {str(angle) for angle in range(0, 365, 5)}


def test_every_item_stands_on_its_page_and_in_the_results(audits: list[Audited], batch: Batch) -> None:
    results = json.loads(str(batch.files["results.json"]))["audit"]
    for found in audits:
        page = str(batch.files[f"{found.name}.md"])
        items = results[found.name]["items"]
        assert len(items) == len(found.verdicts)
        every = page[page.index("## Every number") :]
        rows = [line for line in every.splitlines() if re.match(r"\| \d", line)]
        assert len(rows) == len(items)


def test_corrections_come_first_and_each_says_what_should_stand_there(audits: list[Audited], batch: Batch) -> None:
    for found in audits:
        page = str(batch.files[f"{found.name}.md"])
        assert page.index("## What to correct") < page.index("## What is not certain") < page.index("## Every")
        ranks = [rank(group[0]) for group in corrections(found.verdicts)]
        assert ranks == sorted(ranks)
        # A number that is wrong comes before a formula that is.
        assert all(a[0] != b[0] or a[1] <= b[1] for a, b in pairwise(ranks))
        assert all(group[0].should_be for group in corrections(found.verdicts))


def test_doubts_are_told_once_a_page(batch: Batch) -> None:
    for name in PAGES.values():
        assert str(batch.files[f"{name}.md"]).count("read from a scan by a machine") == 1
    assert "only probable" in str(batch.files["arc-cam.md"])
    assert "partly circular" in str(batch.files["course-module.md"])


def test_every_cam_stands_in_every_table_of_the_series(batch: Batch) -> None:
    page = str(batch.files["arc-cam.md"])
    for found in surveys():
        # Four quantities, the joint B, the pressure angle; one more where a cam is the worst one.
        head = f"| {found.base:g} | {found.flank:g}{' (least)' if found.is_least else ''} |"
        assert page.count(head) >= 6


def test_nothing_in_the_report_is_a_trace_of_rounding(batch: Batch) -> None:
    for name, content in batch.files.items():
        if name.endswith((".md", ".json")):
            assert not re.search(r"\de-1[0-9]", str(content)), name
