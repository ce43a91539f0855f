"""The unit of length in which one and the same machine is given to an engine."""

from __future__ import annotations

import math
from typing import ClassVar

from conrod.scenes import Scene
from conrod.studies.limits.axis import Axis, Scale
from conrod.studies.limits.case import Case
from conrod.studies.limits.cell import LimitCell

WITH_A_METRE = ("m", "N")  # a newton is one kilogram metre over a square second
UNITS = {-3: "km", 0: "m", 2: "cm", 3: "mm"}


class LengthUnit(Axis):
    """Every length a number so many times as large; what an engine holds to be a metre shows in the errors.

    An exact motion has no unit, and neither have rules of presets that are in steps. Widths, slops and tolerances that
    an engine states as lengths have one.
    """

    name: ClassVar[str] = "length-unit"
    title: ClassVar[str] = "Unit of length"
    label: ClassVar[str] = "numbers of all lengths over those in metres"
    scale: ClassVar[Scale] = Scale.LOG
    harmless: ClassVar[float] = 1.0
    hopeless: ClassVar[float] = 1e3
    allowed: ClassVar[tuple[float, float]] = (1e-3, 1e3)

    def refusal(self, case: Case) -> str | None:
        return None

    def spans(self, case: Case) -> tuple[tuple[float, float], ...]:
        return ((self.harmless, self.hopeless), (self.harmless, 1.0 / self.hopeless))

    def cell(self, case: Case, value: float) -> LimitCell:
        scene = case.variant(**rescaled(case.scene, value))
        return LimitCell(case.name, scene, case.settings(scene))

    def text(self, case: Case, value: float) -> str:
        decades = math.log10(value)
        unit = UNITS.get(round(decades)) if abs(decades - round(decades)) < 1e-9 else None
        return f"x {value:.4g}" + (f" (in {unit})" if unit else "")


def rescaled(scene: Scene, factor: float) -> dict[str, float]:
    """The parameters of a scene whose unit of length is so many times smaller; masses and times keep theirs."""
    facts = scene.parameter_facts()
    return {name: value * factor ** length_power(facts[name].unit) for name, value in scene.parameters.items()}


def length_power(unit: str) -> int:
    """The power of metre in a unit such as kg*m^2 or m/s^2."""
    power = 0
    for sign, product in zip((1, -1, -1), unit.split("/"), strict=False):
        for name, _, exponent in (term.partition("^") for term in product.split("*")):
            power += sign * int(exponent or 1) if name in WITH_A_METRE else 0
    return power
