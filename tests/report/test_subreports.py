"""The first page of a report lists the reports in folders below, with their findings, and leads nowhere else."""

from __future__ import annotations

import json
import re
import shutil
from pathlib import Path

import pytest

from conrod.report.subreports import report_mark, subreports
from tests.report.test_report import a_study, index_of, write_report

REPORTS = Path(__file__).parents[2] / "reports"


def folders_without_a_link(page: str, folder: Path) -> set[str]:
    """Folders with a page in Markdown that a page of the folder above does not link."""
    with_pages = {one.name for one in folder.iterdir() if one.is_dir() and any(one.glob("*.md"))}
    return with_pages - {target.split("/")[0] for target in re.findall(r"\]\(([^)#]+)", page) if "/" in target}


def test_first_page_of_reports_links_every_folder() -> None:
    page = index_of(REPORTS)
    assert folders_without_a_link(page, REPORTS) == set()
    # Negative control: a link that is not there.
    assert folders_without_a_link(page.replace("(sweep/README.md)", "(nothing)"), REPORTS) == {"sweep"}


def test_first_page_of_reports_has_todays_findings() -> None:
    found = subreports(REPORTS)
    assert [one.name for one in found if not one.finding] == []
    assert [one.line for one in found if f"- {one.line}\n" not in index_of(REPORTS)] == []


def test_both_reports_of_a_folder_are_linked() -> None:
    pages = [one.page for one in subreports(REPORTS) if one.name == "space"]
    assert pages == ["space/loops.md", "space/space.md"]
    assert all(f"({page})" in index_of(REPORTS) for page in pages)


def test_page_of_the_press_links_its_printed_table() -> None:
    page = (REPORTS / "shear-press.md").read_text(encoding="utf-8")
    assert "(audit/shear-press.md)" in page
    assert (REPORTS / "audit" / "shear-press.md").is_file()


@pytest.mark.usefixtures("undrawn")
def test_reports_below_are_listed_with_their_findings(tmp_path: Path) -> None:
    shutil.copytree(REPORTS / "limits", tmp_path / "limits", ignore=shutil.ignore_patterns("data", "figures"))
    write_report(tmp_path, a_study("saw-500rpm"), a_study("saw-40rpm"))
    line = "- [limits](limits/README.md): Limits. 423 of 3063 runs were wrong without any warning.\n"
    assert line in index_of(tmp_path)
    pages = {name: (tmp_path / f"{name}.md").read_text(encoding="utf-8") for name in ("saw-500rpm", "saw-40rpm")}
    assert "[limits: Limits](limits/saw-500rpm.md)" in pages["saw-500rpm"]
    assert "limits/" not in pages["saw-40rpm"]  # which that report does not have


def a_report(folder: Path, page: str, document: str = report_mark("own")) -> None:
    folder.mkdir()
    (folder / "README.md").write_text(page, encoding="utf-8")
    (folder / "results.json").write_text(document, encoding="utf-8")


def test_a_finding_is_what_a_page_states_in_bold(tmp_path: Path) -> None:
    a_report(tmp_path / "a", "# Title\n\nWords with **bold** in them.\n\n- **Two of [three](x.md)**: the rest.\n")
    a_report(tmp_path / "b", "# Well?\n\nNothing.\n")
    a, b = subreports(tmp_path)
    assert a.line == "[a](a/README.md): Title. Two of three."
    assert b.line == "[b](b/README.md): Well?"


@pytest.mark.parametrize(
    "document", ["", "[1]", "{}", '{"kind": "sweep"}', '{"kind": "sweep", "schema": 2, "conrod": "0", "parts": 3}']
)
def test_a_folder_without_a_sound_report_is_not_listed(document: str, tmp_path: Path) -> None:
    a_report(tmp_path / "docs", "# Pages of others\n\n**Not a report.**\n", document)
    assert subreports(tmp_path) == []


def test_a_changed_report_leads_to_no_file_of_others(tmp_path: Path) -> None:
    parts = {"saw": {"page": "../../etc/passwd"}, "press": {"page": "press.md"}}
    a_report(tmp_path / "a", "# A\n", json.dumps({"kind": "other", "schema": 2, "conrod": "0", "parts": parts}))
    assert subreports(tmp_path)[0].parts == {"press": "a/press.md"}
