"""Results as plain values, which JSON and a ledger can hold, and back."""

from __future__ import annotations

import json
from typing import Any, TypeVar, get_origin

import msgspec
import numpy as np

from conrod.errors import InvalidInput

Value = TypeVar("Value")


def plain(value: Any) -> Any:
    """Plain values of a dataclass, or of anything that is made of dataclasses, mappings, sequences and arrays.

    A dataclass becomes a dictionary of its fields, in their order, and an array nested lists. Numbers keep all digits.

    Raises:
        TypeError: a value of another kind.
    """
    return msgspec.to_builtins(value, enc_hook=_encoded, str_keys=True)


def json_document(values: Any) -> str:
    """Plain values as the text of a JSON file; null for a number that is not finite, which JSON does not have."""
    return json.dumps(msgspec.json.decode(msgspec.json.encode(values)), indent=1) + "\n"


def restore(kind: type[Value], values: Any) -> Value:
    """The inverse of `plain`.

    Args:
        kind: a dataclass whose fields' types can be looked up where it is defined, or a type such as `tuple[Run, ...]`.
        values: as `plain` or `json.loads` gives them; keys that the type does not have are left out.

    Raises:
        InvalidInput: they do not fit the type; names the one that does not.
    """
    try:
        return msgspec.convert(values, kind, dec_hook=_decoded)
    except msgspec.ValidationError as error:
        raise InvalidInput(f"no {getattr(kind, '__name__', kind)} can be made of these values: {error}") from None


def _encoded(value: Any) -> Any:
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist()
    raise TypeError(f"a value of type {type(value).__name__} is not plain")


def _decoded(kind: Any, value: Any) -> Any:
    if (get_origin(kind) or kind) is np.ndarray:
        return np.asarray(value, dtype=float)
    raise NotImplementedError(f"{kind} cannot be restored")
