"""The text that keys are made from is that of Python's own encoder, whatever stands in it."""

from __future__ import annotations

import json
import math
import random
import struct

import pytest

from conrod.scenes.canonical import canonical


def by_python(values: object) -> str:
    return json.dumps(values, sort_keys=True, allow_nan=False, separators=(",", ":"))


@pytest.mark.parametrize(
    "value",
    [
        {"b": 1, "a": [1, (2, 3.0, {"c": 1e-7})]},
        {"b": {"d": 1e-7, "c": {"e": 1e16}}, "a": {"c": 1.0}},
        {"ö": 1, "a": 1e-7},
        {"a": 'é\n\x7f"\\/<\x01', "B": None, "_": True, "a.b": {}},
        *({"a": chr(code)} for code in (*range(128), 0xE9, 0x1F600)),
        {"a": -0.0, "b": 0.0, "c": 1e15, "d": 1e-4, "e": 2**63 - 1, "f": 5e-324, "g": -1e-5, "h": -2.5},
        [],
    ],
)
def test_plain_values_are_written_as_python_writes_them(value: object) -> None:
    assert canonical(value) == by_python(value)


def test_floats_of_any_size_are_written_as_python_writes_them() -> None:
    chance = random.Random(1)
    floats = [struct.unpack("d", chance.randbytes(8))[0] for _ in range(5000)]
    floats += [chance.uniform(-1.0, 1.0) * 10.0 ** chance.randint(-8, 20) for _ in range(5000)]
    floats += [math.nextafter(edge, side) for edge in (1e-4, 1e15, 1e16) for side in (0.0, edge, math.inf)]
    for one in filter(math.isfinite, floats):
        assert canonical({"a": one}) == by_python({"a": one})


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_what_is_not_finite_is_refused(value: float) -> None:
    with pytest.raises(ValueError, match="not JSON compliant"):
        canonical({"a": {"b": [value]}})
