"""The four documents, judged item by item."""

from __future__ import annotations

from audits.documents import cam, module, press, saw
from audits.notes import NOTES
from conrod.errors import unknown_choice
from conrod.models.printed.verdicts import AuditedDocument, PrintedVerdict

# Document -> what judges it.
DOCUMENTS = {"000": press.verdicts, "001": module.verdicts, "002": saw.verdicts, "004": cam.verdicts}
TITLES = {
    "000": "Kinematics of a steel-plate shear press",
    "001": "Course module: kinematics and dynamics of machinery",
    "002": "Kinematic simulation of a power hacksaw by complex numbers",
    "004": "Influence of flank and base radius of a symmetric cam on its roller follower",
}
# Document -> its page in the report.
PAGES = {"000": "shear-press", "001": "course-module", "002": "power-hacksaw", "004": "arc-cam"}


def audited(document: str) -> AuditedDocument:
    """Return a document with its verdicts; raises as `audit` does."""
    verdicts = audit(document)
    return AuditedDocument(f"Document {document}", TITLES[document], verdicts, NOTES[document])


def audit(document: str) -> tuple[PrintedVerdict, ...]:
    """Return a verdict on every printed number and formula of a document.

    Raises:
        InvalidInput: there is no document of that number; names those that there are.
    """
    if document not in DOCUMENTS:
        raise unknown_choice("document", document, DOCUMENTS)
    return DOCUMENTS[document]()
