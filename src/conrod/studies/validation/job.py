"""One result that a validation asks for, to be had in any process."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from conrod.engines import Engine, engine_named
from conrod.runs.trajectory import Outcome
from conrod.scenes import Scene
from conrod.studies.validation.kinematic_proof import validate_kinematic
from conrod.studies.validation.plan import Plan, validate_dynamic
from conrod.studies.validation.results import Result, result_of


@dataclass(frozen=True)
class Job:
    """A scene in an engine, in kinematic mode where no preset is named.

    Attributes:
        name: of the scene, for people.
    """

    name: str
    scene: Scene = field(repr=False)
    engine: str
    preset: str | None
    plan: Plan

    @property
    def label(self) -> str:
        """What is under way, for people."""
        return f"{self.name} {self.engine} {self.preset or 'kinematic'}"

    @property
    def steps(self) -> int:
        """Steps per revolution, which say about how long it takes."""
        return self.plan.steps(self.scene)

    def run(self) -> Result:
        """The result."""
        engine = engine_named(self.engine)
        if self.preset is None:
            return validate_kinematic(self.name, self.scene, engine)
        return validate_dynamic(self.name, self.scene, engine, self.preset, self.plan)

    def ended(self, outcome: Outcome, reason: str) -> Result:
        """The result where the process that ran it did not live to give one."""
        engine, steps, turns = engine_named(self.engine), self.steps, self.plan.revolutions
        judged = self.preset is None or engine.presets[self.preset].judged or bool(self.plan.tolerance)
        if self.preset is None:
            found = result_of(self.name, self.scene, engine, "kinematic", outcome=outcome, reason=reason, revolutions=1)
        else:
            found = result_of(
                self.name,
                self.scene,
                engine,
                "dynamic",
                preset=self.preset,
                steps=steps,
                revolutions=turns,
                outcome=outcome,
                reason=reason,
            )
        return replace(found, passed=False if judged else None)


def jobs_of(
    scenes: Mapping[str, Scene], engines: Sequence[Engine[Any]], presets: Mapping[str, tuple[str, ...]], plan: Plan
) -> list[Job]:
    """All jobs of a validation: scene by scene, engine by engine, kinematic mode first, then each preset.

    Args:
        presets: to run, by engine name.
    """
    return [
        Job(name, scene, engine.name, preset, plan)
        for name, scene in scenes.items()
        for engine in engines
        for preset in (None, *presets[engine.name])
    ]
