"""Families of machines: a scene with a list of values of some parameters, a member for each combination."""

from __future__ import annotations

import itertools
import math
import re
import unicodedata
from collections.abc import Mapping, Sequence
from typing import TypeAlias

from conrod.errors import InvalidInput
from conrod.mechanism.units import DECIMAL_COMMA, NUMBER, parse_quantity
from conrod.scenes import Scene

MAX_MEMBERS = 1000  # in one request: of some seconds a machine that is an hour
# Texts of a parameter's value: one for all machines, or a tuple of which each member of the family has one.
Value: TypeAlias = str | tuple[str, ...]
VALUE_SIGN = "="  # in the names of members alone
NOT_IN_NAMES = re.compile(r"[^A-Za-z0-9.+-]+")  # such as the slash of rad/s: a member's name is the name of its page


def split_values(name: str, text: str) -> Value:
    """Split a parameter's typed value at its commas; a text without a comma is one value.

    Raises:
        InvalidInput: a value is empty, or the comma may be a decimal mark.
    """
    values = tuple(value.strip() for value in text.split(","))
    if len(values) == 1:
        return text
    if "" in values:
        raise InvalidInput(f"{name} = {text!r}: value {values.index('') + 1} of {len(values)} is empty")
    bare = [NUMBER.fullmatch(value) is not None for value in values]
    # "72,5mm", or "72,5" of a plain number, is more likely a decimal comma than a list.
    if DECIMAL_COMMA.match(text.strip()) and (len(values) == 2 or len(set(bare)) == 2):
        raise InvalidInput(
            f"{name} = {text!r}: decimals are written with a point, as in {text.strip().replace(',', '.', 1)!r}; "
            "in a list each value has its unit or a point, e.g. 36mm,46mm or 2.0,3.0"
        )
    return values


def members_of(name: str, scene: Scene, values: Mapping[str, Value]) -> dict[str, Scene]:
    """Return the members of a family by name; only the scene if no parameter has several values.

    Args:
        name: name of the scene, with which the names of its members begin.
        values: texts of the values by parameter.

    Raises:
        InvalidInput: a value that cannot be used, twice the same value, too many members, or a member that cannot be
            assembled, which is named.
    """
    facts = scene.parameter_facts()
    fixed = {one: text for one, text in values.items() if one in facts and isinstance(text, str)}
    lists = {one: texts for one, texts in values.items() if one in facts and not isinstance(texts, str)}
    numbers = {one: parse_quantity(one, text, facts[one].unit) for one, text in fixed.items()}
    if not lists:
        return {name: scene.with_parameters(**numbers) if numbers else scene}
    if (count := math.prod(map(len, lists.values()))) > MAX_MEMBERS:
        made = " x ".join(f"{len(texts)} of {one}" for one, texts in lists.items())
        raise InvalidInput(f"{name}: {made} are {count} machines, which are too many: there may be {MAX_MEMBERS}")
    values_by_text = {one: _parse_list(one, texts, facts[one].unit) for one, texts in lists.items()}
    found = dict[str, Scene]()
    for texts in itertools.product(*lists.values()):
        chosen = dict(zip(lists, texts, strict=True))
        member = member_name(name, chosen)
        try:
            found[member] = scene.with_parameters(
                **numbers, **{one: values_by_text[one][text] for one, text in chosen.items()}
            )
        except InvalidInput as error:
            raise InvalidInput(f"{member}: {error}") from None
    return found


def _parse_list(name: str, texts: Sequence[str], unit: str) -> dict[str, float]:
    """Parse a parameter's values; raises InvalidInput for twice the same."""
    found, texts_of = dict[str, float](), dict[float, str]()
    for text in texts:
        value = parse_quantity(name, text, unit)
        if value in texts_of:
            raise InvalidInput(f"{name}: {texts_of[value]!r} and {text!r} are the same value: give each once")
        found[text], texts_of[value] = value, text
    return found


def member_name(name: str, chosen: Mapping[str, str]) -> str:
    """Name of a member: the scene's, with each parameter that differs and its value as it was given."""
    words = [f"{one}{VALUE_SIGN}{_safe_text(text)}" for one, text in chosen.items()]
    return "-".join([name, *words])


def _safe_text(text: str) -> str:
    plain = unicodedata.normalize("NFKC", text).replace(" ", "")
    return NOT_IN_NAMES.sub("_", plain)


def member_arguments(
    arguments: Mapping[str, str], scenes: Mapping[str, Scene], values: Mapping[str, Value]
) -> dict[str, tuple[str, ...]]:
    """Words of a command line that give each machine of a request by itself, by name.

    Args:
        arguments: argument of each scene by its name: that name, or a mechanism file.
        scenes: scenes of the request by name, before a parameter was given.
        values: texts of the values by parameter.
    """
    found = dict[str, tuple[str, ...]]()
    for name, scene in scenes.items():
        own = {one: texts for one, texts in values.items() if one in scene.parameter_facts()}
        choices = [[text] if isinstance(text, str) else text for text in own.values()]
        for texts in itertools.product(*choices):
            chosen = dict(zip(own, texts, strict=True))
            member = member_name(name, {one: chosen[one] for one, all_of in own.items() if not isinstance(all_of, str)})
            words = (word for one, text in chosen.items() for word in ("--set", f"{one}={text}"))
            found[member] = (arguments.get(name, name), *words)
    return found
