"""Errors worth meeting: usable, what engines reach by their own laws, and rounding."""

from __future__ import annotations

from dataclasses import dataclass

from conrod.engines import ENGINES, engine_named
from conrod.engines.engine import default_steps
from conrod.report.numbers import ROUNDING
from conrod.scenes import Scene
from conrod.studies.limits.grade import SAFE_ERROR


@dataclass(frozen=True)
class Tolerance:
    """Errors worth meeting, normalised; None where the max norm says nothing.

    Attributes:
        meaning: who meets them, or what they are good for.
        law: where they come from.
    """

    position: float
    velocity: float | None
    acceleration: float | None
    meaning: str
    law: str


def worth_meeting(scene: Scene) -> list[Tolerance]:
    """Tolerances, the loosest first: what is usable, what engines reach by their own laws, and rounding."""
    found = [Tolerance(SAFE_ERROR, None, None, "usable: what conrod calls safe", "by definition")]
    steps = default_steps(scene)
    for engine in map(engine_named, ENGINES):
        for preset, rule in engine.presets.items():
            settings = rule(scene, steps)
            law = None if engine.refusal(scene, settings) else engine.expected_error(scene, settings)
            if law is not None and law.position is not None:
                meaning = f"as good as {engine.name}, preset {preset}, at {steps} steps a revolution"
                found.append(Tolerance(law.position, law.velocity, law.acceleration, meaning, law.law))
    found.append(Tolerance(ROUNDING, None, None, "rounding: a solver of the kinematics", "double precision"))
    return sorted(found, key=lambda one: -one.position)
