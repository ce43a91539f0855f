"""What is said of free motion, on the console and on the page."""

from __future__ import annotations

from conrod.report import numbers
from conrod.studies.free_motion.plan import FREE
from conrod.studies.free_motion.results import EXACT_DRIFT, MotionResult, MotionStudy


def verdict_words(result: MotionResult) -> str:
    """The verdict, with what is out of tolerance."""
    if result.outcome != "completed":
        return f"{result.outcome}: {result.reason}"
    if result.passed is None:
        return "measured, not judged"
    if result.passed:
        return "within tolerance"
    missed = ", ".join(
        f"{name} {numbers.measured(found)} > {numbers.quantity(limit)}"
        for name, (found, limit) in result.exceeded.items()
    )
    return f"OUT OF TOLERANCE: {missed}"


def loads_words(study: MotionStudy) -> str:
    """Which loads act."""
    mechanism = study.scene.kinematics.mechanism
    acting = ["its weight"] if any(mechanism.gravity) else []
    acting += [f"a constant force on {force.body}" for force in mechanism.forces]
    acting += [load.name for load in mechanism.loads if load.name not in study.left_out]
    if study.motion == FREE:
        without = f"without {', '.join(study.left_out)}" if study.left_out else "no torque on the crank"
        return f"free motion, {without}; {_acting(acting)}."
    return f"driven by its torques; {_acting(acting)}."


def _acting(names: list[str]) -> str:
    return f"what acts: {', '.join(names)}" if names else "nothing else acts"


def exact_words(study: MotionStudy) -> str:
    """The exact motion's own balance of energy, and where it had a choice."""
    drift = study.exact.drift
    compared = "<=" if drift <= EXACT_DRIFT else "above"
    said = f"Exact motion: its energy balances to {drift:.1e}, {compared} {EXACT_DRIFT:g}"
    return f"{said}; {study.exact.continuation}." if study.exact.continuation else f"{said}."


def step_text(step: float) -> str:
    """A time step in ms."""
    return f"{numbers.quantity(1e3 * step, 6)} ms"
