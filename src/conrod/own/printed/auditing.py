"""The four documents that ship, and files of printed values that a user brings, judged item by item."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from importlib import import_module

from conrod.audits.notes import NOTES
from conrod.errors import unknown_choice
from conrod.own.printed.audited import Audited
from conrod.own.printed.judging import Kind, Verdict

# Document -> the module that judges it, loaded when it is asked for.
DOCUMENTS = {
    "000": "conrod.audits.documents.press",
    "001": "conrod.audits.documents.module",
    "002": "conrod.audits.documents.saw",
    "004": "conrod.audits.documents.cam",
}
TITLES = {
    "000": "Kinematics of a steel-plate shear press",
    "001": "Course module: kinematics and dynamics of machinery",
    "002": "Kinematic simulation of a power hacksaw by complex numbers",
    "004": "Influence of flank and base radius of a symmetric cam on its roller follower",
}
# Document -> its page in a report.
PAGES = {"000": "shear-press", "001": "course-module", "002": "power-hacksaw", "004": "arc-cam"}


def audited(document: str) -> Audited:
    """A document that ships, judged; raises as `audit` does."""
    verdicts = audit(document)
    return Audited(PAGES[document], document, TITLES[document], verdicts, NOTES[document], shipped=True)


def audit(document: str) -> tuple[Verdict, ...]:
    """A verdict on every printed number and formula of a document that ships.

    Raises:
        InvalidInput: no document of that number ships; names those that do.
    """
    if document not in DOCUMENTS:
        raise unknown_choice("document", document, DOCUMENTS)
    verdicts: Callable[[], tuple[Verdict, ...]] = import_module(DOCUMENTS[document]).verdicts
    return verdicts()


def count(verdicts: tuple[Verdict, ...]) -> Mapping[Kind, int]:
    """How many there are of each kind, in the order of the kinds."""
    return {kind: sum(verdict.kind is kind for verdict in verdicts) for kind in Kind}
