"""What is uploaded to a package index: files of the sdist, and a page without dead links (docs/releasing.md)."""

from __future__ import annotations

import runpy
import tomllib
from pathlib import Path
from typing import Any

import pytest
from hatchling.builders.sdist import SdistBuilder
from hatchling.metadata.core import ProjectMetadata
from hatchling.plugin.manager import PluginManager

ROOT = Path(__file__).parents[1]
HOOK: dict[str, Any] = runpy.run_path(str(ROOT / "hatch_build.py"))
README = (ROOT / "README.md").read_text(encoding="utf-8")
SOURCE = "https://example.org/people/conrod"


def uploaded_page(readme: str = README, source: str = SOURCE) -> str:
    page: str = HOOK["with_absolute_links"](readme, source, "1.2.3")
    return page


def links(page: str) -> list[str]:
    """Where all links and pictures of a page lead."""
    return [found[2] for pattern in (HOOK["LINK"], HOOK["IMAGE"]) for found in pattern.finditer(page)]


def relative_links(page: str) -> list[str]:
    return [link for link in links(page) if not HOOK["ABSOLUTE"].match(link)]


@pytest.mark.parametrize("source", [SOURCE, ""])
def test_no_link_of_an_uploaded_page_is_relative(source: str) -> None:
    assert relative_links(uploaded_page(source=source)) == []
    # Negative control: the page in the repository has them.
    assert len(relative_links(README)) > 20


def test_links_of_an_uploaded_page_lead_to_the_tag() -> None:
    page = uploaded_page("![saw](a/b.svg)\n\n[one](docs/x.md#here) [two](https://a.b) [three](#four)\n")
    assert page == (
        f"![saw]({SOURCE}/raw/v1.2.3/a/b.svg)\n\n[one]({SOURCE}/blob/v1.2.3/docs/x.md#here) [two](https://a.b) "
        f"[three]({SOURCE}#four)\n"
    )
    assert "gitlab.com/a/b/-/blob/v1.2.3/x.md" in uploaded_page("[x](x.md)", "https://gitlab.com/a/b/")


def test_an_uploaded_page_has_all_words_without_an_address() -> None:
    assert uploaded_page("![saw](a.svg)\n\nA [link](x.md), [another](https://a.b).\n", "") == (
        "A link, [another](https://a.b).\n"
    )


def test_the_built_description_is_that_page() -> None:
    metadata = ProjectMetadata(str(ROOT), PluginManager())
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    source = project.get("urls", {}).get("Source", "")
    assert metadata.core.readme == HOOK["with_absolute_links"](README, source, project["version"])
    assert metadata.core.readme_content_type == "text/markdown"


UNWANTED = ("reports", ".ci", ".venv", "dist", "build", "mutants", "site", ".git", ".hypothesis")


def unwanted_files(files: set[str]) -> list[str]:
    """Files that are no part of a release: committed reports, and what commands leave."""
    made = (".pyc", ".sqlite", ".log")
    return sorted(file for file in files if file.split("/")[0] in UNWANTED or file.endswith(made))


def test_an_sdist_has_sources_and_tests_and_nothing_else() -> None:
    files = {file.relative_path.replace("\\", "/") for file in SdistBuilder(str(ROOT)).recurse_included_files()}
    folders = {file.split("/")[0] for file in files}
    assert {"src", "tests", "docs", "examples", "mjcf", "pymunk_models", "README.md"} <= folders
    assert {"constraints-lowest.txt", "action.yml", "CITATION.cff"} <= folders
    assert unwanted_files(files) == []
    # Negative control.
    slips = {"reports/README.md", "src/conrod/a.pyc"}
    assert unwanted_files(files | slips) == sorted(slips)
