"""A verification report: its contents, what differs between two of them, and its page.

The page is one HTML file with its own data in it, sealed by a hash over all of it.
"""

from __future__ import annotations

import hashlib
import json
import re
import sys
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import TypeAlias

from conrod.errors import InvalidInput
from conrod.report.folder import plain_findings, restore_findings
from conrod.report.html import page as html_page
from conrod.report.html.markdown import Place, render_html
from conrod.report.table import Table, cell_text, safe_html
from conrod.report.template import page

CRITERIA, SETTINGS, VALIDATION, OPEN, ABSENT = "criteria", "settings", "validation", "deviations", "absent"
Statements: TypeAlias = dict[str, dict[str, str]]  # by section and row
REPORT_MARK = "conrod-verification"
UNSEALED = b"0" * 64
# The one place where the hash stands; names of users have no tag in them.
SEAL = re.compile(rb"SHA-256 of this file[^<]*<code>([0-9a-f]{64})</code>")
# Of earlier versions, whose hash stood at two places.
EARLIER_SEAL = re.compile(rf'<meta name="{REPORT_MARK}" content="sha256:([0-9a-f]{{64}})">'.encode())
DATA_SCRIPT = re.compile(rf'<script type="application/json" id="{REPORT_MARK}-data">(.*?)</script>', re.DOTALL)


@dataclass(frozen=True)
class VerificationSection:
    """Tables and sentences under one heading; where it does not apply, a sentence says why."""

    tables: tuple[Table, ...] = ()
    sentences: tuple[str, ...] = ()


@dataclass(frozen=True)
class ChangeRecord:
    """Differences from the report that this one replaces, named by its hash, a sentence each."""

    since: str
    made: str
    changes: tuple[str, ...]


@dataclass(frozen=True)
class Verification:
    """A verification report.

    Attributes:
        subject: name of the machine or file.
        made: date and time (UTC) at which it was first found so.
        sections: by the names that the template has for them.
        deviations: what is open, a sentence each.
        record: the oldest first.
    """

    subject: str
    verdict: str
    made: str
    command: str
    sections: Mapping[str, VerificationSection]
    deviations: tuple[str, ...]
    record: tuple[ChangeRecord, ...] = ()


def statement_changes(before: Verification, after: Verification) -> tuple[str, ...]:
    """Each statement that is another now, with what it was; criteria that were loosened are called so."""
    return tuple(_changes_by_row(_statements(before), _statements(after)))


def _changes_by_row(before: Statements, after: Statements) -> Iterator[str]:
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
    """True if a criterion, the first of its row's cells, allows more."""
    return was != ABSENT and (now == ABSENT or float(re.split("[ ;]", now)[0]) > float(re.split("[ ;]", was)[0]))


def _statements(of: Verification) -> Statements:
    """All that a reader may rely on, row by row, by names that stay from report to report."""
    found = {
        "report": {"on": of.subject, "verdict": of.verdict, "command": of.command},
        OPEN: dict.fromkeys(of.deviations, "open"),
    }
    for name, section in of.sections.items():
        rows = [(one, [cell_text(cell) for cell in row]) for one in section.tables for row in one.rows]
        of_engine = name == SETTINGS  # which have a table each
        found[name] = {
            " ".join([*([one.title] if of_engine else []), *cells[: one.names]]): "; ".join(cells[one.names :])
            for one, cells in rows
        }
        if name == VALIDATION:
            found[name] = {"words": "; ".join(section.sentences)}
    return found


# -- the page ---------------------------------------------------------------------------------------------------------


def sealed_page(found: Verification) -> bytes:
    """The report as a file, in which stands, at one place, the SHA-256 of the file with zeros at that place."""
    measured = len(found.sections["validation"].sentences) > 1
    text = page(
        "verification", sys.modules[__name__], found=found, digest=UNSEALED.decode(), measured=measured
    ).text  # fmt: skip
    place = Place("verification", 0, lambda name, alt: None, lambda name: None)
    html = html_page.html_document(
        [html_page.PageSection("verification", f"Verification report: {found.subject}", render_html(text, place))]
    )
    # In a script nothing but its end is markup.
    data = json.dumps(plain_findings(found), ensure_ascii=False).replace("<", "\\u003c")
    data = "".join(letter if letter == safe_html(letter) else json.dumps(letter)[1:-1] for letter in data)
    html = html.replace("</head>", f'<meta name="{REPORT_MARK}" content="2">\n</head>', 1)
    head, end = html.rsplit("</body>", 1)
    html = f'{head}<script type="application/json" id="{REPORT_MARK}-data">{data}</script>\n</body>{end}'
    unsealed = html.encode(errors="replace")
    (field,) = SEAL.finditer(unsealed)
    return _replace_hash(unsealed, field, hashlib.sha256(unsealed).hexdigest().encode())


def valid_seal(page: bytes) -> str | None:
    """The hash that a page is sealed by; None where it is not as it was written, to the last byte.

    Raises:
        InvalidInput: it is no verification report.
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
    """The contents of an unchanged report.

    Raises:
        InvalidInput: it is of another version of conrod.
    """
    found = DATA_SCRIPT.search(page.decode())
    if found is None:
        raise InvalidInput("it has no data of a verification report")
    return restore_findings(Verification, json.loads(found[1]))
