"""The report on free motion: engines against the exact trajectory in time, on the console and as pages."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import partial

from conrod.report import numbers
from conrod.report.figure import Figure
from conrod.report.kind import Kind
from conrod.report.results import results_table, scene_summary, scene_verdict
from conrod.report.table import Table
from conrod.report.terminal import PrintedPart
from conrod.studies.free_motion import plan
from conrod.studies.free_motion.results import FREE_MOTION_QUANTITIES, MAX_EXACT_DRIFT, MotionResult, MotionStudy

# -- words -----------------------------------------------------------------------------------------------------------


def loads_words(study: MotionStudy) -> str:
    """Say which loads act in the study."""
    mechanism = study.scene.kinematics.mechanism
    acting = ["its weight"] if any(mechanism.gravity) else []
    acting += [f"a constant force on {force.body}" for force in mechanism.forces]
    acting += [load.name for load in mechanism.loads if load.name not in study.left_out]
    acts = f"what acts: {', '.join(acting)}" if acting else "nothing else acts"
    if study.motion == plan.FREE:
        without = f"without {', '.join(study.left_out)}" if study.left_out else "no torque on the crank"
        return f"free motion, {without}; {acts}."
    return f"driven by its torques; {acts}."


def exact_words(study: MotionStudy) -> str:
    """Say how well the exact motion keeps its energy, and how it crosses branches."""
    drift = study.exact.drift
    compared = "<=" if drift <= MAX_EXACT_DRIFT else "above"
    seconds, turn = study.results[0].seconds, study.exact.turn
    said = (
        f"Run: {seconds:.3g} s, {seconds / turn:.3g} times the fastest turn. "
        f"Exact motion: its energy balances to {drift:.1e}, {compared} {MAX_EXACT_DRIFT:g}"
    )
    return ". ".join(filter(None, (said, *map(_capitalise, (study.exact.continuation, study.exact.unresolved))))) + "."


def _capitalise(words: str) -> str:
    return words[:1].upper() + words[1:]


# -- tables ----------------------------------------------------------------------------------------------------------


def verdicts_table(studies: Sequence[MotionStudy]) -> Table:
    """Return a row for each result: errors, departure from the exact motion, order, verdict."""
    lengths = {study.name: study.scene.lengths for study in studies}
    leaving = next((r.leaving for study in studies for r in study.results), plan.POSITION_TOLERANCE)
    columns: dict[str, Callable[[MotionResult], str]] = {
        "step": lambda r: f"{numbers.quantity(1e3 * r.step, 6)} ms",
        "position": lambda r: numbers.measured_text(r.largest("position")),
        numbers.IN_MM: lambda r: numbers.in_mm({p: s["max"] for p, s in (r.errors or {}).items()}, lengths[r.scene]),
        "rms": lambda r: numbers.measured_text(r.largest("position", "rms")),
        "final": lambda r: numbers.measured_text(r.largest("position", "final")),
        "energy": lambda r: numbers.measured_text(r.largest("energy")),
        f"above {numbers.quantity(leaving)} from": _departure_text,
        "order x, E": lambda r: "" if r.order is None else ", ".join(map(numbers.order, r.order.values())),
    }
    title = "error at the same time over the run, positions over L, energy over the largest that took part"
    return results_table(studies, columns, title)


def _departure_text(result: MotionResult) -> str:
    """Text for the time at which a run leaves the exact motion: `never` if it does not."""
    if result.errors is None:
        return numbers.MISSING
    return "never" if result.leaves is None else f"{result.leaves:.4g} s"


# -- the report ------------------------------------------------------------------------------------------------------


def figures(studies: Iterable[MotionStudy]) -> list[Figure]:
    """Return an error figure for each study with at least one completed run."""
    from conrod.studies.free_motion.charts import free_motion_figure

    alt = "Errors of position and energy of {} over time"
    return [
        Figure(f"{study.name}-free-motion", alt.format(study.name), partial(free_motion_figure, study))
        for study in studies
        if any(r.curves is not None for r in study.results)
    ]


def _largest_errors(result: MotionResult) -> dict[str, float | None]:
    return {name: result.largest(name) for name in FREE_MOTION_QUANTITIES}


def results_to_print(studies: Sequence[MotionStudy]) -> Iterator[PrintedPart]:
    """Yield the errors in time, and how well the exact motion is known."""
    yield verdicts_table(studies)
    yield from (f"{study.name}: {loads_words(study)} {exact_words(study)}" for study in studies)


FREE_MOTION_REPORT = Kind(
    name="motion",
    findings=MotionStudy,
    title=lambda study: study.scene.title,
    summary=partial(scene_summary, more=_largest_errors),
    printed=results_to_print,
    verdict=scene_verdict,
    results="motion.json",
    index_file="motion.md",
    suffix="-motion",
    digits=6,
)
