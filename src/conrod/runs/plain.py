"""Results as plain values, which JSON and a ledger can hold, and back.

A class that is to be another value than its fields has `as_saved`, which returns that.
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


def plain(value: Any, digits: int | None = None) -> Any:
    """Plain values of a dataclass, or of anything that is made of dataclasses, mappings, sequences and arrays.

    A dataclass becomes a dictionary of its fields, in their order, and an array nested lists.

    Args:
        digits: significant, of arrays, which are there to be drawn; a number that is not finite is then a text, as JSON
            has none. Without, numbers keep all digits.

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
            found = plain(value.item(), digits)
        case np.ndarray():
            found = value.tolist() if digits is None else _rounded(value.tolist(), digits)
        case Mapping():
            found = {str(key): plain(part, digits) for key, part in value.items()}
        case Sequence() | Set():
            found = [plain(part, digits) for part in value]
        case _ if hasattr(value, "as_saved"):
            found = value.as_saved()
        case _ if is_dataclass(value):
            found = {field.name: plain(getattr(value, field.name), digits) for field in fields(value)}
        case _:
            raise TypeError(f"a value of type {type(value).__name__} is not plain")
    return found


def restore(kind: type[Value], values: Any, others: Mapping[Any, Callable[[Any], Any]] = MappingProxyType({})) -> Value:
    """The inverse of `plain`.

    Args:
        kind: a dataclass whose fields' types can be looked up where it is defined, or a type such as `tuple[Run, ...]`.
        values: as `plain` or `json.loads` gives them; keys that the type does not have are left out.
        others: what makes a value of a class that has `as_saved`; where there are any, a text may be a number that is
            not finite.

    Raises:
        InvalidInput: they do not fit the type; names the one that does not.
    """
    try:
        return msgspec.convert(values, kind, dec_hook=partial(_decoded, others), strict=not others)
    except (msgspec.ValidationError, KeyError, TypeError) as error:
        raise InvalidInput(f"saved values do not fit {getattr(kind, '__name__', kind)}: {error}") from None


def json_document(values: Any) -> str:
    """Plain values as the text of a JSON file; null for a number that is not finite, which JSON does not have."""
    return json.dumps(msgspec.json.decode(msgspec.json.encode(values)), indent=1) + "\n"


def _rounded(values: Any, digits: int) -> Any:
    if isinstance(values, list):
        return [_rounded(part, digits) for part in values]
    return plain(float(f"{values:.{digits - 1}e}") if isinstance(values, float) else values, digits)


def _decoded(others: Mapping[Any, Callable[[Any], Any]], kind: Any, value: Any) -> Any:
    if (get_origin(kind) or kind) is np.ndarray:
        return np.asarray(value, dtype=float)
    if kind in others:
        return others[kind](value)
    raise NotImplementedError(f"{kind} cannot be restored")
