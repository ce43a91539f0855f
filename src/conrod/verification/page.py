"""A verification report: its contents, its differences from an earlier one, and its HTML page.

The page contains its own data, and a hash over the whole file.
"""

from __future__ import annotations

import hashlib
import json
import re
import sys
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import TypeAlias

from conrod.errors import InvalidInput
from conrod.report.folder import plain_findings, restore_findings
from conrod.report.html import page as html_page
from conrod.report.html.markdown import Place, render_html
from conrod.report.table import Table, cell_text, safe_html
from conrod.report.template import page

CRITERIA, SETTINGS, VALIDATION, OPEN, ABSENT = "criteria", "settings", "validation", "deviations", "absent"
Statements: TypeAlias = dict[str, dict[str, str]]  # statements by section and row
REPORT_MARK = "conrod-verification"
DRAWING = "machine.svg"  # name by which the template shows the machine's drawing
UNSEALED = b"0" * 64
# The only place of the hash; names from users contain no tags.
SEAL = re.compile(rb"SHA-256 of this file[^<]*<code>([0-9a-f]{64})</code>")
# Of earlier versions, which wrote the hash at two places.
EARLIER_SEAL = re.compile(rf'<meta name="{REPORT_MARK}" content="sha256:([0-9a-f]{{64}})">'.encode())
DATA_SCRIPT = re.compile(rf'<script type="application/json" id="{REPORT_MARK}-data">(.*?)</script>', re.DOTALL)


@dataclass(frozen=True)
class VerificationSection:
    """Tables and sentences under one heading; if it does not apply, a sentence says why.

    Attributes:
        full: first cell after the names of a row in all its digits, by the row's name; changes are found by these.
    """

    tables: tuple[Table, ...] = ()
    sentences: tuple[str, ...] = ()
    full: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class ChangeRecord:
    """Differences from an earlier report, a sentence each.

    Attributes:
        since: hash of the earlier report.
        made: date and time of the later one.
        changes: the differences."""

    since: str
    made: str
    changes: tuple[str, ...]


@dataclass(frozen=True)
class Verification:
    """A verification report.

    Attributes:
        subject: name of the machine or file.
        verdict: the verdict in a sentence.
        made: date and time (UTC) of the first report with these contents.
        command: command that makes the report again.
        sections: sections by their names in the template.
        deviations: open deviations, a sentence each.
        record: changes between reports, the oldest first.
        title: title that the user gave; empty for the subject's name.
    """

    subject: str
    verdict: str
    made: str
    command: str
    sections: Mapping[str, VerificationSection]
    deviations: tuple[str, ...]
    record: tuple[ChangeRecord, ...] = ()
    title: str = ""

    @property
    def heading(self) -> str:
        """First heading of the page."""
        return f"Verification report: {self.title or self.subject}"


def statement_changes(before: Verification, after: Verification) -> tuple[str, ...]:
    """List the statements that changed between two reports, and mark loosened criteria."""
    return tuple(_changes_by_row(_statements(before), _statements(after)))


def _changes_by_row(before: Statements, after: Statements) -> Iterator[str]:
    """Yield each row of each section that changed, was added or is gone, with both texts."""
    for name in dict.fromkeys([*before, *after]):
        old, new = before.get(name, {}), after.get(name, {})
        if name not in (CRITERIA, OPEN) and bool(old) != bool(new):
            yield f"{name}: {len(old)} rows -> {len(new)} rows"
            continue
        for row in dict.fromkeys([*old, *new]):
            was, now = old.get(row, ABSENT), new.get(row, ABSENT)
            if was != now:
                loosened = " (LOOSENED)" if name == CRITERIA and _is_loosened(was, now) else ""
                yield f"{name}, {row}: {was} -> {now}{loosened}"


def _is_loosened(was: str, now: str) -> bool:
    """True if a criterion, the first of its row's cells, allows more than before."""
    return was != ABSENT and (now == ABSENT or float(re.split("[ ;]", now)[0]) > float(re.split("[ ;]", was)[0]))


def _statements(of: Verification) -> Statements:
    """Return all statements of a report, by section and row.

    A row is named by its leading cells, which are the same in the next report, so that two reports can be compared.
    """
    found = {
        "report": {
            "on": of.subject,
            **({"title": of.title} if of.title else {}),
            "verdict": of.verdict,
            "command": of.command,
        },
        OPEN: dict.fromkeys(of.deviations, "open"),
    }
    for name, section in of.sections.items():
        rows = [(one, [cell_text(cell) for cell in row]) for one in section.tables for row in one.rows]
        of_engine = name == SETTINGS  # these have a table for each engine
        found[name] = {
            " ".join([*([one.title] if of_engine else []), *cells[: one.names]]): "; ".join(cells[one.names :])
            for one, cells in rows
        }
        found[name] |= {
            row: "; ".join([exact, *found[name][row].split("; ")[1:]])
            for row, exact in section.full.items()
            if row in found[name]
        }
        if name == VALIDATION:
            found[name] = {"words": "; ".join(section.sentences)}
    return found


# -- the page ---------------------------------------------------------------------------------------------------------


def sealed_page(found: Verification, drawing: str = "") -> bytes:
    """Return the report's HTML with the SHA-256 of the same file with zeros in that place.

    Args:
        found: contents of the report.
        drawing: SVG of the machine; empty for none.
    """
    measured = len(found.sections["validation"].sentences) > 1
    text = page(
        "verification", sys.modules[__name__], found=found, digest=UNSEALED.decode(), measured=measured,
        drawing=DRAWING if drawing else "",
    ).text  # fmt: skip

    def figure(name: str, alt: str) -> str | None:
        return html_page.image_html(drawing, alt) if drawing and name == DRAWING else None

    place = Place("verification", 0, figure, lambda name: None)
    html = html_page.html_document([html_page.PageSection("verification", found.heading, render_html(text, place))])
    # In a script only its end tag is markup.
    data = json.dumps(plain_findings(found), ensure_ascii=False).replace("<", "\\u003c")
    data = "".join(letter if letter == safe_html(letter) else json.dumps(letter)[1:-1] for letter in data)
    html = html.replace("</head>", f'<meta name="{REPORT_MARK}" content="2">\n</head>', 1)
    head, end = html.rsplit("</body>", 1)
    html = f'{head}<script type="application/json" id="{REPORT_MARK}-data">{data}</script>\n</body>{end}'
    unsealed = html.encode(errors="replace")
    (field,) = SEAL.finditer(unsealed)
    return _replace_hash(unsealed, field, hashlib.sha256(unsealed).hexdigest().encode())


def valid_seal(page: bytes) -> str | None:
    """Return the hash of a verification report; None if a byte of it was changed.

    Raises:
        InvalidInput: the page is no verification report.
    """
    if REPORT_MARK.encode() not in page:
        raise InvalidInput("it is no verification report of conrod")
    if earlier := EARLIER_SEAL.search(page):
        bare = page.replace(earlier[1], UNSEALED)
        known, digest = page.count(earlier[1]) == 2, earlier[1]
    else:
        fields = list(SEAL.finditer(page))
        if len(fields) != 1:
            return None
        bare, known, digest = _replace_hash(page, fields[0], UNSEALED), True, fields[0][1]
    return digest.decode() if known and hashlib.sha256(bare).hexdigest().encode() == digest else None


def _replace_hash(page: bytes, field: re.Match[bytes], digest: bytes) -> bytes:
    return page[: field.start(1)] + digest + page[field.end(1) :]


def read_verification(page: bytes) -> Verification:
    """Read the contents of an unchanged report.

    Raises:
        InvalidInput: another version of conrod wrote the report.
    """
    found = DATA_SCRIPT.search(page.decode())
    if found is None:
        raise InvalidInput("it has no data of a verification report")
    return restore_findings(Verification, json.loads(found[1]))
