"""Findings as JSON values and back: frozen dataclasses, arrays and scenes."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence, Set
from dataclasses import fields, is_dataclass
from enum import Enum
from typing import Any, TypeVar

import msgspec
import numpy as np

from conrod.errors import InvalidInput
from conrod.report import numbers
from conrod.scenes import SCENES, Scene
from conrod.scenes.described_scene import DescribedScene

T = TypeVar("T")
# Digits of an array, which is there to be drawn; single numbers keep all of theirs.
DRAWN_DIGITS = 7
LONGEST_LINE = 100
# Of what is given, and not measured, all digits are kept.
GIVEN: dict[str, int | None] = dict.fromkeys(("parameters", "given_anew", "settings", "changes"))


def plain(value: Any) -> Any:
    """The value as what JSON can hold.

    Raises:
        TypeError: it is of a kind that cannot be restored.
    """
    found: Any
    match value:
        case None | bool() | int() | str():
            found = value
        case float():
            found = float(value) if math.isfinite(value) else str(float(value))
        case Enum():
            found = value.value
        case np.generic():
            found = plain(value.item())
        case np.ndarray():
            found = _array(value.tolist())
        case Scene():
            found = _scene_values(value)
        case Mapping():
            found = {_key(key): plain(part) for key, part in value.items()}
        case Sequence() | Set():
            found = [plain(part) for part in value]
        case _ if is_dataclass(value):
            found = {field.name: plain(getattr(value, field.name)) for field in fields(value)}
        case _:
            raise TypeError(f"{type(value).__name__} cannot be saved")
    return found


def restore(wanted: type[T], values: Any) -> T:
    """The value of a type that `plain` made these values of.

    Raises:
        InvalidInput: they do not fit the type.
    """
    try:
        return msgspec.convert(values, wanted, dec_hook=_restored, strict=False)
    except (msgspec.ValidationError, KeyError, TypeError) as error:
        raise InvalidInput(f"saved findings do not fit {wanted.__name__}: {error}") from None


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


def _key(key: Any) -> str:
    if not isinstance(key, str):
        raise TypeError(f"{key!r} is no name: keys of what is saved are texts")
    return key


def _array(values: Any) -> Any:
    if isinstance(values, list):
        return [_array(part) for part in values]
    return (
        numbers.rounded(values, DRAWN_DIGITS) if isinstance(values, float) and math.isfinite(values) else plain(values)
    )


def _scene_values(scene: Scene) -> dict[str, Any]:
    if isinstance(scene, DescribedScene):
        return {"document": scene.document, "given_anew": dict(scene.given_anew)}
    return {"machine": scene.kind, "parameters": dict(scene.parameters)}


def _scene(values: Mapping[str, Any]) -> Scene:
    if "document" in values:
        return DescribedScene(values["document"], tuple(sorted(values["given_anew"].items())))
    classes = {scene.kind: type(scene) for scene in SCENES.values()}
    return classes[values["machine"]](**values["parameters"])


def _restored(wanted: type, values: Any) -> Any:
    if wanted is Scene:
        return _scene(values)
    if wanted is np.ndarray or getattr(wanted, "__origin__", None) is np.ndarray:
        return np.array(values, dtype=float)
    raise TypeError(f"{wanted} cannot be restored")
