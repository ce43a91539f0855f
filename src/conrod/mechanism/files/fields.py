"""One table of a file, from which known fields are taken; what is left over is an error.

Each number is a parameter, by its place in the file, so that any of them can be given anew.
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
SPEED_NAME = "speed"  # what all scenes call that of the crank
SPEED = Parameter("rad/s", 1e-6, 1e6, magnitude=True)

PARAMETERS = "parameters"
# A name where a number stands: that of a parameter, or of its negative.
REFERENCE = re.compile(r"(?P<sign>-?)\s*(?P<name>[A-Za-z][A-Za-z0-9_-]{0,39})")
NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_-]{0,39}")
LONGEST_TEXT = 2000
SHOWN = 60  # characters of a value in a message
SENSES = {"counter-clockwise": 1, "clockwise": -1}
_KINDS: dict[type, str] = {
    list: "list", dict: "table", datetime.datetime: "date", datetime.date: "date", datetime.time: "time of day",
}  # fmt: skip


@dataclass
class Numbers:
    """All numbers that were read, by their place in the file; those of [parameters] by their names.

    `given_anew` count instead of the file's own; `values` are those that count, all SI; `facts` their unit and range;
    `bare` are those that stand without unit, and the places that name them.
    """

    given_anew: Mapping[str, float] = field(default_factory=dict)
    named: Mapping[str, object] = field(default_factory=dict)
    values: dict[str, float] = field(default_factory=dict)
    facts: dict[str, Parameter] = field(default_factory=dict)
    bare: set[str] = field(default_factory=set)

    def take(self, place: str, given: object, kind: Parameter, meaning: str, name: str = "") -> float:
        """The number at a place [SI]; `name` is that of the parameter, where it is another than the place.

        Raises:
            InvalidInput: it is none, has another unit's dimension, or is out of range.
        """
        fact = replace(kind, name=place, meaning=meaning)
        value = self._value(place, given, fact)
        if self._is_bare(given):
            self.bare.add(name or place)
            check_bare_angle(place, value, fact.unit)
        fact.check(value)
        if not name and self._reference(given):
            return value  # its place is no parameter of its own
        name = name or place
        if name in self.given_anew:
            value = self.given_anew[name]
            fact.check(value)
        self.values[name], self.facts[name] = value, replace(fact, name=name)
        return value

    def _is_bare(self, given: object) -> bool:
        """True if a number, or the one of [parameters] that is named, stands without unit; both are marked."""
        if reference := self._reference(given):
            name = reference["name"]
            bare = name not in self.given_anew and self._is_bare(self.named[name])
            self.bare |= {name} if bare else set()
            return bare
        return not isinstance(given, str) or NUMBER.fullmatch(given.strip()) is not None

    def _reference(self, given: object) -> re.Match[str] | None:
        return REFERENCE.fullmatch(given.strip()) if self.named and isinstance(given, str) else None

    def _value(self, place: str, given: object, fact: Parameter, passed: tuple[str, ...] = ()) -> float:
        """The number itself, or that of the parameter that is named [SI].

        Raises:
            InvalidInput: as `take`; or there is no such parameter, it leads back to itself, or has another dimension.
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
        value = self._value(own, self.named[name], fact, (*passed, name))
        value = float(self.given_anew.get(name, value))
        self.values[name], self.facts[name] = value, replace(known, name=name)
        return -value if reference["sign"] else value


def _number(place: str, given: object, unit: str) -> float:
    if isinstance(given, str) and len(given) <= SHOWN:
        return parse_quantity(place, given, unit)
    if isinstance(given, bool) or not isinstance(given, (int, float)):
        wanted = f"; give it in {unit}, or as text with a unit" if unit and not isinstance(given, str) else ""
        raise InvalidInput(f"{place} = {shown(given)} is not a number{wanted}")
    try:
        return float(given)
    except OverflowError:
        raise InvalidInput(f"{place} is a whole number of too many digits") from None


def shown(given: object) -> str:
    """A value of a file in a message: one short line."""
    # A list may hold anything, of any depth: its size says enough.
    text = f"a {_KINDS[type(given)]}" if type(given) in _KINDS else repr(given)
    text = text.lower() if isinstance(given, bool) else text
    return text if len(text) <= SHOWN else f"{text[: SHOWN - 4]}...{text[-1]}"


class Fields:
    """A table with its place in the file; its methods raise InvalidInput, which names the place and what is wanted."""

    def __init__(self, given: object, place: str, numbers: Numbers) -> None:
        if not isinstance(given, dict):
            raise InvalidInput(f"{place} = {shown(given)}: a table is wanted")
        self.place, self.numbers = place, numbers
        self._given: Mapping[str, Any] = given
        self._known: set[str] = set()

    def __contains__(self, name: str) -> bool:
        return name in self._given

    def at(self, name: str) -> str:
        """Place of a field, as a user would write it."""
        return f"{self.place}.{name}" if self.place else name

    def raw(self, name: str, default: Any = None) -> Any:
        """A field as it stands; what is left out is an error without a default."""
        self._known.add(name)
        if name in self._given or default is not None:
            return self._given.get(name, default)
        near = difflib.get_close_matches(name, [key for key in self._given if len(key) <= SHOWN], n=1, cutoff=0.7)
        meant = f"; is {near[0]!r} meant for it?" if near else ""
        where = f"{self.place}: " if self.place else ""
        raise InvalidInput(f"{where}there is no {name!r}, which is needed{meant}")

    def end(self) -> None:
        """Refuse what nobody asked for, by the first unknown field and the nearest known one."""
        for name in self._given:
            if name not in self._known:
                where = f" in {self.place}" if self.place else ""
                raise unknown_choice(f"field{where}", name[:SHOWN], self._known)

    # -- values --------------------------------------------------------------------------------------------------

    def text(self, name: str, default: str | None = None) -> str:
        """A text in one line."""
        return one_line(self.at(name), self.raw(name, default))

    def texts(self, name: str) -> tuple[str, ...]:
        """A list of texts, empty where it is left out."""
        given = self.raw(name, [])
        if not isinstance(given, list):
            raise InvalidInput(f"{self.at(name)} = {shown(given)}: a list of texts is wanted")
        return tuple(one_line(f"{self.at(name)}[{k}]", some) for k, some in enumerate(given))

    def truth(self, name: str) -> bool:
        """True or false; false where it is left out."""
        given = self.raw(name, False)
        if not isinstance(given, bool):
            raise InvalidInput(f"{self.at(name)} = {shown(given)}: give true or false")
        return given

    def choice(self, name: str, choices: Iterable[str], default: str | None = None) -> str:
        """One of some words."""
        given, words = self.text(name, default), tuple(choices)
        if given not in words:
            raise unknown_choice(self.at(name), given[:SHOWN], words)
        return given

    def number(self, name: str, kind: Parameter, meaning: str, default: float | None = None) -> float:
        """A quantity, SI."""
        return self.numbers.take(self.at(name), self.raw(name, default), kind, meaning)

    def optional(self, name: str, kind: Parameter, meaning: str) -> float | None:
        """A quantity, SI, that is no parameter where it is left out."""
        self._known.add(name)
        return self.number(name, kind, meaning) if name in self else None

    def listed(
        self, name: str, wanted: str, least: int = 2, most: int = 2, kind: type = object, default: Any = None
    ) -> list[Any]:
        """A list of so many entries of a kind; `wanted` says in the message what they are."""
        given = self.raw(name, default)
        if not (isinstance(given, list) and least <= len(given) <= most and all(isinstance(x, kind) for x in given)):
            raise InvalidInput(f"{self.at(name)} = {shown(given)}: {wanted}")
        return given

    def pair(self, name: str, kind: Parameter, meaning: str, default: Point | None = None) -> Point:
        """Two quantities, along x and along y."""
        wanted = "two numbers are wanted, [x, y], with decimal points; mechanisms are planar"
        given = self.listed(name, wanted, default=default and list(default))
        x, y = (self.numbers.take(f"{self.at(name)}.{a}", v, kind, meaning) for a, v in zip("xy", given, strict=True))
        return (x, y)

    # -- tables --------------------------------------------------------------------------------------------------

    def table(self, name: str) -> Fields:
        """A table in this one, empty where it is left out."""
        return Fields(self.raw(name, {}), self.at(name), self.numbers)

    def tables(self, name: str, wanted: str, most: int) -> list[Fields]:
        """The tables in a list of at least one."""
        given = self.listed(name, f"a list of 1 to {most} {wanted} is wanted", 1, most)
        return [Fields(some, f"{self.at(name)}[{k}]", self.numbers) for k, some in enumerate(given)]

    def named(self, name: str) -> dict[str, Fields]:
        """Tables in a table by name, in alphabetical order: that of declaration means nothing."""
        whole = self.table(name)
        return {some: whole.table(some) for some in whole.names()}

    def names(self) -> tuple[str, ...]:
        """Names of all that stands in this table, in alphabetical order."""
        for name in self._given:
            check_name(self.place, name)
        self._known.update(self._given)
        return tuple(sorted(self._given))


def check_name(place: str, name: str) -> None:
    """Refuse what cannot be a name; raises InvalidInput that says what a name is made of."""
    if not NAME.fullmatch(name):
        raise InvalidInput(
            f"{place}: {shown(name)} cannot be a name: up to 40 letters (a to z), digits, '-' and '_', beginning "
            "with a letter or a digit"
        )


def one_line(place: str, given: object) -> str:
    """A text with its line breaks made spaces.

    Raises:
        InvalidInput: it is no text, has nothing in it, is too long or has characters that cannot be printed.
    """
    if not isinstance(given, str):
        raise InvalidInput(f"{place} = {shown(given)}: a text is wanted")
    text = " ".join(given.split())
    if not text or len(text) > LONGEST_TEXT:
        raise InvalidInput(f"{place}: a text of 1 to {LONGEST_TEXT} characters is wanted, not of {len(text)}")
    if not text.isprintable():
        raise InvalidInput(f"{place} = {shown(text)}: it has characters that cannot be printed")
    return text
