"""Checks that a number is one, and within its range."""

from __future__ import annotations

import math

from conrod.errors import InvalidInput


def check_number(name: str, value: object, lowest: float, highest: float, unit: str = "") -> None:
    """Refuse what is not a finite number from `lowest` to `highest`.

    Raises:
        InvalidInput: names the value and the range.
    """
    suffix = f" {unit}" if unit else ""
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
        raise InvalidInput(f"{name} = {value!r} is not a finite number")
    if not lowest <= value <= highest:
        raise InvalidInput(f"{name} = {value:g}{suffix} is out of range: {lowest:g} <= {name} <= {highest:g}{suffix}")


def check_count(name: str, value: object, lowest: int, highest: int) -> None:
    """Refuse what is not a whole number from `lowest` to `highest`.

    Raises:
        InvalidInput: names the value and the range.
    """
    if isinstance(value, bool) or not isinstance(value, int):
        raise InvalidInput(f"{name} = {value!r} is not a whole number")
    if not lowest <= value <= highest:
        raise InvalidInput(f"{name} = {value} is out of range: {lowest} <= {name} <= {highest}")
