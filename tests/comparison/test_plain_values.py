"""Results as plain values, and back."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
import pytest

from conrod import InvalidInput
from conrod.comparison.plain_values import json_document, plain_values, restore
from conrod.exact.motion import Array


class Node(NamedTuple):
    column: int
    error: float | None


@dataclass(frozen=True)
class Size:
    largest: float
    at: tuple[float, ...]


@dataclass(frozen=True)
class Found:
    curve: Array
    sizes: Mapping[str, Mapping[str, Size]]
    nodes: tuple[Node, ...]
    best: Size | None
    others: Mapping[str, Any]
    count: int = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "count", len(self.nodes))


FOUND = Found(
    np.array([[1.0, 0.1 + 0.2], [np.pi, -0.0]]),
    {"C": {"position": Size(np.float64(1.0 / 3.0), (1e-300,))}},
    (Node(3, None), Node(4, 0.5)),
    None,
    {"steps": [1, 2]},
)


def test_plain_values_survive_json_to_the_last_bit() -> None:
    again = restore(Found, json.loads(json.dumps(plain_values(FOUND))))
    assert again.curve.tobytes() == FOUND.curve.tobytes()
    assert again.curve.shape == (2, 2)
    assert plain_values(again) == plain_values(FOUND)
    assert (again.nodes, again.best, again.count) == (FOUND.nodes, None, 2)


@pytest.mark.parametrize(
    ("change", "named"),
    [({"nodes": 3}, "nodes"), ({"best": {"largest": "x", "at": []}}, "largest"), ({"curve": "x"}, "curve")],
)
def test_restore_names_value_that_does_not_fit(change: dict[str, Any], named: str) -> None:
    with pytest.raises(InvalidInput, match=named):
        restore(Found, plain_values(FOUND) | change)


def test_restore_names_missing_and_skips_unknown_values() -> None:
    values = plain_values(FOUND)
    assert restore(Found, values | {"of a later version": 1}).nodes == FOUND.nodes
    del values["sizes"]
    with pytest.raises(InvalidInput, match="sizes"):
        restore(Found, values)


def test_json_document_has_null_for_numbers_not_finite() -> None:
    # A mutated model had one, and `harden` ended in a traceback.
    assert json.loads(json_document({"a": [np.inf, -np.inf, np.nan], "b": 1e-5})) == {"a": [None] * 3, "b": 1e-5}
