"""What a validation of free motion asks for, to be had in any process: first the exact motions, then the engines'."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from conrod.engines import Engine, engine_named
from conrod.errors import InvalidInput
from conrod.scenes import Scene
from conrod.studies.free_motion.exact import ExactCourse, crank_angle, exact_course
from conrod.studies.free_motion.perform import run_motion
from conrod.studies.free_motion.plan import FREE, MotionPlan, drives
from conrod.studies.free_motion.results import ExactTold, MotionResult, MotionStudy
from conrod.trajectory import Outcome


@dataclass(frozen=True)
class ExactJob:
    """The exact motion of a scene."""

    name: str
    scene: Scene = field(repr=False)
    plan: MotionPlan

    @property
    def label(self) -> str:
        """What is under way, for people."""
        return f"{self.name} exact"

    @property
    def steps(self) -> int:
        """About how long it takes, against others."""
        return len(self.scene.kinematics.mechanism.bodies)

    def run(self) -> ExactCourse:
        """The motion; raises InvalidInput as `exact_course`."""
        return exact_course(self.name, self.scene, self.plan)

    def ended(self, outcome: Outcome, reason: str) -> ExactCourse:
        """There is nothing to compare with.

        Raises:
            InvalidInput: always.
        """
        raise InvalidInput(f"{self.name}: the exact motion could not be had: {outcome.slug}: {reason}")


@dataclass(frozen=True)
class MotionJob:
    """A scene in an engine with a preset."""

    name: str
    course: ExactCourse = field(repr=False)
    engine: str
    preset: str
    plan: MotionPlan

    @property
    def label(self) -> str:
        """What is under way, for people."""
        return f"{self.name} {self.engine} {self.preset}"

    @property
    def steps(self) -> int:
        """About how long it takes, against others."""
        return self.course.grid.steps * len(self.course.mechanism.bodies)

    def run(self) -> MotionResult:
        """The result."""
        return run_motion(self.name, self.course, engine_named(self.engine), self.preset, self.plan)

    def ended(self, outcome: Outcome, reason: str) -> MotionResult:
        """The result where the process that ran it did not live to give one."""
        engine, grid = engine_named(self.engine), self.course.grid
        return MotionResult(
            self.name, self.plan.motion, self.engine, engine.version, self.preset, grid.step,
            float(self.course.motion.times[-1]), outcome.slug, reason, self.plan.leaving,
            self.plan.judged_by(self.preset),
        )  # fmt: skip


def motion_jobs(
    courses: Mapping[str, ExactCourse],
    engines: Sequence[Engine[Any]],
    presets: Mapping[str, tuple[str, ...]],
    plan: MotionPlan,
) -> list[MotionJob]:
    """Scene by scene, engine by engine, each preset of those to run, by engine name."""
    return [
        MotionJob(name, course, engine.name, preset, plan)
        for name, course in courses.items()
        for engine in engines
        for preset in presets[engine.name]
    ]


def motion_study(
    name: str, scene: Scene, course: ExactCourse, plan: MotionPlan, results: Sequence[MotionResult]
) -> MotionStudy:
    """All that was found of a scene."""
    mechanism, motion = scene.kinematics.mechanism, course.motion
    left_out = tuple(load.name for load in mechanism.loads if plan.motion == FREE and drives(load, mechanism))
    told = ExactTold(motion.drift, motion.continuation, motion.times, crank_angle(mechanism, motion.poses))
    return MotionStudy(name, scene, plan.motion, left_out, told, tuple(results))
