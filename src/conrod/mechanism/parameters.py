"""Parameters of a scene: a default, a unit and the range that conrod accepts."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from conrod.errors import InvalidInput
from conrod.mechanism.units import check_number

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
