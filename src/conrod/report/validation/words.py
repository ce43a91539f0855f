"""Results of a validation in words."""

from __future__ import annotations

import numpy as np

from conrod.engines.follower import follower_lift
from conrod.report import numbers
from conrod.report.charts.styles import engine_title
from conrod.runs.convergence import PAIRS_AGREE, observed_order
from conrod.runs.trajectory import Outcome
from conrod.scenes import CamFollower, Scene
from conrod.studies.validation.results import Result, SceneStudy

PLAIN_NAMES = {"velocity_rms": "velocity (rms)", "total": "position at time t"}
KINEMATIC = "kinematic mode"


def name_of(result: Result) -> tuple[str, str]:
    """The first two cells of a row: engine and preset."""
    return engine_title(result.engine), result.preset or KINEMATIC


def verdict_words(result: Result) -> str:
    """Within tolerance or not, and if not why; what ended the run, where it did not complete."""
    if result.outcome != Outcome.COMPLETED.slug:
        failed = "" if result.passed is not False or result.outcome == Outcome.UNSUPPORTED.slug else "failed, "
        return f"{failed}{result.outcome}: {result.reason or Outcome.of(result.outcome).meaning}"
    if result.passed is None:
        return "measured, not judged"
    if result.passed:
        return "within tolerance"
    return "OUT OF TOLERANCE: " + "; ".join(exceeded_words(result) or ["see the tables"])


def exceeded_words(result: Result) -> list[str]:
    """The judged quantities that are out of tolerance, with what was found and allowed."""
    reasons = []
    for name, (found, allowed) in result.exceeded().items():
        plain = PLAIN_NAMES.get(name, name)
        if found is None:
            reasons.append(f"{plain} has no error to judge")
        else:
            reasons.append(f"{plain} {numbers.measured(found)} > {numbers.measured(allowed)}")
    printed = result.printed
    if printed is not None and printed.engine_agrees != printed.exact_agrees:
        reasons.append(f"the printed table, {printed.engine_agrees} of {printed.exact_agrees} cells met")
    return reasons


def summary_words(study: SceneStudy) -> str:
    """The verdict on the scene in a sentence or two."""
    judged = [r for r in study.results if r.passed is not None]
    failed = [r for r in judged if not r.passed]
    if not judged:
        return "Nothing was judged."
    if not failed:
        return f"All {len(judged)} judged results are within tolerance."
    names = ", ".join(" ".join(name_of(r)) for r in failed)
    return f"{len(failed)} of {len(judged)} judged results did not pass: {names}."


def order_words(run: Result, quantity: str) -> str:
    """The claimed order, or what the errors do instead."""
    claimed = None if run.order is None else run.order.get(quantity)
    if claimed is not None:
        return numbers.order(claimed)
    stable = [(p.steps_per_revolution, e) for p in run.refinement if (e := getattr(p, quantity)) is not None]
    if len(stable) < 2:
        return numbers.MISSING
    pairs = [p for p in observed_order([n for n, _ in stable], [e for _, e in stable]).pairs if p is not None]
    if pairs and max(pairs[-2:]) <= PAIRS_AGREE:
        return f"none: plateau at {numbers.measured(stable[-1][1])}"
    return "none claimed: pairs " + ", ".join(f"{round(p, 1) + 0.0:.1f}" for p in pairs)


def versions_words(results: tuple[Result, ...]) -> str:
    """Engines and their versions."""
    return ", ".join(dict.fromkeys(f"{engine_title(r.engine)} {r.engine_version}" for r in results))


def stretch_words(scene: Scene, revolutions: float) -> tuple[str, str]:
    """The stretch that was run, and the part of it that the curves show."""
    if scene.kinematics.mechanism.driver.span is None:
        turns = numbers.quantity(revolutions)
        return f"{turns} revolutions", f"the last of {turns} revolutions"
    degrees = numbers.quantity(360.0 * revolutions)
    return f"the pass of {degrees} deg", f"the pass of {degrees} deg that the input makes, which cannot turn fully"


def break_words(scene: Scene) -> str:
    """Crank angles [deg] where the acceleration or the jerk jumps."""
    return ", ".join(numbers.quantity(float(np.degrees(a))) for a in scene.break_angles())


def lift_words(scene: Scene) -> str:
    """The full lift of a cam; empty where there is none."""
    if isinstance(scene, CamFollower):
        return f"Full lift: {numbers.quantity(1e3 * scene.full_lift)} mm."
    lift = follower_lift(scene.kinematics)
    return f"Full lift: {numbers.quantity(1e3 * lift.full)} mm." if lift else ""
