"""One result that a validation of forces asks for, to be had in any process."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from conrod.engines import Engine, engine_named
from conrod.scenes import Scene
from conrod.studies.forces.results import ForceResult
from conrod.studies.forces.study import ForcePlan, started, validate_forces
from conrod.trajectory import Outcome


@dataclass(frozen=True)
class ForceJob:
    """A scene in an engine with a preset.

    Attributes:
        name: of the scene, for people.
    """

    name: str
    scene: Scene = field(repr=False)
    engine: str
    preset: str
    plan: ForcePlan

    @property
    def label(self) -> str:
        """What is under way, for people."""
        return f"{self.name} {self.engine} {self.preset}"

    @property
    def steps(self) -> int:
        """Steps per revolution, which say about how long it takes."""
        return self.plan.run.steps(self.scene)

    def run(self) -> ForceResult:
        """The result."""
        return validate_forces(self.name, self.scene, engine_named(self.engine), self.preset, self.plan)

    def ended(self, outcome: Outcome, reason: str) -> ForceResult:
        """The result where the process that ran it did not live to give one."""
        result = started(self.name, self.scene, engine_named(self.engine), self.preset, self.plan)
        return replace(result, outcome=outcome.slug, reason=reason, passed=False if result.tolerance else None)


def force_jobs(
    scenes: Mapping[str, Scene], engines: Sequence[Engine[Any]], presets: Mapping[str, tuple[str, ...]], plan: ForcePlan
) -> list[ForceJob]:
    """All jobs: scene by scene, engine by engine, each preset."""
    return [
        ForceJob(name, scene, engine.name, preset, plan)
        for name, scene in scenes.items()
        for engine in engines
        for preset in presets[engine.name]
    ]
