"""What README, CONTRIBUTING and docs/ name exists; the README is short, and its Python runs."""

from __future__ import annotations

import importlib.util
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
DOCS = ROOT / "docs"
MADE = {"benchmarks/results.json"}  # written by a command, not committed
PAGES = sorted([*ROOT.glob("*.md"), *DOCS.rglob("*.md")])
REPORTS = sorted((ROOT / "reports").rglob("*.md"))


def text(page: Path) -> str:
    return page.read_text(encoding="utf-8")


def anchors(page: Path) -> set[str]:
    """Anchors of a page's headings, as they are made from their words."""
    headings = re.findall(r"^#+ (.*)$", text(page), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).strip().replace(" ", "-") for heading in headings}


@pytest.mark.parametrize("page", [*PAGES, *REPORTS], ids=lambda page: str(page.relative_to(ROOT)))
def test_links_lead_somewhere(page: Path) -> None:
    for link in re.findall(r"\]\(([^)\s]+)\)", text(page)):
        if not link.startswith("http"):
            path, _, anchor = link.partition("#")
            target = (page.parent / path).resolve() if path else page
            assert target.exists(), link
            assert not anchor or anchor in anchors(target), link


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_files_and_modules_that_a_page_names_exist(page: Path) -> None:
    words = text(page)
    for path in re.findall(r"`((?:src|tests|docs|audits|benchmarks|golden)/[\w./-]+)`", words):
        assert (ROOT / path).exists() or "NAME" in path or path in MADE, path
    for path in re.findall(
        r"`((?:mechanism|exact|scenes|runs|engines|studies|own|mjcf|report|cli)/[\w/]+\.py)`", words
    ):
        assert (ROOT / "src" / "conrod" / path).exists(), path
    for module in re.findall(r"^from (conrod(?:\.\w+)*) import", words, re.MULTILINE):
        assert importlib.util.find_spec(module), module


def test_the_readme_is_short_and_its_python_runs(capsys: pytest.CaptureFixture[str]) -> None:
    readme = text(ROOT / "README.md")
    assert len(readme.split()) <= 900
    code = re.search(r"```python\n(.*?)```", readme, re.DOTALL)
    assert code
    exec(compile(code[1], "README.md", "exec"), {})
    outcome, error = capsys.readouterr().out.split()[:2]
    assert outcome == "Outcome.COMPLETED"
    assert float(error) == pytest.approx(7e-10, rel=0.1)


@pytest.mark.parametrize("defect", ["[x](docs/nothing.md)", "[x](docs/design.md#nothing)"])
def test_a_broken_link_is_found(defect: str, tmp_path: Path) -> None:
    page = tmp_path / "page.md"
    page.write_text(defect.replace("docs/", f"{DOCS}/"), encoding="utf-8")
    with pytest.raises(AssertionError):
        test_links_lead_somewhere(page)
