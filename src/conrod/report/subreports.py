"""Reports in folders directly below another report's: what its first page and its parts' pages link."""

from __future__ import annotations

import html
import re
from collections.abc import Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any
from urllib.parse import quote

from conrod.errors import InvalidInput
from conrod.execution.files import is_folder
from conrod.report.folder import REPORT_FILE_NAME, SUBFOLDERS, json_text, read_document
from conrod.report.kind import KINDS, kind_named

FIRST_PAGE = "README.md"
MARK = frozenset({"kind", "schema", "conrod"})  # keys by which a JSON file says that its folder is a report
HEADING = re.compile(r"^# (.+)$", re.MULTILINE)
STATED = re.compile(r"^(?:- )?\*\*([^*]+)\*\*", re.MULTILINE)  # a finding: a paragraph or point that begins in bold
LINK = re.compile(r"\[([^\]]*)\]\([^)]*\)")


@dataclass(frozen=True)
class SubReport:
    """A report in a folder below another report's.

    Attributes:
        name: name of its folder.
        page: path of its first page from the folder above.
        title: heading of that page.
        finding: its finding in a line, as Markdown; empty if it states none.
        parts: pages of its parts by name, as paths from the folder above.
    """

    name: str
    page: str
    title: str
    finding: str
    parts: Mapping[str, str]

    @property
    def line(self) -> str:
        """A line on it, with a link, as Markdown."""
        end = "" if self.title.endswith("?") else "."
        return f"[{self.name}]({quote(self.page)}): {self.title}{end} {self.finding}".rstrip()

    def link_to(self, part: str) -> str:
        """Return a link to the page of a part, as Markdown."""
        return f"[{self.name}: {self.title}]({quote(self.parts[part])})"


def subreports(folder: Path) -> list[SubReport]:
    """Return the reports in the folders directly below a folder, by name; damaged ones are left out."""
    if not is_folder(folder):
        return []
    below = sorted(one for one in folder.iterdir() if one.name not in SUBFOLDERS and is_folder(one))
    return [found for one in below for found in _reports_of(one)]


def _reports_of(folder: Path) -> Iterator[SubReport]:
    """Yield the reports in a folder, each with a first page of its own."""
    documents = [found for file in sorted(folder.glob("*.json")) if (found := _document(file)) is not None]
    seen = set[str]()
    for document in documents:
        kind = None
        if document["kind"] in KINDS:
            with suppress(InvalidInput):  # of conrod's repository, which is not installed
                kind = kind_named(document["kind"])
        first = FIRST_PAGE if (folder / FIRST_PAGE).is_file() else kind.index_file if kind else FIRST_PAGE
        try:
            text = (folder / first).read_text(encoding="utf-8")
        except (OSError, ValueError):
            continue
        if first in seen:
            continue
        states = kind.headline if kind and kind.index_file == first else None
        try:
            pages = {name: str(entry["page"]) for name, entry in document.get("parts", {}).items()}
            finding = states(document["parts"]) if states else _stated_finding(text)
        except (KeyError, TypeError, ValueError, AttributeError):  # summaries of another version, or changed ones
            continue
        parts = {name: f"{folder.name}/{page}" for name, page in pages.items() if REPORT_FILE_NAME.fullmatch(page)}
        title = HEADING.search(text)
        seen.add(first)
        yield SubReport(folder.name, f"{folder.name}/{first}", title[1] if title else folder.name, finding, parts)


def _document(file: Path) -> dict[str, Any] | None:
    """Return the JSON by which a folder is a report, if the file is that."""
    try:
        found = read_document(file)
    except (InvalidInput, OSError, ValueError):
        return None
    return found if isinstance(found, dict) and found.keys() >= MARK else None


def _stated_finding(page: str) -> str:
    """Return the first bold beginning of a paragraph or point of a page, without links."""
    found = STATED.search(page)
    return html.unescape(LINK.sub(r"\1", found[1])).rstrip(".") + "." if found else ""


def report_mark(kind: str) -> str:
    """Return the text of a results.json that marks a folder as a report whose pages others write."""
    return json_text({"kind": kind, "schema": 1, "conrod": version("conrod")})
