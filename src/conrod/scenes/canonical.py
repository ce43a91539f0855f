"""The canonical text of plain values: what is hashed to the key of a run, so it must never change."""

from __future__ import annotations

import json
from typing import Any

import msgspec

_PYTHON = json.JSONEncoder(sort_keys=True, allow_nan=False, separators=(",", ":"))
_FAST = msgspec.json.Encoder(order="deterministic")
# Between these both write a float in the same digits; beyond them Python has an exponent, msgspec another or none.
LEAST, MOST = 1e-4, 1e15
_SAME = frozenset({str, int, bool, type(None)})


def canonical(values: Any) -> str:
    """JSON of plain values as Python's own encoder writes it, keys sorted, in half of the time.

    Raises:
        ValueError: a float is not finite.
        TypeError: a value is not plain.
    """
    text = _FAST.encode(_as_python_writes(values))
    if not text.isascii() or b"\x7f" in text:
        return _PYTHON.encode(values)
    return text.decode()


def _as_python_writes(value: Any) -> Any:
    """The value itself, unless it holds a float that msgspec writes in another way."""
    kind = type(value)
    if kind is dict:
        other = {}
        for name, one in value.items():
            if (kind := type(one)) is float:
                if one and not LEAST <= one < MOST:
                    other[name] = _as_python_writes(one)
            elif kind not in _SAME and (written := _as_python_writes(one)) is not one:
                other[name] = written
        return value | other if other else value
    if isinstance(value, list | tuple):
        return [_as_python_writes(one) for one in value]
    if isinstance(value, float) and value and not LEAST <= abs(value) < MOST:
        return msgspec.Raw(_PYTHON.encode(value).encode())
    return value
