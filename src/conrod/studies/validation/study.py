"""The cases of `conrod validate`: scenes in engines at constant speed, in kinematic and in dynamic mode."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar

from conrod.comparison.trajectory import Outcome
from conrod.engines import Engine
from conrod.engines.engine import judged_preset
from conrod.execution.case import Study
from conrod.execution.result import JudgedCase, Plan, presets_study
from conrod.execution.tolerances import Limit
from conrod.scenes import Scene
from conrod.studies.validation.results import SceneStudy, ValidationResult, empty_result


@dataclass(frozen=True)
class ValidationCase(JudgedCase[ValidationResult]):
    """Validation of a scene in an engine, with a preset or, if that is None, in kinematic mode."""

    study: ClassVar[str] = "validate"
    result_type: ClassVar[type[Any]] = ValidationResult

    plan: Plan

    def empty_result(self) -> ValidationResult:
        return empty_result(self.name, self.scene, self.loaded_engine, self.preset, self.plan)

    def perform(self) -> ValidationResult:
        # What makes runs is imported where they are made: not where all are in the ledger.
        if self.preset is None:
            from conrod.studies.validation.kinematic_mode import validate_kinematic

            return validate_kinematic(self.name, self.scene, self.loaded_engine)
        from conrod.studies.validation.dynamic_mode import validate_dynamic

        return validate_dynamic(self.name, self.scene, self.loaded_engine, self.preset, self.plan)

    @property
    def tolerance(self) -> Mapping[str, Limit] | None:
        return None if self.preset is None else super().tolerance

    def failed_result(self, outcome: Outcome, reason: str) -> ValidationResult:
        required = self.preset is None or self.loaded_engine.presets[self.preset].judged
        return replace(self.empty_result(), outcome=outcome.slug, reason=reason, passed=False if required else None)

    def run_fields(self) -> dict[str, Any]:
        """Plain values of the key: settings and revolutions of all runs; in kinematic mode of one revolution."""
        if self.preset is None:
            return Plan(None, 1.0).run_fields(
                self.scene, self.loaded_engine.presets[judged_preset(self.loaded_engine)], False
            )
        return self.plan.run_fields(self.scene, self.loaded_engine.presets[self.preset])


def validation_study(
    scenes: Mapping[str, Scene], engines: Sequence[Engine[Any]], presets: Mapping[str, Sequence[str]], plan: Plan
) -> Study[list[SceneStudy]]:
    """Study of scenes in kinematic mode and with each preset; arguments as for `presets_study`."""
    return presets_study(ValidationCase, scenes, engines, {name: (None, *some) for name, some in presets.items()}, plan)
