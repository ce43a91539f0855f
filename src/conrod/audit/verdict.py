"""What is to be said of one printed number or formula."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum


class Kind(StrEnum):
    """The closed list of verdicts; the value is what a reader sees."""

    AGREES = "agrees"
    AFTER_ROUNDING = "agrees after rounding"
    EXPLAINED = "explained"
    MISPRINT = "misprint"
    WRONG_STEP = "wrong step"
    NOT_REPRODUCIBLE = "not reproducible as printed"


@dataclass(frozen=True)
class Verdict:
    """One printed item, judged.

    Attributes:
        document, place, line: where it stands; the line counts in the document's text file.
        quantity, condition, unit: what it is, when, and in what the print gives it.
        printed: the digits as they stand there, or the formula.
        exact: the value that the mechanism determines, in the printed unit; None where the print determines none.
        difference: printed - exact, in units of the last printed digit.
        kind: the verdict.
        reason: the computation that shows it, in one sentence.
        should_be: what is to be printed in its place; None where the print may stand.
        off: how far the print is off, as a share of the right value or of its peak; None where there is none.
        cause: what reproduces the print where that is not the exact motion, in words; items share it.
    """

    document: str
    place: str
    line: int
    quantity: str
    condition: str
    unit: str
    printed: str
    exact: float | None
    difference: float | None
    kind: Kind
    reason: str
    should_be: str | None = None
    off: float | None = None
    cause: str | None = None
