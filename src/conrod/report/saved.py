"""Findings as JSON: in reproducible digits, and as text that people compare."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any, TypeVar

from conrod.report import numbers
from conrod.runs.plain import plain, restore
from conrod.scenes import SCENES, Scene
from conrod.scenes.described_scene import DescribedScene

T = TypeVar("T")
# Digits of an array, which is there to be drawn; single numbers keep all of theirs.
DRAWN_DIGITS = 7
LONGEST_LINE = 100
# Of what is given, and not measured, all digits are kept.
GIVEN: dict[str, int | None] = dict.fromkeys(("parameters", "given_anew", "settings", "changes"))


def values_of(findings: Any) -> Any:
    """The findings as what JSON can hold; raises TypeError where they cannot be restored from it."""
    return plain(findings, DRAWN_DIGITS)


def restored(wanted: type[T], values: Any) -> T:
    """The findings of a type that `values_of` made these values of; raises InvalidInput where they do not fit it."""
    return restore(wanted, values, {Scene: _scene})


def _scene(values: Mapping[str, Any]) -> Scene:
    if "document" in values:
        return DescribedScene(values["document"], tuple(sorted(values["given_anew"].items())))
    return {scene.kind: type(scene) for scene in SCENES.values()}[values["machine"]](**values["parameters"])


def shortened(values: Any, digits: int | None, digits_of: Mapping[str, int | None] = GIVEN) -> Any:
    """The values with so many reproducible digits of fractions, of parts by name with others; None keeps all."""
    match values:
        case _ if digits is None:
            return values
        case float():
            return numbers.reproducible(values, digits)
        case dict():
            return {key: shortened(part, digits_of.get(key, digits), digits_of) for key, part in values.items()}
        case list():
            return [shortened(part, digits, digits_of) for part in values]
        case _:
            return values


def json_text(values: Any) -> str:
    """The values as JSON: lists of numbers on one line, all else on lines of its own."""
    return _lines(values, "") + "\n"


def _lines(values: Any, indent: str) -> str:
    flat = json.dumps(values, ensure_ascii=False, allow_nan=False)
    if len(flat) > LONGEST_LINE:
        flat = json.dumps(values, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
    if not isinstance(values, dict | list | tuple) or not values:
        return flat
    if len(flat) + len(indent) <= LONGEST_LINE or (
        not isinstance(values, dict) and not any(isinstance(part, dict | list | tuple) for part in values)
    ):
        return flat
    deeper = indent + " "
    if isinstance(values, dict):
        parts = [f"{json.dumps(key, ensure_ascii=False)}: {_lines(part, deeper)}" for key, part in values.items()]
        return "{\n" + ",\n".join(deeper + part for part in parts) + f"\n{indent}}}"
    return "[\n" + ",\n".join(deeper + _lines(part, deeper) for part in values) + f"\n{indent}]"
