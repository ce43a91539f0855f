"""Fields of one table of a file, each read by its name and kind; unknown fields are errors.

Each number is a parameter, by its place in the file, so that its value can be replaced.
"""

from __future__ import annotations

import datetime
import difflib
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from conrod.errors import InvalidInput, unknown_choice
from conrod.mechanism.mechanism import Point
from conrod.mechanism.units import NUMBER, Parameter, check_bare_angle, parse_quantity

LENGTH = Parameter("m", 1e-9, 1e6)
COORDINATE = Parameter("m", 0.0, 1e6, magnitude=True)
ANGLE = Parameter("rad", 0.0, 1e3, magnitude=True)
SPEED_NAME = "speed"  # name of the crank speed in all scenes
SPEED = Parameter("rad/s", 1e-6, 1e6, magnitude=True)

PARAMETERS = "parameters"
# The name of a parameter in place of a number, or of its negative.
PARAMETER_REFERENCE = re.compile(r"(?P<sign>-?)\s*(?P<name>[A-Za-z][A-Za-z0-9_-]{0,39})")
NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_-]{0,39}")
MAX_TEXT_CHARACTERS = 2000
MAX_SHOWN_CHARACTERS = 60  # characters of a value in a message
SENSES = {"counter-clockwise": 1, "clockwise": -1}
_TYPE_NAMES: dict[type, str] = {
    list: "list", dict: "table", datetime.datetime: "date", datetime.date: "date", datetime.time: "time of day",
}  # fmt: skip


@dataclass
class Numbers:
    """All numbers read from a file, by their place in it, or by their name in [parameters].

    Attributes:
        given_anew: values [SI] that replace the file's.
        named: raw values of [parameters], by name.
        values: values used [SI], by place or parameter name.
        facts: unit and range of each.
        bare: names of numbers without unit, and of places that refer to one.
    """

    given_anew: Mapping[str, float] = field(default_factory=dict)
    named: Mapping[str, object] = field(default_factory=dict)
    values: dict[str, float] = field(default_factory=dict)
    facts: dict[str, Parameter] = field(default_factory=dict)
    bare: set[str] = field(default_factory=set)

    def take(self, place: str, given: object, kind: Parameter, meaning: str, name: str = "") -> float:
        """Read the number at a place [SI], and record it as a parameter.

        Args:
            name: name of the parameter, if it is not the place.

        Raises:
            InvalidInput: the value is no number, has a unit of another dimension, or is out of range.
        """
        fact = replace(kind, name=place, meaning=meaning)
        value = self._resolve_value(place, given, fact)
        if self._is_bare(given):
            self.bare.add(name or place)
            check_bare_angle(place, value, fact.unit)
        fact.check(value)
        if not name and self._reference(given):
            return value  # the parameter named is already recorded
        name = name or place
        if name in self.given_anew:
            value = self.given_anew[name]
            fact.check(value)
        self.values[name], self.facts[name] = value, replace(fact, name=name)
        return value

    def _is_bare(self, given: object) -> bool:
        """True if a number, or a named parameter, has no unit; record such a parameter in `bare`."""
        if reference := self._reference(given):
            name = reference["name"]
            bare = name not in self.given_anew and self._is_bare(self.named[name])
            self.bare |= {name} if bare else set()
            return bare
        return not isinstance(given, str) or NUMBER.fullmatch(given.strip()) is not None

    def _reference(self, given: object) -> re.Match[str] | None:
        """Match of a reference to a parameter; None for a number."""
        return PARAMETER_REFERENCE.fullmatch(given.strip()) if self.named and isinstance(given, str) else None

    def _resolve_value(self, place: str, given: object, fact: Parameter, passed: tuple[str, ...] = ()) -> float:
        """The number itself, or the value of the parameter that it names [SI].

        Raises:
            InvalidInput: as `take`; or the parameter is unknown, refers back to itself, or has another dimension.
        """
        reference = self._reference(given)
        if reference is None:
            return _number(place, given, fact.unit)
        name = reference["name"]
        if name not in self.named:
            raise unknown_choice(f"parameter in {place}", name, self.named)
        own, known = f"{PARAMETERS}.{name}", self.facts.get(name, fact)
        if name in passed:
            raise InvalidInput(f"{own}: it leads back to itself: {', '.join((*passed, name))}")
        if known.unit != fact.unit:
            here, there = (f"in {one}" if one else "a plain number" for one in (fact.unit, known.unit))
            raise InvalidInput(f"{place} = {name!r}: it is {here}, but {own} is {there} elsewhere")
        value = self._resolve_value(own, self.named[name], fact, (*passed, name))
        value = float(self.given_anew.get(name, value))
        self.values[name], self.facts[name] = value, replace(known, name=name)
        return -value if reference["sign"] else value


def _number(place: str, given: object, unit: str) -> float:
    """Convert a number or a quantity as text to SI."""
    if isinstance(given, str) and len(given) <= MAX_SHOWN_CHARACTERS:
        return parse_quantity(place, given, unit)
    if isinstance(given, bool) or not isinstance(given, (int, float)):
        wanted = f"; give it in {unit}, or as text with a unit" if unit and not isinstance(given, str) else ""
        raise InvalidInput(f"{place} = {describe_value(given)} is not a number{wanted}")
    try:
        return float(given)
    except OverflowError:
        raise InvalidInput(f"{place} is a whole number of too many digits") from None


def describe_value(given: object) -> str:
    """A value of a file for an error message, in one short line."""
    # The type is enough for containers, which may be of any size and depth.
    text = f"a {_TYPE_NAMES[type(given)]}" if type(given) in _TYPE_NAMES else repr(given)
    text = text.lower() if isinstance(given, bool) else text
    return text if len(text) <= MAX_SHOWN_CHARACTERS else f"{text[: MAX_SHOWN_CHARACTERS - 4]}...{text[-1]}"


class Fields:
    """One table of a file; its methods raise InvalidInput that names the place and the expected content."""

    def __init__(self, given: object, place: str, numbers: Numbers) -> None:
        if not isinstance(given, dict):
            raise InvalidInput(f"{place} = {describe_value(given)}: a table is wanted")
        self.place, self.numbers = place, numbers
        self._given: Mapping[str, Any] = given
        self._known: set[str] = set()

    def __contains__(self, name: str) -> bool:
        return name in self._given

    def place_of(self, name: str) -> str:
        """Place of a field as a user writes it: "joints.A.kind"."""
        return f"{self.place}.{name}" if self.place else name

    def raw(self, name: str, default: Any = None) -> Any:
        """Value of a field as parsed; a missing field without default is an error."""
        self._known.add(name)
        if name in self._given or default is not None:
            return self._given.get(name, default)
        near = difflib.get_close_matches(
            name, [key for key in self._given if len(key) <= MAX_SHOWN_CHARACTERS], n=1, cutoff=0.7
        )
        meant = f"; is {near[0]!r} meant for it?" if near else ""
        where = f"{self.place}: " if self.place else ""
        raise InvalidInput(f"{where}there is no {name!r}, which is needed{meant}")

    def refuse_unknown(self) -> None:
        """Refuse fields that were not read, naming the first and the nearest known field."""
        for name in self._given:
            if name not in self._known:
                where = f" in {self.place}" if self.place else ""
                raise unknown_choice(f"field{where}", name[:MAX_SHOWN_CHARACTERS], self._known)

    # -- values --------------------------------------------------------------------------------------------------

    def text(self, name: str, default: str | None = None) -> str:
        """Text of a field, in one line."""
        return one_line(self.place_of(name), self.raw(name, default))

    def texts(self, name: str) -> tuple[str, ...]:
        """List of texts; empty if the field is missing."""
        given = self.raw(name, [])
        if not isinstance(given, list):
            raise InvalidInput(f"{self.place_of(name)} = {describe_value(given)}: a list of texts is wanted")
        return tuple(one_line(f"{self.place_of(name)}[{k}]", some) for k, some in enumerate(given))

    def flag(self, name: str) -> bool:
        """True or false; false if the field is missing."""
        given = self.raw(name, False)
        if not isinstance(given, bool):
            raise InvalidInput(f"{self.place_of(name)} = {describe_value(given)}: give true or false")
        return given

    def choice(self, name: str, choices: Iterable[str], default: str | None = None) -> str:
        """Text of a field that has to be one of some words."""
        given, words = self.text(name, default), tuple(choices)
        if given not in words:
            raise unknown_choice(self.place_of(name), given[:MAX_SHOWN_CHARACTERS], words)
        return given

    def number(self, name: str, kind: Parameter, meaning: str, default: float | None = None) -> float:
        """Quantity of a field [SI]."""
        return self.numbers.take(self.place_of(name), self.raw(name, default), kind, meaning)

    def optional_number(self, name: str, kind: Parameter, meaning: str) -> float | None:
        """Quantity of a field [SI]; None, and no parameter, if it is missing."""
        self._known.add(name)
        return self.number(name, kind, meaning) if name in self else None

    def entries(
        self, name: str, wanted: str, least: int = 2, most: int = 2, kind: type = object, default: Any = None
    ) -> list[Any]:
        """List in a field, with a number of entries within limits, all of one type.

        Args:
            wanted: clause of the error message that says what is expected.
        """
        given = self.raw(name, default)
        if not (isinstance(given, list) and least <= len(given) <= most and all(isinstance(x, kind) for x in given)):
            raise InvalidInput(f"{self.place_of(name)} = {describe_value(given)}: {wanted}")
        return given

    def pair(self, name: str, kind: Parameter, meaning: str, default: Point | None = None) -> Point:
        """Two quantities [SI], along x and along y."""
        wanted = "two numbers are wanted, [x, y], with decimal points; mechanisms are planar"
        given = self.entries(name, wanted, default=default and list(default))
        x, y = (
            self.numbers.take(f"{self.place_of(name)}.{a}", v, kind, meaning) for a, v in zip("xy", given, strict=True)
        )
        return (x, y)

    # -- tables --------------------------------------------------------------------------------------------------

    def table(self, name: str) -> Fields:
        """Table in a field; empty if it is missing."""
        return Fields(self.raw(name, {}), self.place_of(name), self.numbers)

    def tables(self, name: str, wanted: str, most: int) -> list[Fields]:
        """Non-empty list of tables in a field."""
        given = self.entries(name, f"a list of 1 to {most} {wanted} is wanted", 1, most)
        return [Fields(some, f"{self.place_of(name)}[{k}]", self.numbers) for k, some in enumerate(given)]

    def named_tables(self, name: str) -> dict[str, Fields]:
        """Tables in a table, by name in alphabetical order, because the order in the file must not matter."""
        whole = self.table(name)
        return {some: whole.table(some) for some in whole.names()}

    def names(self) -> tuple[str, ...]:
        """Names of all fields in alphabetical order; all count as read."""
        for name in self._given:
            check_name(self.place, name)
        self._known.update(self._given)
        return tuple(sorted(self._given))


def check_name(place: str, name: str) -> None:
    """Refuse an invalid name; InvalidInput states the rule for names."""
    if not NAME.fullmatch(name):
        raise InvalidInput(
            f"{place}: {describe_value(name)} cannot be a name: up to 40 letters (a to z), digits, '-' and '_', "
            "beginning with a letter or a digit"
        )


def one_line(place: str, given: object) -> str:
    """A text with its line breaks replaced by spaces.

    Raises:
        InvalidInput: the value is no text, is empty or too long, or has unprintable characters.
    """
    if not isinstance(given, str):
        raise InvalidInput(f"{place} = {describe_value(given)}: a text is wanted")
    text = " ".join(given.split())
    if not text or len(text) > MAX_TEXT_CHARACTERS:
        raise InvalidInput(f"{place}: a text of 1 to {MAX_TEXT_CHARACTERS} characters is wanted, not of {len(text)}")
    if not text.isprintable():
        raise InvalidInput(f"{place} = {describe_value(text)}: it has characters that cannot be printed")
    return text
