"""An audit's results as plain values, rounded to what comes out the same on every machine."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Any

from conrod.own.printed.audited import Audited
from conrod.own.printed.judging import Verdict
from conrod.own.printed.printed import Number
from conrod.report.audit.words import is_formula

SCHEMA = 1
# Digits of an exact value beyond the printed ones; of a difference; significant ones of how far a print is off.
MORE, DIFFERENCE, OFF = 6, 4, 4


def document(audits: Sequence[Audited], command: str) -> dict[str, Any]:
    """All items of all documents."""
    return {
        "schema": SCHEMA,
        "command": command,
        "audit": {
            audited.name: {
                "document": audited.document,
                "title": audited.title,
                "counts": {kind.value: number for kind, number in audited.counts.items()},
                "notes": list(audited.notes),
                "items": [item(verdict) for verdict in audited.verdicts],
            }
            for audited in audits
        },
    }


def item(verdict: Verdict) -> dict[str, Any]:
    """One item."""
    exact = None
    if verdict.exact is not None and not is_formula(verdict):
        exact = round(verdict.exact, Number(verdict.printed).decimals + MORE) + 0.0
    return {
        "place": verdict.place,
        "line": verdict.line,
        "quantity": verdict.quantity,
        "condition": verdict.condition,
        "unit": verdict.unit,
        "printed": verdict.printed,
        "exact": exact,
        "difference": None if verdict.difference is None else round(verdict.difference, DIFFERENCE) + 0.0,
        "off": None if verdict.off is None else float(f"{verdict.off:.{OFF}g}"),
        "verdict": verdict.kind.value,
        "reason": verdict.reason,
        "cause": verdict.cause,
        "should_be": verdict.should_be,
    }


def text(results: dict[str, Any]) -> str:
    """The results as JSON."""
    return json.dumps(results, indent=1, allow_nan=False, ensure_ascii=False) + "\n"
