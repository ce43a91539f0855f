"""Results of a validation in words."""

from __future__ import annotations

import numpy as np

from conrod.engines.follower import follower_lift
from conrod.report import numbers
from conrod.runs.convergence import PAIRS_AGREE, observed_order
from conrod.scenes import CamFollower, Scene
from conrod.studies.validation.results import ValidationResult


def order_words(run: ValidationResult, quantity: str) -> str:
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
