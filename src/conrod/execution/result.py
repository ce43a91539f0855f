"""Results with a verdict, of a scene in an engine with a preset, and the cases that have them."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Any, Generic, Self, TypeVar

from conrod.comparison.trajectory import Outcome
from conrod.engines import Engine, engine_named
from conrod.engines.engine import Preset, default_steps, run_extent
from conrod.errors import InvalidInput
from conrod.execution.case import MIN_PASS_STEPS, POINTS_PREFIX, Case, CaseResult, Study, contradictions
from conrod.execution.tolerances import Limit, Scales, UnscaledLimit, scale_tolerance, scene_scales
from conrod.scenes import Scene

AS_ASKED = "as asked for"
# Refinement path: the steps per revolution are divided by these; what a preset states in steps or periods follows.
LINKAGE_DIVISORS, CONTACT_DIVISORS = (8, 4, 2, 1), (16, 8, 4, 2)


@dataclass(frozen=True, kw_only=True)
class JudgedResult(CaseResult, ABC):
    """Result of one scene in an engine with a preset: errors and orders of a completed run alone, and a verdict.

    Attributes:
        preset: name; None in kinematic mode.
        order: observed, by quantity.
        passed: the verdict; None where nothing is judged.
        weights: for tolerances given in units, the weight of each point's error (`scale_tolerance`); None for 1.
    """

    scene: str
    engine: str
    engine_version: str
    preset: str | None
    order: Mapping[str, float | None] | None = None
    passed: bool | None = None
    weights: Mapping[str, Mapping[str, float]] | None = None

    @property
    @abstractmethod
    def limits(self) -> Mapping[str, float]:
        """Allowed errors by tolerance name; empty if nothing is judged."""

    @property
    def distrust(self) -> str:
        """Why the exact motion cannot be trusted, from its misfit with the joints' equations; empty if it can."""
        return ""

    def other_failures(self) -> list[str]:
        """Reasons for failing the result other than errors out of tolerance, in words."""
        return []

    @property
    def acceleration_error(self) -> float | None:
        """Largest acceleration error, normalised; None in studies that measure no acceleration."""
        return None

    def judged_error(self, name: str) -> float | None:
        """Error that the tolerance of this name is compared with."""
        return self.largest(name)

    def out_of_tolerance(self) -> dict[str, tuple[float | None, float]]:
        """Error found (None: no error) and allowed error, by judged quantity out of tolerance."""
        pairs = {name: (self.judged_error(name), allowed) for name, allowed in self.limits.items()}
        return {name: pair for name, pair in pairs.items() if pair[0] is None or not pair[0] <= pair[1]}

    def weigh(self, name: str, errors: Mapping[str, float]) -> dict[str, float]:
        """Errors by point, times their weights for the tolerance of this name."""
        weights = (self.weights or {}).get(name, {})
        return {point: error * weights.get(point, 1.0) for point, error in errors.items()}

    def judged_points(self, name: str) -> Mapping[str, float]:
        """Judged errors by point or link; empty in studies that have none by point."""
        return {}

    def own_scales(self) -> Scales:
        """SI size of a share of 1, by quantity that the scene's motion gives no scale for."""
        return {}

    def with_verdict(self, asked: Mapping[str, Limit] | None = None, scales: Scales = MappingProxyType({})) -> Self:
        """Judge the result, and return it with its verdict, `passed`.

        A result is judged by its own tolerances when it is made, and that is kept in the ledger. It is judged once more
        when a study reads it, if the user gave tolerances.

        Args:
            asked: tolerances of the user; None for the result's own.
            scales: SI size of a share of 1, for tolerances that were given in units.
        """
        if self.outcome == Outcome.UNSUPPORTED.slug:
            return self
        result = self
        if asked is not None:
            limits, weights = scale_tolerance(asked, {**scales, **self.own_scales()})
            result = replace(self._with_tolerances(limits), weights=weights or None)
        if self.distrust:
            return replace(result, passed=False)
        passed = result.completed and not result.out_of_tolerance() and not (asked is None and result.other_failures())
        return replace(result, passed=passed if result.limits else None)

    @abstractmethod
    def _with_tolerances(self, tolerances: Mapping[str, float]) -> Self:
        """Return the result with other tolerances."""


Found = TypeVar("Found", bound=JudgedResult)
Point = TypeVar("Point")


@dataclass(frozen=True)
class SceneResults(Generic[Found]):
    """All results of one scene."""

    name: str
    scene: Scene
    results: tuple[Found, ...]

    @property
    def passed(self) -> bool:
        """True if no judged result failed."""
        return all(result.passed is not False for result in self.results)


def misfit_words(misfit: Mapping[str, Mapping[str, float]]) -> str:
    """Say what contradicts the exact motion; empty where nothing does."""
    wrong = contradictions(misfit)
    if any(name.startswith(POINTS_PREFIX) for name in wrong):
        apart = max(one["difference"] for name, one in wrong.items() if name.startswith(POINTS_PREFIX))
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
    divisors = CONTACT_DIVISORS if scene.kinematics.mechanism.cam_contacts else LINKAGE_DIVISORS
    return tuple(dict.fromkeys(max(2, round(steps / d)) for d in divisors))


@dataclass(frozen=True)
class Plan:
    """Plan of the runs of a study at constant crank speed.

    Attributes:
        steps_per_revolution: steps per revolution of the crank; None for the scene's default.
        revolutions: revolutions of the judged run; a scene with a span makes one pass instead.
        tolerance: overrides of the derived tolerances, by quantity.
    """

    steps_per_revolution: int | None = None
    revolutions: float = 2.0
    tolerance: Mapping[str, Limit] | None = None

    def steps(self, scene: Scene) -> int:
        """Return the steps per revolution for a scene."""
        return self.steps_per_revolution or default_steps(scene)

    def run_fields(self, scene: Scene, preset: Preset[Any], refined: bool = True) -> dict[str, Any]:
        """Return the plain values of a case's key that describe the runs of a preset.

        Args:
            refined: whether the runs of the refinement path count, too.
        """
        steps = self.steps(scene)
        path = refinement_path(scene, steps) if refined else ()
        settings = [preset(scene, n).as_dict() for n in (steps, *path)]
        return {"settings": settings[0], "refined": settings[1:], "revolutions": self.revolutions, "start_angle": 0.0}

    def extent(self, scene: Scene) -> tuple[float, float]:
        """Return start angle [rad] and revolutions of the judged run.

        Raises:
            InvalidInput: a pass with fewer than `MIN_PASS_STEPS` steps.
        """
        steps = self.steps(scene)
        start, revolutions = run_extent(scene, steps, self.revolutions)
        count = round(steps * revolutions)
        if scene.kinematics.mechanism.driver.span is not None and count < MIN_PASS_STEPS:
            raise InvalidInput(
                f"{steps} steps per revolution are {count} of the pass: at least {MIN_PASS_STEPS} are run"
            )
        return start, revolutions


def run_refinement_path(
    scene: Scene, steps: int, revolutions: float, finest: Point, run: Callable[[int, float, float], Point]
) -> tuple[Point, ...]:
    """Make the runs of the refinement path, and return one point for each.

    Args:
        revolutions: number that the user asked for.
        finest: point of the judged run, which is not run again if the path contains it.
        run: makes the run with a number of steps per revolution, over some revolutions, from a start angle [rad].
    """
    path, judged = refinement_path(scene, steps), run_extent(scene, steps, revolutions)
    # Of one pass all take the part that the longest steps have room for, of those that fit into it.
    if scene.kinematics.mechanism.driver.span is not None:
        path = tuple(n for n in path if n * judged[1] >= MIN_PASS_STEPS)
    start, turns = run_extent(scene, min(path), revolutions)
    known = (start, turns) == judged
    return tuple(finest if known and n == steps else run(n, turns, start) for n in path)


@dataclass(frozen=True)
class JudgedCase(Case, Generic[Found]):
    """A scene in an engine with a preset, whose result has a verdict.

    Tolerances that a user asks for are no part of it: what they decide is decided when a study reads the result.

    Attributes:
        engine: name.
        preset: name; None in kinematic mode.
        plan: plan of the runs, with the tolerances that a user asks for.
    """

    engine: str
    preset: str | None
    plan: Any

    @property
    def engine_name(self) -> str:
        return self.engine

    @property
    def loaded_engine(self) -> Engine[Any]:
        """Engine of this name, loaded."""
        return engine_named(self.engine)

    @property
    def effort(self) -> float:
        effort: float = self.plan.steps(self.scene)
        return effort

    @property
    def tolerance(self) -> Mapping[str, Limit] | None:
        """Tolerances that the user asked for; None for the study's own."""
        asked: Mapping[str, Limit] | None = self.plan.tolerance
        return asked or None

    @abstractmethod
    def empty_result(self) -> Found:
        """Return the result with its known facts, before anything is measured."""

    @abstractmethod
    def perform(self) -> Found:
        """Make the runs, and return the result judged by the study's own tolerances."""

    def failed_result(self, outcome: Outcome, reason: str) -> Found:
        return replace(self.empty_result(), outcome=outcome.slug, reason=reason).with_verdict()

    def case_fields(self) -> dict[str, Any]:
        """Fields of the result taken from the case, not from the ledger: equal machines may differ in name."""
        return {"scene": self.name, "parameters": self.scene.parameters}

    def requested_result(self, result: Found) -> Found:
        """Return the result under this case's name, judged by the tolerances that the user asked for, if any."""
        named = replace(result, **self.case_fields())
        if self.tolerance is None:
            return named
        in_units = any(isinstance(limit, UnscaledLimit) for limit in self.tolerance.values())
        return named.with_verdict(self.tolerance, scene_scales(self.scene) if in_units else {})

    @abstractmethod
    def run_fields(self) -> dict[str, Any]:
        """Plain values of the key that describe the runs."""

    def key_fields(self) -> dict[str, Any]:
        named = {"engine": self.engine, "engine_version": self.loaded_engine.version, "preset": self.preset}
        return named | self.run_fields()


def case_results(cases: Iterable[JudgedCase[Found]]) -> Study[dict[str, tuple[Found, ...]]]:
    """Study that runs all cases in one round; returns results by scene, in the order of the cases."""
    asked = list(cases)
    kept = yield asked
    found: dict[str, list[Found]] = {case.name: [] for case in asked}
    for case in asked:
        found[case.name].append(case.requested_result(kept[case.key]))
    return {name: tuple(results) for name, results in found.items()}


def presets_study(
    case: type[JudgedCase[Found]],
    scenes: Mapping[str, Scene],
    engines: Sequence[Engine[Any]],
    presets: Mapping[str, Sequence[str | None]],
    plan: Any,
) -> Study[list[SceneResults[Found]]]:
    """Study of each scene in each engine with each preset, by one kind of case, in one round.

    Args:
        presets: names of the presets to run, by engine name.
    """
    found = yield from case_results(
        case(name, scene, engine.name, preset, plan)
        for name, scene in scenes.items()
        for engine in engines
        for preset in presets[engine.name]
    )
    return [SceneResults(name, scene, found[name]) for name, scene in scenes.items()]
