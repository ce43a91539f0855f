"""One document, judged: what a report on it is made from."""

from __future__ import annotations

from dataclasses import dataclass

from conrod.own.printed.judging import Verdict


@dataclass(frozen=True)
class Audited:
    """The verdicts on one document or table.

    Attributes:
        name: of its page, a plain word.
        document: number of one that ships, or the name of a user's file.
        title: of the document.
        verdicts: in the order of the items.
        notes: what the verdicts cannot be sure of, a sentence or two each.
        shipped: whether it is one of those that ship.
    """

    name: str
    document: str
    title: str
    verdicts: tuple[Verdict, ...]
    notes: tuple[str, ...] = ()
    shipped: bool = False
