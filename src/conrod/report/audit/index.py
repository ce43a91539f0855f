"""The first page of an audit's report."""

from __future__ import annotations

from collections.abc import Sequence

from conrod.own.printed.audited import Audited
from conrod.own.printed.judging import Kind
from conrod.report.audit.corrections import corrections
from conrod.report.audit.words import MEANINGS, lines_text, plain, printed_text, right_text
from conrod.report.tables import paragraphs, table

PURPOSE = (
    "Every printed number that a mechanism determines, and every formula for one, held against the exact motion. "
    "The print is what is audited, never the ruler."
)
# Corrections of each document that the index names.
FIRST = 3


def index(audits: Sequence[Audited], command: str) -> str:
    """The index in Markdown; `command` reproduces the report."""
    return (
        paragraphs(
            "# Published figures against the exact motion",
            PURPOSE,
            counts_table(audits),
            "## First to correct",
            "\n".join(line for audited in audits for line in _first(audited)) or "Nothing is wrong.",
            "## Verdicts",
            "\n".join(f"- **{kind.value}**: {meaning}" for kind, meaning in MEANINGS.items()),
            "A verdict other than agreement comes with the computation that shows it; the kindest one that a "
            "computation supports is given.",
            f"Reproduced by `{command}`. [results.json](results.json) holds every item.",
        )
        + "\n"
    )


def counts_table(audits: Sequence[Audited]) -> str:
    """How many items of each document have which verdict."""
    rows = [
        [f"[{plain(a.title)}]({a.name}.md)", *(str(n) for n in a.counts.values()), str(len(a.verdicts))] for a in audits
    ]
    return table(["document", *(kind.value for kind in Kind), "items"], rows)


def _first(audited: Audited) -> list[str]:
    return [
        f"- [{audited.name}]({audited.name}.md), line {lines_text(v.line for v in group)}, {plain(group[0].quantity)}: "
        f"{printed_text(group[0])} should be {right_text(group[0])} ({group[0].kind.value})"
        for group in corrections(audited.verdicts)[:FIRST]
    ]
