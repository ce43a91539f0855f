"""Contents of a verification report, saved in the page, and what differs between two of them."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import TypeAlias

from conrod.report.table import Table, text_of

CRITERIA, SETTINGS, VALIDATION, OPEN, ABSENT = "criteria", "settings", "validation", "deviations", "absent"
Statements: TypeAlias = dict[str, dict[str, str]]  # by section and row


@dataclass(frozen=True)
class Section:
    """Tables and sentences under one heading; where it does not apply, a sentence says why."""

    tables: tuple[Table, ...] = ()
    sentences: tuple[str, ...] = ()


@dataclass(frozen=True)
class Change:
    """What differs from the report that another took the place of, named by its hash, a sentence each."""

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
    sections: Mapping[str, Section]
    deviations: tuple[str, ...]
    record: tuple[Change, ...] = ()


def changes(before: Verification, after: Verification) -> tuple[str, ...]:
    """Each statement that is another now, with what it was; criteria that were loosened are called so."""
    return tuple(_changes(_statements(before), _statements(after)))


def _changes(before: Statements, after: Statements) -> Iterator[str]:
    for name in dict.fromkeys([*before, *after]):
        old, new = before.get(name, {}), after.get(name, {})
        if name not in (CRITERIA, OPEN) and bool(old) != bool(new):
            yield f"{name}: {len(old)} rows -> {len(new)} rows"
            continue
        for row in dict.fromkeys([*old, *new]):
            was, now = old.get(row, ABSENT), new.get(row, ABSENT)
            if was != now:
                loosened = " (LOOSENED)" if name == CRITERIA and _looser(was, now) else ""
                yield f"{name}, {row}: {was} -> {now}{loosened}"


def _looser(was: str, now: str) -> bool:
    """Whether a criterion, the first of its row's cells, allows more."""
    return was != ABSENT and (now == ABSENT or float(re.split("[ ;]", now)[0]) > float(re.split("[ ;]", was)[0]))


def _statements(of: Verification) -> Statements:
    """All that a reader may rely on, row by row, by names that stay from report to report."""
    found = {
        "report": {"on": of.subject, "verdict": of.verdict, "command": of.command},
        OPEN: dict.fromkeys(of.deviations, "open"),
    }
    for name, section in of.sections.items():
        rows = [(one, [text_of(cell) for cell in row]) for one in section.tables for row in one.rows]
        of_engine = name == SETTINGS  # which have a table each
        found[name] = {
            " ".join([*([one.title] if of_engine else []), *cells[: one.names]]): "; ".join(cells[one.names :])
            for one, cells in rows
        }
        if name == VALIDATION:
            found[name] = {"words": "; ".join(section.sentences)}
    return found
