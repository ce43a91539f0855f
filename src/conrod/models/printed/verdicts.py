"""Printed numbers, and verdicts on them."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum
from functools import cached_property

from conrod.errors import InvalidInput

# Digits with a decimal point or comma, as documents of either habit print them.
NUMBER_PATTERN = re.compile(r"[+-]?([0-9]+)([.,][0-9]+)?")
MAX_DIGITS = 30  # with sign and mark; a double holds 17
# An exact value this close to the middle between two prints may be rounded to either.
TIE_WIDTH = 1e-7


@dataclass(frozen=True)
class PrintedNumber:
    """A decimal number as its digits are printed.

    Raises:
        InvalidInput: the text is no decimal number.
    """

    text: str

    def __post_init__(self) -> None:
        if len(self.text) > MAX_DIGITS or not NUMBER_PATTERN.fullmatch(self.text):
            raise InvalidInput(
                f"printed value {self.text[:40]!r} is not a decimal number: give its digits, like 14.66 or 14,66"
            )

    @cached_property
    def value(self) -> float:
        """Value of the digits."""
        return float(self.text.replace(",", "."))

    @cached_property
    def decimals(self) -> int:
        """Digits after the point."""
        found = NUMBER_PATTERN.fullmatch(self.text)
        return len(found.group(2)) - 1 if found and found.group(2) else 0

    @property
    def last(self) -> float:
        """The unit of the last printed digit."""
        return float(10.0**-self.decimals)

    def is_rounding_of(self, value: float) -> bool:
        """True if the value, rounded to these digits, is this number."""
        return bool(abs(self.value - value) <= self.last * (0.5 + TIE_WIDTH))

    def is_truncation_of(self, value: float) -> bool:
        """True if the value, its further digits cut off, is this number."""
        kept = math.floor(abs(value) / self.last + TIE_WIDTH)
        return value * self.value >= 0.0 and round(abs(self.value) / self.last) == kept

    def format_like(self, value: float) -> str:
        """Format another value with as many decimals and the same decimal mark."""
        text = f"{value:.{self.decimals}f}"
        return text.replace(".", ",") if "," in self.text else text


class VerdictKind(StrEnum):
    """Possible verdicts on a printed value; the text is shown to readers."""

    AGREES = "agrees"
    AFTER_ROUNDING = "agrees after rounding"
    EXPLAINED = "explained"
    MISPRINT = "misprint"
    WRONG_STEP = "wrong step"
    NOT_REPRODUCIBLE = "not reproducible as printed"


ACCEPTED_KINDS = (VerdictKind.AGREES, VerdictKind.AFTER_ROUNDING)


@dataclass(frozen=True)
class PrintedVerdict:
    """The verdict on one printed value or formula.

    Attributes:
        document, place, line: where the value is printed; the line is that of the document's text file.
        quantity, condition, unit: the printed quantity, the angle or time it holds at, and the printed unit.
        printed: the digits as they stand there, or the formula.
        exact: the value that the mechanism determines, in the printed unit; None where the print determines none.
        difference: printed - exact, in units of the last printed digit.
        kind: the verdict.
        reason: the computation that shows it, in one sentence.
        should_be: value to print in its place; None if the print is right.
        off: error of the print, as a share of the right value or of its peak; None if there is none.
        cause: slip that reproduces a wrong print, in words; several items may share it.
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
    kind: VerdictKind
    reason: str
    should_be: str | None = None
    off: float | None = None
    cause: str | None = None


@dataclass(frozen=True)
class AuditedDocument:
    """Verdicts on one document or table.

    Attributes:
        document: name of the user's file, or "Document" and the number of one of the four.
        title: title of the document.
        verdicts: verdicts in the order of the items.
        notes: doubts about the verdicts, a sentence or two each.
    """

    document: str
    title: str
    verdicts: tuple[PrintedVerdict, ...]
    notes: tuple[str, ...] = ()

    @property
    def counts(self) -> Mapping[VerdictKind, int]:
        """Number of verdicts of each kind, in the order of the kinds."""
        return {kind: sum(verdict.kind is kind for verdict in self.verdicts) for kind in VerdictKind}
