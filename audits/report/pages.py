"""The kind of report on the four documents: that on printed values, with formulas and what else is to be said."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from audits.report import corrections, sections
from conrod.models.printed import report as printed_values
from conrod.models.printed.verdicts import AuditedDocument, PrintedNumber, PrintedVerdict

# Digits of an exact value beyond the printed ones, and of a difference, that are saved; significant ones of a share.
SAVED, DIFFERENCE, OFF = 6, 4, 4


def section(page: str) -> list[sections.Block]:
    """What is said of a document beyond its items."""
    made = {
        "course-module": sections.module_section,
        "power-hacksaw": sections.saw_section,
        "arc-cam": sections.cam_section,
    }.get(page)
    return made() if made else []


def notes(audited: AuditedDocument) -> list[str]:
    """What is uncertain."""
    return [printed_values.escape_marks(note) for note in audited.notes]


def numbers(audited: AuditedDocument) -> list[PrintedVerdict]:
    """The items that are no formulas."""
    return [verdict for verdict in audited.verdicts if not corrections.is_formula(verdict)]


def _summary(audited: AuditedDocument) -> dict[str, Any]:
    return {
        **printed_values.PRINTED_VALUES_REPORT.summary(audited),
        "corrections": len(corrections.corrections(audited.verdicts)),
    }


def _kept(audited: AuditedDocument) -> AuditedDocument:
    """Numbers rounded to what comes out the same on every machine."""
    return replace(audited, verdicts=tuple(map(_rounded, audited.verdicts)))


def _rounded(verdict: PrintedVerdict) -> PrintedVerdict:
    exact, difference, off = verdict.exact, verdict.difference, verdict.off
    if exact is not None:
        exact = (
            None
            if corrections.is_formula(verdict)
            else round(exact, PrintedNumber(verdict.printed).decimals + SAVED) + 0.0
        )
    return replace(
        verdict,
        exact=exact,
        difference=None if difference is None else round(difference, DIFFERENCE) + 0.0,
        off=None if off is None else float(f"{off:.{OFF}g}"),
    )


def headline(entries: Mapping[str, Mapping[str, Any]]) -> str:
    """Say how many printed items have which verdict."""
    counts = Counter[str]()
    for entry in entries.values():
        counts.update(entry["summary"]["counts"])
    found = ", ".join(f"{verdict} {count}" for verdict, count in counts.items() if count)
    return f"{counts.total()} printed items: {found}."


DOCUMENTS_REPORT = replace(
    printed_values.PRINTED_VALUES_REPORT, name="documents", summary=_summary, prepare_to_save=_kept
)
