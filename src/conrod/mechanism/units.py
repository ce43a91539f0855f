"""Quantities as people write them ("80mm", "500rpm", "12.5" in SI), checks of numbers, and parameters of scenes."""

from __future__ import annotations

import dataclasses
import math
import re
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, Any

from conrod.errors import InvalidInput

if TYPE_CHECKING:
    import pint

EXAMPLES = {
    "m": "80mm, 0.08 or 3.2in",
    "rad/s": "500rpm, 52.36 or 3000deg/s",
    "kg": "6kg or 500g",
    "kg*m^2": "0.02 or 20 g m²",
    "m/s^2": "9.81 or 0",
    "rad": "60deg or 1.0472",
    "": "a plain number",
}
# A number in ordinary notation: what Python's float() also takes ("1_000", "infinity") is more likely a slip.
NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?")
# Products and quotients of unit names with one-digit powers: all that units need, and no expression to evaluate.
TERM = r"[A-Za-zµμ°]+(\^[+-]?\d)?"
UNIT = re.compile(rf"{TERM}(\s*[*/·\s]\s*{TERM})*")
# As reports write them, and as people do who have no such keys: m/s², m/s2, kg.m2, m*s**-2.
RAISED = str.maketrans({"²": "^2", "³": "^3"})
POWER = re.compile(r"(?<=[A-Za-zµμ°])([+-]?\d)")
DOT = re.compile(r"(?<=[A-Za-z0-9])\.(?=[A-Za-z])")
REVOLUTION = 2.0 * math.pi  # [rad]
RPM = REVOLUTION / 60.0  # [rad/s]
COMMA = re.compile(r"[+-]?\d*,\d+")


@cache
def _registry() -> pint.UnitRegistry[float]:
    # Imported here because it takes a good part of a second, which `conrod --help` need not spend.
    import pint

    registry: pint.UnitRegistry[float] = pint.UnitRegistry()
    # pint knows a revolution only by its full name, machinists know it as rev.
    registry.define("@alias revolution = rev")
    return registry


def parse_quantity(name: str, text: str, unit: str) -> float:
    """The value of a quantity in an SI unit.

    Args:
        name: of the parameter, for the error.
        text: a number, SI, or a number with a unit of the same dimension.
        unit: the SI unit wanted; empty for a plain number.

    Raises:
        InvalidInput: not a number, an unknown unit, one of another dimension, or an angle of more than a turn without
            unit.
    """
    stripped = text.strip()
    number = NUMBER.match(stripped)
    if number is None:
        raise InvalidInput(f"{name} = {text!r} is not a number{_example(unit)}")
    if COMMA.match(stripped):
        raise InvalidInput(
            f"{name} = {text!r}: decimals are written with a point, as in {stripped.replace(',', '.')!r}"
        )
    raised = stripped[number.end() :].strip().translate(RAISED).replace("**", "^")
    written = POWER.sub(r"^\1", DOT.sub("*", raised))
    if not written:
        check_bare_angle(name, float(number.group()), unit)
        return float(number.group())
    if not UNIT.fullmatch(written):
        raise _unknown_unit(name, text, written, unit)
    if unit == "rad/s" and re.search(r"\b[kM]?Hz\b|hertz", written):
        raise InvalidInput(f"{name} = {text!r}: Hz may mean turns or radians per second; give rpm or rad/s")
    return _convert(name, text, float(number.group()), written, unit)


def check_bare_angle(name: str, value: float, unit: str) -> None:
    """Refuse an angle of more than a turn without unit: it is in radians, and degrees are meant.

    Raises:
        InvalidInput: says how both are written.
    """
    if unit == "rad" and abs(value) > REVOLUTION:
        raise InvalidInput(
            f"{name} = {value:g} has no unit and would be radians, {math.degrees(value):.0f} deg: write "
            f"{value:g}deg if degrees are meant, {value:g}rad if not"
        )


def _convert(name: str, text: str, value: float, written: str, unit: str) -> float:
    import pint

    registry = _registry()
    try:
        wanted = registry.parse_units(written.replace("·", "*"))
        return float(registry.Quantity(value, wanted).to(unit or "dimensionless").magnitude)
    except pint.DimensionalityError:
        raise InvalidInput(
            f"{name} = {text!r}: {written!r} is not a unit of {in_prose(unit) or 'a number'}{_example(unit)}"
        ) from None
    except (pint.PintError, AttributeError, AssertionError, TypeError, ValueError):
        raise _unknown_unit(name, text, written, unit) from None


def _unknown_unit(name: str, text: str, written: str, unit: str) -> InvalidInput:
    return InvalidInput(f"{name} = {text!r}: unknown unit {written!r}{_example(unit)}")


def _example(unit: str) -> str:
    return f"; give for instance {EXAMPLES[unit]}" if unit in EXAMPLES else ""


def in_prose(unit: str) -> str:
    """A unit as prose and output have it: kg m² for kg*m^2."""
    return unit.replace("*", " ").replace("^2", "²").replace("^3", "³")


def check_number(name: str, value: object, lowest: float, highest: float, unit: str = "") -> None:
    """Refuse what is not a finite number from `lowest` to `highest`.

    Raises:
        InvalidInput: names the value and the range.
    """
    suffix = f" {in_prose(unit)}" if unit else ""
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
        raise InvalidInput(f"{name} = {value!r} is not a finite number")
    if not lowest <= value <= highest:
        raise InvalidInput(f"{name} = {value:g}{suffix} is out of range: {lowest:g} <= {name} <= {highest:g}{suffix}")


def check_count(name: str, value: object, lowest: int, highest: int) -> None:
    """Refuse what is not a whole number from `lowest` to `highest`.

    Raises:
        InvalidInput: names the value and the range.
    """
    if isinstance(value, bool) or not isinstance(value, int):
        raise InvalidInput(f"{name} = {value!r} is not a whole number")
    if not lowest <= value <= highest:
        raise InvalidInput(f"{name} = {value} is out of range: {lowest} <= {name} <= {highest}")


# -- parameters --------------------------------------------------------------------------------------------------------

LARGEST_PROPORTION = 1e4


@dataclass(frozen=True)
class Parameter:
    """Unit, range and meaning of one parameter."""

    unit: str  # SI: m, rad/s, kg, kg*m^2, m/s^2 or empty
    lowest: float
    highest: float
    magnitude: bool = False  # the range holds for the absolute value: both signs are allowed
    meaning: str = ""
    name: str = ""

    def check(self, value: float) -> None:
        """Refuse a value that is not a finite number within the range.

        Raises:
            InvalidInput: names the parameter, its value and its range.
        """
        check_number(self.name, value, -self.highest if self.magnitude else self.lowest, self.highest, self.unit)
        if self.magnitude and abs(value) < self.lowest:
            raise InvalidInput(
                f"{self.name} = {value:g} {self.unit} is out of range: "
                f"{self.lowest:g} <= |{self.name}| <= {self.highest:g} {self.unit}"
            )


def _field(unit: str, lowest: float, highest: float, magnitude: bool = False) -> Callable[[float, str], Any]:
    """Maker of a dataclass field, by its default and its meaning."""

    def field(default: float, meaning: str) -> Any:
        parameter = Parameter(unit, lowest, highest, magnitude, meaning)
        return dataclasses.field(default=default, metadata={"parameter": parameter})

    return field


length = _field("m", 1e-6, 1e6)
offset = _field("m", 0.0, 1e6, magnitude=True)  # a length that may be zero or negative
mass = _field("kg", 1e-6, 1e9)
inertia = _field("kg*m^2", 1e-12, 1e9)  # about the centre of gravity
gravity = _field("m/s^2", 0.0, 1e5)  # acceleration of free fall; zero switches it off
factor = _field("", 0.0, 1e6)


def speed(default: float) -> Any:
    """A crank speed [rad/s]."""
    return _field("rad/s", 1e-6, 1e6, magnitude=True)(default, "crank speed; negative is the other sense of rotation")


def parameters_of(scene_class: type) -> dict[str, Parameter]:
    """The parameters of a scene class, in order of declaration."""
    fields = [field for field in dataclasses.fields(scene_class) if "parameter" in field.metadata]
    return {field.name: dataclasses.replace(field.metadata["parameter"], name=field.name) for field in fields}


def check_proportion(long_name: str, long: float, short_name: str, short: float) -> None:
    """Refuse lengths so unequal that the motion has few digits left of the machine's own rounding.

    Raises:
        InvalidInput: names both, and the largest proportion.
    """
    if long > LARGEST_PROPORTION * short:
        raise InvalidInput(
            f"{long_name} = {long:g} m is out of proportion: at most {LARGEST_PROPORTION:g} x {short_name} "
            f"= {LARGEST_PROPORTION * short:g} m"
        )
