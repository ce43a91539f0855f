"""The numbers of a file: each with its place, its unit and its range, so that any of them can be given anew."""

from __future__ import annotations

import datetime
from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from conrod.errors import InvalidInput
from conrod.mechanism.parameters import Parameter, check_value
from conrod.mechanism.units import parse_quantity

SHOWN = 60  # characters of a value in a message


@dataclass(frozen=True)
class Measure:
    """A kind of number: its SI unit and its range."""

    unit: str
    lowest: float
    highest: float
    magnitude: bool = False  # the range holds for the absolute value

    def parameter(self, place: str, meaning: str) -> Parameter:
        """As a parameter of a scene."""
        return Parameter(place, self.unit, meaning, self.lowest, self.highest, self.magnitude)


LENGTH = Measure("m", 1e-9, 1e6)
COORDINATE = Measure("m", 0.0, 1e6, magnitude=True)
ANGLE = Measure("rad", 0.0, 1e3, magnitude=True)
SPEED = Measure("rad/s", 1e-6, 1e6, magnitude=True)
MASS = Measure("kg", 1e-9, 1e12)
INERTIA = Measure("kg*m^2", 1e-14, 1e24)  # MuJoCo compiles no body of less than 1e-15
FREE_FALL = Measure("m/s^2", 0.0, 1e5, magnitude=True)
FORCE = Measure("N", 0.0, 1e12, magnitude=True)


@dataclass
class Numbers:
    """All numbers that were read, by their place in the file.

    Attributes:
        given_anew: values [SI] that count instead of the file's own.
        values: what counts, SI.
        facts: unit, meaning and range.
    """

    given_anew: Mapping[str, float] = field(default_factory=dict)
    values: dict[str, float] = field(default_factory=dict)
    facts: dict[str, Parameter] = field(default_factory=dict)

    def take(self, place: str, given: object, measure: Measure, meaning: str, name: str = "") -> float:
        """The number at a place.

        Args:
            name: of the parameter, where it is another than the place.

        Raises:
            InvalidInput: it is none, has another unit's dimension, or is out of range.
        """
        fact = measure.parameter(place, meaning)
        value = _number(place, given, measure.unit)
        check_value(fact, value)
        parameter = name or place
        if parameter in self.given_anew:
            value = self.given_anew[parameter]
            check_value(fact, value)
        self.values[parameter], self.facts[parameter] = float(value), replace(fact, name=parameter)
        return float(value)


def _number(place: str, given: object, unit: str) -> float:
    if isinstance(given, str):
        if len(given) > SHOWN:
            raise InvalidInput(f"{place} = {shown(given)} is not a number")
        return parse_quantity(place, given, unit)
    if isinstance(given, bool) or not isinstance(given, (int, float)):
        raise InvalidInput(f"{place} = {shown(given)} is not a number{_or_text(unit)}")
    try:
        return float(given)
    except OverflowError:
        raise InvalidInput(f"{place} is a whole number of too many digits") from None


def _or_text(unit: str) -> str:
    return f"; give it in {unit}, or as text with a unit" if unit else ""


def shown(given: object) -> str:
    """A value of a file in a message: one short line."""
    # A list may hold anything, of any depth: its size says enough.
    text = f"a {_KINDS[type(given)]}" if type(given) in _KINDS else repr(given)
    text = text.lower() if isinstance(given, bool) else text
    return text if len(text) <= SHOWN else f"{text[: SHOWN - 4]}...{text[-1]}"


_KINDS: dict[type, str] = {
    list: "list",
    dict: "table",
    datetime.datetime: "date",
    datetime.date: "date",
    datetime.time: "time of day",
}
