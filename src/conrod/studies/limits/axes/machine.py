"""Mass of the output link over that of the rod that drives it.

The unit of length in which one and the same machine is given to an engine.

Crank speed at a fixed step.

Revolutions in one run.
"""

from __future__ import annotations

import math
from typing import ClassVar

from conrod.errors import InvalidInput
from conrod.mechanism.mechanism import GROUND, Mechanism, Revolute
from conrod.scenes import Scene
from conrod.studies.limits.axis import Axis, Scale
from conrod.studies.limits.case import Case
from conrod.studies.limits.cell import LimitCell
from conrod.studies.sweep.sensitivity import output_mass


class MassRatio(Axis):
    """Equal masses are harmless; a heavy slider and a light one are two ways into trouble.

    The exact motion depends on no mass. The rod keeps its mass; a preset's rule sees the new ones.
    """

    name: ClassVar[str] = "mass-ratio"
    title: ClassVar[str] = "Mass of the slider over that of the rod"
    label: ClassVar[str] = "mass of slider : rod"
    scale: ClassVar[Scale] = Scale.LOG
    harmless: ClassVar[float] = 1.0
    hopeless: ClassVar[float] = 1e6
    allowed: ClassVar[tuple[float, float]] = (1e-6, 1e6)

    def refusal(self, case: Case) -> str | None:
        if _driving_rod(case.scene) is None:
            return f"the {case.scene.kind} has no connecting rod: {self.name} does not apply"
        try:
            output_mass(case.scene)
        except InvalidInput as unfit:
            return str(unfit)
        return None

    def spans(self, case: Case) -> tuple[tuple[float, float], ...]:
        return ((self.harmless, self.hopeless), (self.harmless, 1.0 / self.hopeless))

    def cell(self, case: Case, value: float) -> LimitCell:
        rod = _driving_rod(case.scene)
        assert rod is not None
        mass = value * case.scene.kinematics.mechanism.body(rod).mass
        scene = case.variant(**{output_mass(case.scene): mass})
        return LimitCell(case.name, scene, case.settings(scene))


def _driving_rod(scene: Scene) -> str | None:
    """The link that is pinned to the one with the output point, and is neither crank nor ground."""
    mechanism = scene.kinematics.mechanism
    link = next(observed.body for observed in mechanism.observed if observed.name == scene.output)
    return next((name for name in _partners(mechanism, link) if name not in (GROUND, mechanism.crank)), None)


def _partners(mechanism: Mechanism, link: str) -> list[str]:
    pins = [joint for joint in mechanism.joints if isinstance(joint, Revolute) and link in (joint.a, joint.b)]
    return [joint.b if joint.a == link else joint.a for joint in pins]


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


STEP = 0.6e-3  # [s]; divides the revolutions of 1 rpm and of 50000 rpm, into a hundred thousand and into two
STEPS_AT_ONE_RPM = 60.0 / STEP


class CrankSpeed(Axis):
    """The same machine, the same step [s], another speed.

    A revolution has a whole number of steps, so only speeds that make it so exist: 100000 rpm over 2, 3, 4 .. The sense
    of rotation stays. A cam's preload stays the multiple that it is: how one lets go of its cam is another axis.
    """

    name: ClassVar[str] = "speed"
    title: ClassVar[str] = "Crank speed at a fixed step of 0.6 ms"
    label: ClassVar[str] = "crank speed (rpm)"
    scale: ClassVar[Scale] = Scale.LOG
    harmless: ClassVar[float] = 1.0
    hopeless: ClassVar[float] = 50000.0
    allowed: ClassVar[tuple[float, float]] = (1.0, 50000.0)

    def refusal(self, case: Case) -> str | None:
        return None

    def spans(self, case: Case) -> tuple[tuple[float, float], ...]:
        return ((self.harmless, min(self.hopeless, STEPS_AT_ONE_RPM / case.fewest_steps)),)

    def cell(self, case: Case, value: float) -> LimitCell:
        steps = _steps(value)
        speed = 2.0 * math.pi / (steps * STEP)
        scene = case.variant(speed=math.copysign(speed, case.scene.speed))
        return LimitCell(case.name, scene, case.settings(scene, steps))

    def nearest(self, value: float) -> float:
        return STEPS_AT_ONE_RPM / _steps(value)

    def text(self, case: Case, value: float) -> str:
        return f"{self.nearest(value):.4g} rpm ({_steps(value)} steps)"


def _steps(rpm: float) -> int:
    return max(2, round(STEPS_AT_ONE_RPM / rpm))


# So few that very many revolutions are affordable, and so many that the tuned presets are still within a hundredth: of
# the linkages' travel 7e-6 to 5e-3 over a thousand revolutions, of the cam's 4e-3 and 5e-3 over ten.
LINKAGE_STEPS, CONTACT_STEPS = 50, 1000


class RunLength(Axis):
    """One run, by the preset's rule at few steps per revolution.

    The usual end is what an ordinary study affords; `allowed` is how far a range may reach.
    """

    name: ClassVar[str] = "run-length"
    title: ClassVar[str] = "Length of the run"
    label: ClassVar[str] = "revolutions"
    scale: ClassVar[Scale] = Scale.COUNT
    harmless: ClassVar[float] = 1.0
    hopeless: ClassVar[float] = 1000.0
    allowed: ClassVar[tuple[float, float]] = (1.0, 1e6)

    def refusal(self, case: Case) -> str | None:
        if case.one_pass:
            return f"the input of {case.scene.kind} makes one pass and no more: {self.name} does not apply"
        return None

    def cell(self, case: Case, value: float) -> LimitCell:
        steps = CONTACT_STEPS if case.contact else LINKAGE_STEPS
        return LimitCell(case.name, case.scene, case.settings(steps=steps), revolutions=float(round(value)))

    def text(self, case: Case, value: float) -> str:
        return f"{round(value)} revolutions" if value > 1.0 else "1 revolution"
