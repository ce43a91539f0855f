"""A printed number with its digits, and the item of a document that it belongs to."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from functools import cached_property

from conrod.errors import InvalidInput

# Digits with a decimal point or comma, as documents of either habit print them.
DIGITS = re.compile(r"[+-]?([0-9]+)([.,][0-9]+)?")
MOST_DIGITS = 30  # with sign and mark; a double holds 17
# An exact value this close to the middle between two prints may be rounded to either.
TIE = 1e-7


@dataclass(frozen=True)
class Number:
    """Printed digits.

    Raises:
        InvalidInput: the text is no decimal number.
    """

    text: str

    def __post_init__(self) -> None:
        if len(self.text) > MOST_DIGITS or not DIGITS.fullmatch(self.text):
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
        found = DIGITS.fullmatch(self.text)
        return len(found.group(2)) - 1 if found and found.group(2) else 0

    @property
    def last(self) -> float:
        """The unit of the last printed digit."""
        return float(10.0**-self.decimals)

    def is_rounding_of(self, value: float) -> bool:
        """True if the value, rounded to these digits, is this number."""
        return bool(abs(self.value - value) <= self.last * (0.5 + TIE))

    def is_cut_of(self, value: float) -> bool:
        """True if the value, its further digits dropped, is this number."""
        kept = math.floor(abs(value) / self.last + TIE)
        return value * self.value >= 0.0 and round(abs(self.value) / self.last) == kept

    def like(self, value: float) -> str:
        """Another value with as many digits and the same mark."""
        text = f"{value:.{self.decimals}f}"
        return text.replace(".", ",") if "," in self.text else text


@dataclass(frozen=True)
class Item:
    """A printed number that a mechanism determines.

    Attributes:
        key: names the computation that determines it.
        mechanism: the scene or the worked example that it is tied to.
        The others as in `Verdict`.
    """

    document: str
    key: str
    place: str
    line: int
    quantity: str
    condition: str
    number: Number
    unit: str
    mechanism: str
