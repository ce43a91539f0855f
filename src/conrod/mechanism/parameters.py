"""Parameters of a scene: a default, a unit and the range that conrod accepts."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Any

from conrod.errors import InvalidInput
from conrod.mechanism.units import check_number

LARGEST_PROPORTION = 1e4


@dataclass(frozen=True)
class Parameter:
    """Unit, meaning and range of one parameter."""

    name: str
    unit: str  # SI: m, rad/s, kg, kg*m^2, m/s^2 or empty
    meaning: str
    lowest: float
    highest: float
    magnitude: bool = False  # the range holds for the absolute value: both signs are allowed


def length(default: float, meaning: str) -> Any:
    """A positive length [m]."""
    return _parameter(default, "m", meaning, 1e-6, 1e6)


def offset(default: float, meaning: str) -> Any:
    """A length [m] that may be zero or negative."""
    return _parameter(default, "m", meaning, 0.0, 1e6, magnitude=True)


def speed(default: float, meaning: str = "crank speed; negative is the other sense of rotation") -> Any:
    """A crank speed [rad/s], of either sign."""
    return _parameter(default, "rad/s", meaning, 1e-6, 1e6, magnitude=True)


def mass(default: float, meaning: str) -> Any:
    """A mass [kg]."""
    return _parameter(default, "kg", meaning, 1e-6, 1e9)


def inertia(default: float, meaning: str) -> Any:
    """A moment of inertia about the centre of gravity [kg m^2]."""
    return _parameter(default, "kg*m^2", meaning, 1e-12, 1e9)


def gravity(meaning: str) -> Any:
    """The acceleration of free fall [m/s^2]; zero switches it off."""
    return _parameter(9.81, "m/s^2", meaning, 0.0, 1e5)


def factor(default: float, meaning: str, lowest: float, highest: float) -> Any:
    """A number without a unit."""
    return _parameter(default, "", meaning, lowest, highest)


def _parameter(
    default: float, unit: str, meaning: str, lowest: float, highest: float, *, magnitude: bool = False
) -> Any:
    facts = {"unit": unit, "meaning": meaning, "lowest": lowest, "highest": highest, "magnitude": magnitude}
    return dataclasses.field(default=default, metadata=facts)


def parameters_of(scene_class: type) -> dict[str, Parameter]:
    """The parameters of a scene class, in order of declaration."""
    return {f.name: Parameter(f.name, **f.metadata) for f in dataclasses.fields(scene_class) if f.metadata}


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


def check_ranges(scene: Any) -> None:
    """Refuse values that are not finite numbers within their range.

    Raises:
        InvalidInput: names the parameter, its value and its range.
    """
    for parameter in parameters_of(type(scene)).values():
        check_value(parameter, getattr(scene, parameter.name))


def check_value(parameter: Parameter, value: float) -> None:
    """Refuse a value that is not a finite number within the parameter's range.

    Raises:
        InvalidInput: names the parameter, its value and its range.
    """
    lowest = -parameter.highest if parameter.magnitude else parameter.lowest
    check_number(parameter.name, value, lowest, parameter.highest, parameter.unit)
    if parameter.magnitude and abs(value) < parameter.lowest:
        raise InvalidInput(
            f"{parameter.name} = {value:g} {parameter.unit} is out of range: "
            f"{parameter.lowest:g} <= |{parameter.name}| <= {parameter.highest:g} {parameter.unit}"
        )
