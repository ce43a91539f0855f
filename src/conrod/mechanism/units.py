"""Quantities as text ("80mm", "500rpm", "12.5" in SI), checks of numbers, and parameters of scenes."""

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

UNIT_EXAMPLES = {
    "m": "80mm, 0.08 or 3.2in",
    "rad/s": "500rpm, 52.36 or 3000deg/s",
    "kg": "6kg or 500g",
    "kg*m^2": "0.02 or 20 g m²",
    "m/s^2": "9.81 or 0",
    "rad": "60deg or 1.0472",
    "": "a plain number",
}
# A number in ordinary notation; other text that Python's float() accepts ("1_000", "infinity") is more likely a slip.
NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?")
# Products and quotients of unit names with one-digit powers, so that no expression is evaluated.
TERM = r"[A-Za-zµμ°]+(\^[+-]?\d)?"
UNIT = re.compile(rf"{TERM}(\s*[*/·\s]\s*{TERM})*")
# Other spellings, in reports and by hand: m/s², m/s2, kg.m2, m*s**-2.
SUPERSCRIPTS = str.maketrans({"²": "^2", "³": "^3"})
BARE_POWER = re.compile(r"(?<=[A-Za-zµμ°])([+-]?\d)")
PRODUCT_DOT = re.compile(r"(?<=[A-Za-z0-9])\.(?=[A-Za-z])")
# A rate that counts turns or radians without saying which: catalogues mean turns by min^-1, physicists radians by s^-1.
ROTATION_UNITS = {"rad/s": "rpm or rad/s", "rad/s^2": "rpm/s or rad/s²"}
PER_TIME = re.compile(r"1 ?/ ?(s|sec|min|h)(\^2)?|(s|sec|min|h)\^-[12]")
RPM_SPELLINGS = dict.fromkeys(("RPM", "Rpm", "r/min", "U/min"), "rpm")
# A torque as data sheets print it, 5 Nm or 200 Ncm, which pint reads as a number of metres; with s that of a damper.
TORQUE = re.compile(r"(?<![A-Za-z])([kMmµμ]?)N(mm|cm|m)(s?)(?![A-Za-z])")
REVOLUTION = 2.0 * math.pi  # [rad]
RPM = REVOLUTION / 60.0  # [rad/s]
MM = 1e3  # millimetres in a metre
# Factors of common units, as pint has them to the last bit: to load it takes half a second.
FACTORS = {
    ("mm", "m"): 0.001,
    ("cm", "m"): 0.01,
    ("deg", "rad"): 0.017453292519943295,
    ("deg/s", "rad/s"): 0.017453292519943295,
    ("rpm", "rad/s"): 0.10471975511965977,
    ("ms", "s"): 0.001,
    ("g", "kg"): 0.001,
}
DECIMAL_COMMA = re.compile(r"[+-]?\d*,\d+")


@cache
def _unit_registry() -> pint.UnitRegistry[float]:
    # Imported here because it takes a good part of a second, which `conrod --help` need not spend.
    """The registry of units; pint is imported here because loading it takes a good part of a second."""
    import pint

    registry: pint.UnitRegistry[float] = pint.UnitRegistry()
    # pint knows a revolution only by its full name, machinists know it as rev.
    registry.define("@alias revolution = rev")
    return registry


def parse_quantity(name: str, text: str, unit: str) -> float:
    """Parse a quantity and convert it to an SI unit.

    Args:
        name: name of the parameter, for the error.
        text: a number, SI, or a number with a unit of the same dimension.
        unit: the SI unit; empty for a plain number.

    Raises:
        InvalidInput: not a number, an unknown unit, one of another dimension, or an angle of more than a turn without
            unit.
    """
    stripped = text.strip()
    number = NUMBER.match(stripped)
    if number is None:
        raise InvalidInput(f"{name} = {text!r} is not a number{_example_clause(unit)}")
    if DECIMAL_COMMA.match(stripped):
        raise InvalidInput(
            f"{name} = {text!r}: decimals are written with a point, as in {stripped.replace(',', '.')!r}"
        )
    raised = stripped[number.end() :].strip().translate(SUPERSCRIPTS).replace("**", "^")
    written = TORQUE.sub(_torque_product, BARE_POWER.sub(r"^\1", PRODUCT_DOT.sub("*", raised)))
    if not written:
        check_bare_angle(name, float(number.group()), unit)
        return float(number.group())
    if unit in ROTATION_UNITS:
        written = RPM_SPELLINGS.get(written, written)
        if re.search(r"\b[kM]?Hz\b|hertz", written) or PER_TIME.fullmatch(written):
            raise InvalidInput(f"{name} = {text!r}: {raised} may mean turns or radians; give {ROTATION_UNITS[unit]}")
    if not UNIT.fullmatch(written):
        raise _unknown_unit_error(name, text, written, unit)
    return _convert(name, text, float(number.group()), written, unit)


def _torque_product(torque: re.Match[str]) -> str:
    """Write a torque, or a torque times a second, as a product: kN*m for kNm."""
    prefix, length, second = torque.groups()
    return f"{prefix}N*{length}{'*s' if second else ''}"


def check_bare_angle(name: str, value: float, unit: str) -> None:
    """Refuse an angle of more than one turn without unit, as degrees were probably meant.

    Raises:
        InvalidInput: says how both are written.
    """
    if unit == "rad" and abs(value) > REVOLUTION:
        raise InvalidInput(
            f"{name} = {value:g} has no unit and would be radians, {math.degrees(value):.0f} deg: write "
            f"{value:g}deg if degrees are meant, {value:g}rad if not"
        )


def _convert(name: str, text: str, value: float, written: str, unit: str) -> float:
    """Convert a value in a parsed unit to an SI unit."""
    if written == unit:
        return value  # as pint gives it, which takes a quarter of a second to read its units
    if (written, unit) in FACTORS:
        return value * FACTORS[written, unit]
    import pint

    registry = _unit_registry()
    try:
        wanted = registry.parse_units(written.replace("·", "*"))
        return float(registry.Quantity(value, wanted).to(unit or "dimensionless").magnitude)
    except pint.DimensionalityError:
        raise InvalidInput(
            f"{name} = {text!r}: {written!r} is not a unit of {unit_in_prose(unit) or 'a number'}"
            f"{_example_clause(unit)}"
        ) from None
    except (pint.PintError, AttributeError, AssertionError, TypeError, ValueError):
        raise _unknown_unit_error(name, text, written, unit) from None


def _unknown_unit_error(name: str, text: str, written: str, unit: str) -> InvalidInput:
    """Error for a unit that pint does not know."""
    return InvalidInput(f"{name} = {text!r}: unknown unit {written!r}{_example_clause(unit)}")


def _example_clause(unit: str) -> str:
    """Clause of an error message with examples of a quantity."""
    return f"; give for instance {UNIT_EXAMPLES[unit]}" if unit in UNIT_EXAMPLES else ""


def unit_in_prose(unit: str) -> str:
    """Spelling of a unit in prose and output: kg m² for kg*m^2."""
    return unit.replace("*", " ").replace("^2", "²").replace("^3", "³")


MIN_SHOWN_BOUND = 1e-100  # a bound below stands for "more than nothing"


def check_number(name: str, value: object, lowest: float, highest: float, unit: str = "") -> None:
    """Refuse a value that is not a finite number from `lowest` to `highest`.

    Raises:
        InvalidInput: names the value and the range.
    """
    suffix = f" {unit_in_prose(unit)}" if unit else ""
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not math.isfinite(value):
        raise InvalidInput(f"{name} = {value!r} is not a finite number")
    if not lowest <= value <= highest:
        above = "0 <" if 0.0 < lowest < MIN_SHOWN_BOUND else f"{lowest:g} <="
        raise InvalidInput(f"{name} = {value:g}{suffix} is out of range: {above} {name} <= {highest:g}{suffix}")


def check_count(name: str, value: object, lowest: int, highest: int) -> None:
    """Refuse a value that is not a whole number from `lowest` to `highest`.

    Raises:
        InvalidInput: names the value and the range.
    """
    if isinstance(value, bool) or not isinstance(value, int):
        raise InvalidInput(f"{name} = {value!r} is not a whole number")
    if not lowest <= value <= highest:
        raise InvalidInput(f"{name} = {value} is out of range: {lowest} <= {name} <= {highest}")


# -- parameters --------------------------------------------------------------------------------------------------------

MAX_PROPORTION = 1e4


@dataclass(frozen=True)
class Parameter:
    """Unit, range and meaning of one parameter of a scene."""

    unit: str  # SI: m, rad/s, kg, kg*m^2, m/s^2 or empty
    lowest: float
    highest: float
    magnitude: bool = False  # the range holds for the absolute value: both signs are allowed
    meaning: str = ""
    name: str = ""

    def check(self, value: float) -> None:
        """Refuse a value that is not a finite number within the range.

        Raises:
            InvalidInput: names the parameter, its value and its range; of text, how to give it with its unit.
        """
        if isinstance(value, str):
            unit = f" of {unit_in_prose(self.unit)}" if self.unit else ""
            given = f"{self.name} = {value!r} is not a finite number{unit}"
            raise InvalidInput(f"{given}; conrod.scene(NAME, ..) takes text with units")
        check_number(self.name, value, -self.highest if self.magnitude else self.lowest, self.highest, self.unit)
        if self.magnitude and abs(value) < self.lowest:
            raise InvalidInput(
                f"{self.name} = {value:g} {self.unit} is out of range: "
                f"{self.lowest:g} <= |{self.name}| <= {self.highest:g} {self.unit}"
            )


def _parameter_field(unit: str, lowest: float, highest: float, magnitude: bool = False) -> Callable[[float, str], Any]:
    """Return a function that declares a parameter of this unit and range, given default and meaning."""

    def field(default: float, meaning: str) -> Any:
        parameter = Parameter(unit, lowest, highest, magnitude, meaning)
        return dataclasses.field(default=default, metadata={"parameter": parameter})

    return field


length = _parameter_field("m", 1e-6, 1e6)
offset = _parameter_field("m", 0.0, 1e6, magnitude=True)  # a length that may be zero or negative
mass = _parameter_field("kg", 1e-6, 1e9)
inertia = _parameter_field("kg*m^2", 1e-12, 1e9)  # about the centre of gravity
gravity = _parameter_field("m/s^2", 0.0, 1e5)  # acceleration of free fall; zero switches it off
factor = _parameter_field("", 0.0, 1e6)


def speed(default: float) -> Any:
    """Declare the crank speed [rad/s] of a scene."""
    return _parameter_field("rad/s", 1e-6, 1e6, magnitude=True)(
        default, "crank speed; negative is the other sense of rotation"
    )


def parameters_of(scene_class: type) -> dict[str, Parameter]:
    """Parameters of a scene class, in order of declaration."""
    fields = [field for field in dataclasses.fields(scene_class) if "parameter" in field.metadata]
    return {field.name: dataclasses.replace(field.metadata["parameter"], name=field.name) for field in fields}


def check_proportion(long_name: str, long: float, short_name: str, short: float) -> None:
    """Refuse lengths so unequal that rounding leaves the motion too few digits.

    Raises:
        InvalidInput: names both, and the largest proportion.
    """
    if long > MAX_PROPORTION * short:
        raise InvalidInput(
            f"{long_name} = {long:g} m is out of proportion: at most {MAX_PROPORTION:g} x {short_name} "
            f"= {MAX_PROPORTION * short:g} m"
        )
