"""One table of a file, from which known fields are taken; what is left over is an error."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from typing import Any

from conrod.errors import InvalidInput, unknown_choice
from conrod.mechanism.files.numbers import COORDINATE, SHOWN, Measure, Numbers, shown
from conrod.mechanism.mechanism import Point

NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_-]{0,39}")
LONGEST_TEXT = 2000
COORDINATES = 2


class Fields:
    """A table with its place in the file.

    Raises:
        InvalidInput: on construction, what stands there is no table.
    """

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

    def raw(self, name: str) -> Any:
        """A field as it stands.

        Raises:
            InvalidInput: there is none.
        """
        self._known.add(name)
        if name not in self._given:
            where = f"{self.place}: " if self.place else ""
            near = self._misspelt(name)
            raise InvalidInput(f"{where}there is no {name!r}, which is needed{near}")
        return self._given[name]

    def _misspelt(self, name: str) -> str:
        import difflib

        near = difflib.get_close_matches(name, [key for key in self._given if len(key) <= SHOWN], n=1, cutoff=0.7)
        return f"; is {near[0]!r} meant for it?" if near else ""

    def may_hold(self, *names: str) -> None:
        """Fields that are known, though nothing may have asked for them."""
        self._known.update(names)

    def end(self) -> None:
        """Refuse what nobody asked for.

        Raises:
            InvalidInput: names the first unknown field, and the nearest known one.
        """
        for name in self._given:
            if name not in self._known:
                where = f" in {self.place}" if self.place else ""
                raise unknown_choice(f"field{where}", name[:SHOWN], self._known)

    # -- values --------------------------------------------------------------------------------------------------

    def text(self, name: str, default: str | None = None) -> str:
        """A text in one line; what is left out is an error without a default."""
        self._known.add(name)
        if default is not None and name not in self:
            return default
        return one_line(self.at(name), self.raw(name))

    def texts(self, name: str) -> tuple[str, ...]:
        """A list of texts, empty where it is left out."""
        self._known.add(name)
        given = self._given.get(name, [])
        if not isinstance(given, list):
            raise InvalidInput(f"{self.at(name)} = {shown(given)}: a list of texts is wanted")
        return tuple(one_line(f"{self.at(name)}[{k}]", some) for k, some in enumerate(given))

    def truth(self, name: str) -> bool:
        """True or false; false where it is left out."""
        self._known.add(name)
        given = self._given.get(name, False)
        if not isinstance(given, bool):
            raise InvalidInput(f"{self.at(name)} = {shown(given)}: give true or false")
        return given

    def choice(self, name: str, choices: Iterable[str], default: str | None = None) -> str:
        """One of some words."""
        given, words = self.text(name, default), tuple(choices)
        if given not in words:
            raise unknown_choice(self.at(name), given[:SHOWN], words)
        return given

    def number(self, name: str, measure: Measure, meaning: str, default: float | None = None) -> float:
        """A quantity, SI; what is left out is an error without a default."""
        self._known.add(name)
        given = self.raw(name) if default is None or name in self else default
        return self.numbers.take(self.at(name), given, measure, meaning)

    def pair(self, name: str, measure: Measure, meaning: str, default: Point | None = None) -> Point:
        """Two quantities, along x and along y."""
        self._known.add(name)
        given = self.raw(name) if default is None or name in self else list(default)
        return self._pair(given, self.at(name), measure, meaning)

    def _pair(self, given: object, place: str, measure: Measure, meaning: str) -> Point:
        if isinstance(given, list) and len(given) == COORDINATES + 1 and measure is COORDINATE:
            raise InvalidInput(
                f"{place} has three coordinates: only planar mechanisms can be described, give [x, y], with decimal "
                "points"
            )
        if not isinstance(given, list) or len(given) != COORDINATES:
            raise InvalidInput(f"{place} = {shown(given)}: two numbers are wanted, [x, y]")
        x, y = (self.numbers.take(f"{place}.{a}", v, measure, meaning) for a, v in zip("xy", given, strict=True))
        return (x, y)

    # -- tables --------------------------------------------------------------------------------------------------

    def table(self, name: str) -> Fields:
        """A table in this one, empty where it is left out."""
        self._known.add(name)
        return Fields(self._given.get(name, {}), self.at(name), self.numbers)

    def names(self) -> tuple[str, ...]:
        """Names of all that stands in this table, in alphabetical order: that of declaration means nothing.

        Raises:
            InvalidInput: one cannot be a name.
        """
        for name in self._given:
            check_name(self.place, name)
        self._known.update(self._given)
        return tuple(sorted(self._given))


def check_name(place: str, name: str) -> None:
    """Refuse what cannot be a name.

    Raises:
        InvalidInput: says what a name is made of.
    """
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
