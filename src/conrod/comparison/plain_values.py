"""Conversion of results to plain values, which JSON and a ledger can hold, and back.

A class whose saved value is not its fields has a method `as_saved` that returns it.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping, Sequence, Set
from dataclasses import fields, is_dataclass
from enum import Enum
from functools import partial
from types import MappingProxyType
from typing import Any, TypeVar, get_origin

import msgspec
import numpy as np

from conrod.errors import InvalidInput

Value = TypeVar("Value")


def plain_values(value: Any, digits: int | None = None) -> Any:
    """Convert a dataclass, or any nesting of dataclasses, mappings, sequences and arrays, to plain values.

    A dataclass becomes a dictionary of its fields, in their order, and an array nested lists.

    Args:
        digits: significant digits of arrays, which are there to be drawn; a number that is not finite is then a text,
            as JSON has none. By default numbers keep all digits.

    Raises:
        TypeError: a value of another kind.
    """
    found: Any
    match value:
        case None | bool() | int() | str():
            found = value
        case float():
            found = float(value) if digits is None or math.isfinite(value) else str(float(value))
        case Enum():
            found = value.value
        case np.generic():
            found = plain_values(value.item(), digits)
        case np.ndarray():
            found = value.tolist() if digits is None else _round_digits(value.tolist(), digits)
        case Mapping():
            found = {str(key): plain_values(part, digits) for key, part in value.items()}
        case Sequence() | Set():
            found = [plain_values(part, digits) for part in value]
        case _ if hasattr(value, "as_saved"):
            found = value.as_saved()
        case _ if is_dataclass(value):
            found = {field.name: plain_values(getattr(value, field.name), digits) for field in fields(value)}
        case _:
            raise TypeError(f"a value of type {type(value).__name__} is not plain")
    return found


def restore(kind: type[Value], values: Any, others: Mapping[Any, Callable[[Any], Any]] = MappingProxyType({})) -> Value:
    """Convert plain values back to a type; the inverse of `plain_values`.

    Args:
        kind: a dataclass whose fields' types can be looked up where it is defined, or a type such as `tuple[Run, ...]`.
        values: as `plain_values` or `json.loads` gives them; keys that the type does not have are left out.
        others: constructors by class, for classes with `as_saved`; if given, infinities and NaN may be texts.

    Raises:
        InvalidInput: a value does not fit the type; names that value.
    """
    try:
        return msgspec.convert(values, kind, dec_hook=partial(_decode, others), strict=not others)
    except (msgspec.ValidationError, KeyError, TypeError) as error:
        raise InvalidInput(f"saved values do not fit {getattr(kind, '__name__', kind)}: {error}") from None


def json_document(values: Any) -> str:
    """Text of a JSON file from plain values; null for numbers that are not finite, which JSON lacks."""
    return json.dumps(msgspec.json.decode(msgspec.json.encode(values)), indent=1) + "\n"


def _round_digits(values: Any, digits: int) -> Any:
    """Round the numbers of nested lists to significant digits."""
    if isinstance(values, list):
        return [_round_digits(part, digits) for part in values]
    return plain_values(float(f"{values:.{digits - 1}e}") if isinstance(values, float) else values, digits)


def _decode(others: Mapping[Any, Callable[[Any], Any]], kind: Any, value: Any) -> Any:
    """Decode arrays, and classes with `as_saved`, for msgspec."""
    if (get_origin(kind) or kind) is np.ndarray:
        return np.asarray(value, dtype=float)
    if kind in others:
        return others[kind](value)
    raise NotImplementedError(f"{kind} cannot be restored")
