"""`validate`: scenes in engines at constant crank speed, in kinematic mode and with each preset."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar

from conrod.engines import Engine
from conrod.engines.engine import default_steps, judged_preset
from conrod.runs.comparison import QUANTITIES as COMPARED
from conrod.runs.trajectory import Outcome
from conrod.scenes import Scene
from conrod.studies.frame.case import Study
from conrod.studies.frame.result import EngineCase, refinement_path, results_of
from conrod.studies.validation.kinematic_proof import validate_kinematic
from conrod.studies.validation.plan import Plan, started, validate_dynamic
from conrod.studies.validation.results import SceneStudy, ValidationResult


@dataclass(frozen=True)
class ValidationCase(EngineCase[ValidationResult]):
    """A scene in an engine with a preset and along its refinement path; in kinematic mode where there is no preset."""

    study: ClassVar[str] = "validate"
    kind: ClassVar[type[Any]] = ValidationResult
    quantities: ClassVar[tuple[str, ...]] = COMPARED
    version: ClassVar[int] = 2  # since the clock is judged

    plan: Plan

    @property
    def effort(self) -> float:
        return self.plan.steps(self.scene)

    def run(self) -> ValidationResult:
        if self.preset is None:
            return validate_kinematic(self.name, self.scene, self.made_by)
        return validate_dynamic(self.name, self.scene, self.made_by, self.preset, self.plan)

    @property
    def tolerance(self) -> Mapping[str, float] | None:
        return None if self.preset is None else self.plan.tolerance

    def ended(self, outcome: Outcome, reason: str) -> ValidationResult:
        required = self.preset is None or self.made_by.presets[self.preset].judged or bool(self.plan.tolerance)
        found = started(self.name, self.scene, self.made_by, self.preset, self.plan)
        return replace(found, outcome=outcome.slug, reason=reason, passed=False if required else None)

    def determined_by(self) -> dict[str, Any]:
        preset, steps, turns = judged_preset(self.made_by), default_steps(self.scene), 1.0
        path: tuple[int, ...] = ()
        if self.preset is not None:
            preset, steps, turns = self.preset, self.plan.steps(self.scene), self.plan.revolutions
            path = refinement_path(self.scene, steps)
        settings = [self.made_by.presets[preset](self.scene, n).as_dict() for n in (steps, *path)]
        return {"settings": settings[0], "refined": settings[1:], "revolutions": turns, "start_angle": 0.0}


def validation_cases(
    scenes: Mapping[str, Scene], engines: Sequence[Engine[Any]], presets: Mapping[str, Sequence[str]], plan: Plan
) -> list[ValidationCase]:
    """Scene by scene, engine by engine: kinematic mode, then each preset.

    Args:
        presets: to run, by engine name.
    """
    return [
        ValidationCase(name, scene, engine.name, preset, plan)
        for name, scene in scenes.items()
        for engine in engines
        for preset in (None, *presets[engine.name])
    ]


def validation(
    scenes: Mapping[str, Scene], engines: Sequence[Engine[Any]], presets: Mapping[str, Sequence[str]], plan: Plan
) -> Study[list[SceneStudy]]:
    """The study of some scenes: one round of cases; arguments as of `validation_cases`."""
    found = yield from results_of(validation_cases(scenes, engines, presets, plan))
    return [SceneStudy(name, scene, found[name]) for name, scene in scenes.items()]
