"""The result of a scene in an engine with a preset, and the cases of a validation, which have one."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar, Generic, Self, TypeVar

from conrod.engines import Engine, engine_named
from conrod.engines.engine import run_extent
from conrod.runs.plain_values import plain_values, restore
from conrod.runs.trajectory import Outcome
from conrod.scenes import Scene
from conrod.studies.frame.case import MEASURES, RESULT_VERSION, Case, Measurement, Study
from conrod.studies.frame.prediction import POINTS
from conrod.studies.frame.run import LEAST_STEPS

AS_ASKED = "as asked for"
# Refinement path: everything a preset states in steps or periods follows the step; nothing else changes.
LINKAGE_PATH, CONTACT_PATH = (8, 4, 2, 1), (16, 8, 4, 2)
# Of a result, those that have a column of their own in a table of many results.
COLUMNS = ("closure", "phase", "drive", "prediction")


@dataclass(frozen=True, kw_only=True)
class Result(ABC):
    """Result of one scene in an engine with a preset: errors and orders of a completed run alone, and a verdict.

    Attributes:
        preset: None of kinematic mode.
        order: observed, by quantity.
        passed: the verdict; None where nothing is judged.
    """

    scene: str
    engine: str
    engine_version: str
    preset: str | None
    outcome: str = Outcome.COMPLETED.slug
    reason: str = ""
    order: Mapping[str, float | None] | None = None
    passed: bool | None = None

    @property
    def completed(self) -> bool:
        """True if the run came to its end."""
        return self.outcome == Outcome.COMPLETED.slug

    @property
    @abstractmethod
    def limits(self) -> Mapping[str, float]:
        """Allowed errors, by the names of tolerances; empty where nothing is judged."""

    @property
    def distrust(self) -> str:
        """Why conrod's own figures cannot be trusted, in words; empty where nothing speaks against them."""
        return ""

    def faults(self) -> list[str]:
        """Reasons that fail it besides errors out of tolerance, in words."""
        return []

    @abstractmethod
    def largest(self, quantity: str, measure: str = "max") -> float | None:
        """Largest error of a quantity; None where there is none."""

    def judged_error(self, name: str) -> float | None:
        """The error that a tolerance of this name is compared with."""
        return self.largest(name)

    def exceeded(self) -> dict[str, tuple[float | None, float]]:
        """Judged quantities that are out of tolerance: what was found (None: nothing) and what is allowed."""
        pairs = {name: (self.judged_error(name), allowed) for name, allowed in self.limits.items()}
        return {name: pair for name, pair in pairs.items() if pair[0] is None or not pair[0] <= pair[1]}

    def judged(self, asked: Mapping[str, float] | None = None) -> Self:
        """The result with the verdict.

        Args:
            asked: tolerances that take the place of its own; whoever gives them is judged by these alone.
        """
        if self.outcome == Outcome.UNSUPPORTED.slug:
            return self
        result = self if asked is None else self._held_to(asked)
        if self.distrust:
            return replace(result, passed=False)
        passed = result.completed and not result.exceeded() and not (asked is None and result.faults())
        return replace(result, passed=passed if result.limits else None)

    @abstractmethod
    def _held_to(self, asked: Mapping[str, float]) -> Self:
        """The result with other tolerances."""


Found = TypeVar("Found", bound=Result)
Point = TypeVar("Point")


@dataclass(frozen=True)
class SceneResults(Generic[Found]):
    """All results of one scene."""

    name: str
    scene: Scene
    results: tuple[Found, ...]

    @property
    def passed(self) -> bool:
        """No judged result is out of tolerance."""
        return all(result.passed is not False for result in self.results)


def contradictions(misfit: Mapping[str, Mapping[str, float]]) -> dict[str, Mapping[str, float]]:
    """Return the quantities whose measured errors the joints' gaps do not explain."""
    return {name: found for name, found in misfit.items() if not found["difference"] <= found["allowed"]}


def misfit_words(misfit: Mapping[str, Mapping[str, float]]) -> str:
    """Say what contradicts the exact motion; empty where nothing does."""
    wrong = contradictions(misfit)
    if any(name.startswith(POINTS) for name in wrong):
        apart = max(one["difference"] for name, one in wrong.items() if name.startswith(POINTS))
        return f"the measured points are not those of the bodies whose joints predict their errors, by {apart:.2g}"
    if not wrong:
        return ""
    quantity = max(wrong, key=lambda name: wrong[name]["difference"] / wrong[name]["allowed"])
    worst, others = wrong[quantity], [name for name in wrong if name != quantity]
    too = f" ({' and '.join(others)} too)" if others else ""
    return (
        f"the exact motion contradicts the joints' equations: {quantity} by {worst['difference']:.2g} at crank angle "
        f"{math.degrees(worst['angle']):.6g} deg, where {worst['allowed']:.2g} can be explained{too}"
    )


def refinement_path(scene: Scene, steps: int) -> tuple[int, ...]:
    """Steps per revolution at which the order is observed."""
    divisors = CONTACT_PATH if scene.kinematics.mechanism.cam_contacts else LINKAGE_PATH
    return tuple(dict.fromkeys(max(2, round(steps / d)) for d in divisors))


def refine(
    scene: Scene, steps: int, revolutions: float, finest: Point, run: Callable[[int, float, float], Point]
) -> tuple[Point, ...]:
    """The runs of the refinement path.

    Args:
        revolutions: asked for.
        finest: the run that is judged, which need not be made again.
        run: makes one with a number of steps per revolution, over some revolutions from a start angle.
    """
    path, judged = refinement_path(scene, steps), run_extent(scene, steps, revolutions)
    # Of one pass all take the part that the longest steps have room for, of those that fit into it.
    if scene.kinematics.mechanism.driver.span is not None:
        path = tuple(n for n in path if n * judged[1] >= LEAST_STEPS)
    start, turns = run_extent(scene, min(path), revolutions)
    known = (start, turns) == judged
    return tuple(finest if known and n == steps else run(n, turns, start) for n in path)


@dataclass(frozen=True)
class EngineCase(Case, Generic[Found]):
    """A scene in an engine with a preset, whose whole result is kept, and judged when it is read.

    Tolerances that a user asks for are no part of it: what they decide is decided when a result is read.

    Attributes:
        engine: name.
        preset: name; None of kinematic mode.
        plan: of the runs, and tolerances.
    """

    study: ClassVar[str]
    kind: ClassVar[type[Any]]  # of the result
    quantities: ClassVar[tuple[str, ...]]  # whose errors a result has
    measures: ClassVar[tuple[str, ...]] = MEASURES
    version: ClassVar[int] = 1  # raised when the same run would come out otherwise, or mean something else

    engine: str
    preset: str | None
    plan: Any

    @property
    def engine_name(self) -> str:
        return self.engine

    @property
    def made_by(self) -> Engine[Any]:
        """The engine itself."""
        return engine_named(self.engine)

    @property
    def effort(self) -> float:
        effort: float = self.plan.steps(self.scene)
        return effort

    @property
    def tolerance(self) -> Mapping[str, float] | None:
        """Tolerances that are asked for; None for those of the study's own accord."""
        asked: Mapping[str, float] | None = self.plan.tolerance
        return asked

    @abstractmethod
    def started(self) -> Found:
        """A result of which nothing is measured yet."""

    @abstractmethod
    def run(self) -> Found:
        """The result, judged by what the study requires of its own accord; raises InvalidInput as `perform`."""

    def ended(self, outcome: Outcome, reason: str) -> Found:
        """The result where the process that ran the case did not live to give one."""
        return replace(self.started(), outcome=outcome.slug, reason=reason).judged(self.tolerance)

    @abstractmethod
    def determined_by(self) -> dict[str, Any]:
        """All besides scene, engine and preset that determines the result, as plain values."""

    def facts(self) -> dict[str, Any]:
        """Fields of the result that the case gives: equal machines may have other names."""
        return {"scene": self.name, "parameters": self.scene.parameters}

    def perform(self) -> Measurement:
        found = self.run()
        sizes = {
            q: {m: size for m in self.measures if (size := found.largest(q, m)) is not None} for q in self.quantities
        }
        kept = {"sizes": sizes, "passed": found.passed, "result": plain_values(found)}
        columns = {name: getattr(found, name, None) for name in COLUMNS}
        return Measurement(found.outcome, found.reason, **columns, beside=kept)

    def result(self, measurement: Measurement) -> Found:
        """The result that a measurement of this case holds, judged by the tolerances that are asked for.

        Raises:
            InvalidInput: the measurement is of another kind.
        """
        if measurement.beside is None:
            return self.ended(Outcome.from_slug(measurement.outcome), measurement.reason)
        kept: Found = restore(self.kind, measurement.beside["result"])
        return replace(kept, **self.facts()).judged(self.tolerance)

    def _read(self, measurement: Measurement) -> None:
        if measurement.beside is not None:
            self.result(measurement)

    def _identity(self, parameters: dict[str, Any] | None) -> dict[str, Any]:
        return {
            "result_version": RESULT_VERSION,
            "study": self.study,
            "study_version": self.version,
            "scene": self.scene.kind,
            "parameters": parameters,
            "engine": self.engine,
            "engine_version": self.made_by.version,
            "preset": self.preset,
            **self.determined_by(),
        }


def results_of(cases: Iterable[EngineCase[Found]]) -> Study[dict[str, tuple[Found, ...]]]:
    """The study that asks for all cases in one round: results by scene, in the order of the cases."""
    asked = list(cases)
    kept = yield asked
    found: dict[str, list[Found]] = {case.name: [] for case in asked}
    for case in asked:
        found[case.name].append(case.result(kept[case.key]))
    return {name: tuple(results) for name, results in found.items()}


def study_of(
    case: type[EngineCase[Found]],
    scenes: Mapping[str, Scene],
    engines: Sequence[Engine[Any]],
    presets: Mapping[str, Sequence[str | None]],
    plan: Any,
) -> Study[list[SceneResults[Found]]]:
    """The study of some scenes: one round of cases of a kind, scene by scene, engine by engine, each preset.

    Args:
        presets: to run, by engine name.
    """
    found = yield from results_of(
        case(name, scene, engine.name, preset, plan)
        for name, scene in scenes.items()
        for engine in engines
        for preset in presets[engine.name]
    )
    return [SceneResults(name, scene, found[name]) for name, scene in scenes.items()]
