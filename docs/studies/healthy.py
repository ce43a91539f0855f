"""Healthy runs that a verdict must let pass: machines with other parameters, starts, speeds and steps."""

from __future__ import annotations

import math
import random
from dataclasses import dataclass, replace
from typing import Any, ClassVar

from conrod.comparison.run_errors import LinkSizes, RunErrors
from conrod.comparison.trajectory import Outcome
from conrod.engines.engine import run_extent
from conrod.engines.run import run_with_recorders
from conrod.errors import InvalidInput
from conrod.execution.result import JudgedCase, Plan
from conrod.scenes import Scene
from conrod.studies.validation.dynamic_mode import prepare_run
from conrod.studies.validation.results import ValidationResult, empty_result

PARAMETERS, SPEEDS = 0.2, math.log(5.0)  # largest change of a parameter, of the logarithm of the speed
STEPS, CONTACT_STEPS = (100, 2000), (2000, 6000)  # of linkages; of a machine with a cam
TRIES = 100


@dataclass(frozen=True)
class VariantCase(JudgedCase[ValidationResult]):
    """One turn of a healthy machine, or its one pass, judged as `conrod validate` does."""

    study: ClassVar[str] = "variant"
    result_type: ClassVar[type[Any]] = ValidationResult

    plan: Plan
    start_angle: float

    def empty_result(self) -> ValidationResult:
        return empty_result(self.name, self.scene, self.loaded_engine, self.preset, self.plan)

    def failed_result(self, outcome: Outcome, reason: str) -> ValidationResult:
        return replace(self.empty_result(), outcome=outcome.slug, reason=reason, passed=False)

    def run_fields(self) -> dict[str, Any]:
        settings = self.loaded_engine.presets[str(self.preset)](self.scene, self.plan.steps(self.scene)).as_dict()
        return {"settings": settings, "start_angle": self.start_angle}

    def perform(self) -> ValidationResult:
        result, settings, start = prepare_run(
            self.name, self.scene, self.loaded_engine, str(self.preset), self.plan, self.start_angle
        )
        if not result.completed or not result.limits:
            return result
        errors, links = RunErrors(), LinkSizes()
        ended = run_with_recorders(self.loaded_engine, self.scene, settings, result.revolutions, start, errors, links)
        found = {"links": links.errors, **errors.as_dict()} if ended.outcome is Outcome.COMPLETED else {}
        return replace(result, outcome=ended.outcome.slug, reason=ended.reason, **found).with_verdict()


def variant(scene: Scene, number: int) -> tuple[Scene, int, float]:
    """A healthy machine of a scene, its steps per revolution and start angle [rad]; the same for the same number.

    Raises:
        InvalidInput: no parameters near the scene's own are those of a machine.
    """
    chance = random.Random(number)
    contact = bool(scene.mechanism().cam_contacts)
    # Where nothing else fits together, as gears whose radii tell where they are, the parameters stay.
    for largest in [PARAMETERS] * TRIES + [0.0]:
        changed = {name: value * (1.0 + chance.uniform(-largest, largest)) for name, value in scene.parameters.items()}
        speed = scene.speed * math.exp(chance.uniform(-SPEEDS, 0.0 if contact else SPEEDS))
        changed["speed"] = speed if contact else speed * chance.choice((-1.0, 1.0))
        steps = round(math.exp(chance.uniform(*map(math.log, CONTACT_STEPS if contact else STEPS))))
        start = 0.0 if contact else chance.uniform(0.0, 2.0 * math.pi)
        try:
            made = scene.with_parameters(**changed)
            run_extent(made, steps, 1.0)
            _ = made.lengths, made.kinematics.lengths
        except InvalidInput:
            continue
        return made, steps, start
    raise InvalidInput(f"{scene.kind}: no machine with other parameters was found")
