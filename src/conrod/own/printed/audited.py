"""One document, judged: what a report on it is made from."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from conrod.own.printed.judging import Kind, Verdict


@dataclass(frozen=True)
class Audited:
    """Verdicts on one document or table.

    Attributes:
        document: name of the user's file, or "Document" and the number of one of the four.
        title: of the document.
        verdicts: in the order of the items.
        notes: doubts about the verdicts, a sentence or two each.
    """

    document: str
    title: str
    verdicts: tuple[Verdict, ...]
    notes: tuple[str, ...] = ()

    @property
    def counts(self) -> Mapping[Kind, int]:
        """Number of verdicts of each kind, in the order of the kinds."""
        return {kind: sum(verdict.kind is kind for verdict in self.verdicts) for kind in Kind}
