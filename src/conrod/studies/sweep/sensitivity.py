"""Sensitivity of soft settings: the mass of the output link, and gravity.

The exact motion of a linkage with a driven crank depends on no mass and no gravity (docs/design.md, guard 5). What an
engine's motion depends on of these is softness. The settings stay as they are, whatever a preset would make of the
other masses; the flywheel stays too, and the ripple of the drive is printed to show that it is ample.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from conrod.engines import engine_named
from conrod.engines.capabilities import Lacking, Varied, capability
from conrod.errors import InvalidInput
from conrod.runs.trajectory import Settings
from conrod.scenes import Scene
from conrod.studies.frame.measurement import QUANTITIES, Measurement
from conrod.studies.frame.run import RunCase

BASE, GRAVITY = "as is", "gravity switched"
# The ends show whether it matters at all. Soft joints may not hold there: what lies between shows how it depends.
MASS_FACTORS = (0.01, 0.5, 2.0, 100.0)
DRIVE_KEPT = 1e-9  # ripple of the crank's speed, relative: a ripple is not softness


@dataclass(frozen=True)
class Variation:
    """One run with something else than the motion changed.

    Attributes:
        name: what was changed.
        value: of the parameter that was changed [kg], clipped to its range; None where it is not a parameter.
        errors: largest of each quantity, normalised; None unless the run completed.
        ratios: errors over those of the settings as they are; None where either is missing or that one is zero.
        drive: relative ripple of the crank's speed; None unless the run completed.
    """

    name: str
    value: float | None
    outcome: str
    errors: Mapping[str, float] | None
    ratios: Mapping[str, float | None]
    drive: float | None

    @property
    def drive_kept(self) -> bool | None:
        """True if the crank turned evenly enough for the errors to be the joints'; None unless the run completed."""
        return None if self.drive is None else self.drive <= DRIVE_KEPT


@dataclass(frozen=True)
class Sensitivity:
    """Dependence of one setting's errors on what the exact motion does not depend on.

    Attributes:
        parameter: name of the mass that was varied. A follower that a constant force holds down is held by a multiple
            of its mass, so that one moves alike at any mass.
        variations: the settings as they are first.
    """

    scene: str
    engine: str
    preset: str
    settings: Mapping[str, Any]
    parameter: str
    variations: tuple[Variation, ...]


def sensitivity_cases(name: str, scene: Scene, settings: Settings) -> dict[str, RunCase]:
    """The runs, by what they change; gravity only where the machine feels it and the engine can be without.

    Raises:
        InvalidInput: the output link's mass is no parameter, or the engine is not in the table.
    """
    parameter = output_mass(scene)
    cases = {BASE: RunCase(name, scene, settings)}
    for factor in MASS_FACTORS:
        value = varied_mass(scene, parameter, factor)
        cases[mass_label(parameter, factor)] = RunCase(name, scene.with_parameters(**{parameter: value}), settings)
    varied = capability(engine_named(settings.engine), Varied)
    if math.hypot(*scene.kinematics.mechanism.gravity) > 0.0 and not isinstance(varied, Lacking):
        cases[GRAVITY] = RunCase(name, scene, varied.variations.gravity_switched(settings))
    return cases


def sensitivity_of(name: str, scene: Scene, settings: Settings, measurements: Mapping[str, Measurement]) -> Sensitivity:
    """The result from the measurements of the cases.

    Raises:
        KeyError: a case has not been measured.
        InvalidInput: as `sensitivity_cases`.
    """
    parameter = output_mass(scene)
    cases = sensitivity_cases(name, scene, settings)
    base = measurements[cases[BASE].key]
    variations = []
    for label, case in cases.items():
        run = measurements[case.key]
        sizes = {q: (run.largest(q), base.largest(q)) for q in QUANTITIES}
        variations.append(
            Variation(
                name=label,
                value=None if case.scene is scene else case.scene.parameters[parameter],
                outcome=run.outcome,
                errors=None if run.errors is None else {q: size or 0.0 for q, (size, _) in sizes.items()},
                ratios={q: size / usual if size is not None and usual else None for q, (size, usual) in sizes.items()},
                drive=None if run.drive is None else run.drive["speed"],
            )
        )
    return Sensitivity(name, settings.engine, settings.preset, settings.as_dict(), parameter, tuple(variations))


def output_mass(scene: Scene) -> str:
    """The parameter that is the mass of the link which carries the scene's output point.

    It is found by what it does: of the parameters in kg, the one that moves this link's mass and no other's.

    Raises:
        InvalidInput: there is none.
    """
    mechanism = scene.mechanism()
    link = next(observed.body for observed in mechanism.observed if observed.name == scene.output)
    for parameter in (p for p in scene.parameter_facts().values() if p.unit == "kg"):
        value = scene.parameters[parameter.name]
        other = 0.5 * value if 2.0 * value > parameter.highest else 2.0 * value
        changed = scene.with_parameters(**{parameter.name: other}).mechanism()
        if [b.name for b in mechanism.bodies if changed.body(b.name).mass != b.mass] == [link]:
            return parameter.name
    raise InvalidInput(f"{scene.kind}: the mass of {link!r}, the link with the output point, is no parameter")


def varied_mass(scene: Scene, parameter: str, factor: float) -> float:
    """A mass [kg] times a factor, clipped to the range of the parameter."""
    facts = scene.parameter_facts()[parameter]
    return min(max(scene.parameters[parameter] * factor, facts.lowest), facts.highest)


def mass_label(parameter: str, factor: float) -> str:
    """Name of a variation of a mass."""
    return f"{parameter} x {factor:g}"
