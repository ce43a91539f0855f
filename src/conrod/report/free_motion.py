"""The report on free motion: engines against the exact trajectory in time, on the console and as pages."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from typing import Any

from conrod.report import numbers
from conrod.report.charts.free_motion import motion_figure
from conrod.report.charts.styles import engine_title
from conrod.report.figure import Figure
from conrod.report.kind import Index, Kind, Page, Part
from conrod.report.scene_words import described
from conrod.report.table import Cell, Table, Toned, table
from conrod.report.template import rendered
from conrod.studies.free_motion.plan import CONTACT_STEPS_A_TURN, FREE, LENGTH_ERROR, LONGEST_STEP, STEPS_A_TURN
from conrod.studies.free_motion.results import EXACT_DRIFT, MotionResult, MotionStudy

SIZES = ("position", "rms", "final", "crank [rad]", "energy")


# -- words -----------------------------------------------------------------------------------------------------------


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
    """The loads that act."""
    mechanism = study.scene.kinematics.mechanism
    acting = ["its weight"] if any(mechanism.gravity) else []
    acting += [f"a constant force on {force.body}" for force in mechanism.forces]
    acting += [load.name for load in mechanism.loads if load.name not in study.left_out]
    acts = f"what acts: {', '.join(acting)}" if acting else "nothing else acts"
    if study.motion == FREE:
        without = f"without {', '.join(study.left_out)}" if study.left_out else "no torque on the crank"
        return f"free motion, {without}; {acts}."
    return f"driven by its torques; {acts}."


def exact_words(study: MotionStudy) -> str:
    """The exact motion's own balance of energy, and where it had a choice."""
    drift = study.exact.drift
    compared = "<=" if drift <= EXACT_DRIFT else "above"
    said = f"Exact motion: its energy balances to {drift:.1e}, {compared} {EXACT_DRIFT:g}"
    return f"{said}; {study.exact.continuation}." if study.exact.continuation else f"{said}."


def summary_words(study: MotionStudy) -> str:
    """Count of the judged results that passed."""
    judged = [r for r in study.results if r.passed is not None]
    failed = [r for r in judged if not r.passed]
    if not judged:
        return "Nothing was judged."
    if not failed:
        count = "The judged result is" if len(judged) == 1 else f"All {len(judged)} judged results are"
        return f"{count} within tolerance."
    names = ", ".join(" ".join(_name(r)) for r in failed)
    return f"{len(failed)} of {len(judged)} judged results did not pass: {names}."


def step_text(step: float) -> str:
    """A time step in ms."""
    return f"{numbers.quantity(1e3 * step, 6)} ms"


def _name(result: MotionResult) -> tuple[str, str]:
    return engine_title(result.engine), result.preset


# -- tables ----------------------------------------------------------------------------------------------------------


def results_table(studies: Sequence[MotionStudy], with_clock: bool = False) -> Table:
    """A row for each result: errors, when it leaves the exact motion, observed order and verdict.

    Args:
        with_clock: whether the CPU time of stepping is shown, which is another one every time.
    """
    leaving = next((r.leaving for study in studies for r in study.results), LENGTH_ERROR)
    head = ["scene", "engine", "preset", "step", *SIZES, f"above {numbers.quantity(leaving)} from", "order x, E"]
    head += ["CPU"] * with_clock + ["verdict"]
    rows = []
    for study in studies:
        for r in study.results:
            sizes = [numbers.measured(r.largest("position", measure)) for measure in ("max", "rms", "final")]
            sizes += [numbers.measured(r.largest(name)) for name in ("angle", "energy")]
            leaves = numbers.MISSING if r.errors is None else "never" if r.leaves is None else f"{r.leaves:.4g} s"
            order = "" if r.order is None else ", ".join(numbers.order(r.order[q]) for q in ("position", "energy"))
            clock = [numbers.duration(r.cpu_seconds)] * with_clock
            rows.append([study.name, *_name(r), step_text(r.step), *sizes, leaves, order, *clock, _verdict(r)])
    title = "error at the same time over the run, positions over L, energy over the largest that took part"
    return table(head, rows, right=head[3:-1], title=title)


def _verdict(result: MotionResult) -> Cell:
    text = verdict_words(result)
    if result.outcome != "completed":
        return Toned(text, "odd")
    return text if result.passed is None else Toned(text, "good" if result.passed else "bad")


def steps_table(study: MotionStudy) -> Table:
    """Errors along the refinement path, a row for each run of it."""
    rows = [
        (*_name(r), step_text(p.step), p.outcome, numbers.measured(p.position), numbers.measured(p.energy))
        for r in study.results
        for p in r.refinement
    ]
    return table(("engine", "preset", "step", "outcome", "position", "energy"), rows)


# -- the report ------------------------------------------------------------------------------------------------------


def _figures(study: MotionStudy) -> tuple[Figure, ...]:
    if all(r.curves is None for r in study.results):
        return ()
    alt = f"Crank angle, error and drift of energy of {study.name} over time"
    return (Figure(f"{study.name}-free-motion", alt, partial(motion_figure, study)),)


def _page(part: Part[MotionStudy]) -> Page:
    study, figures = part.findings, _figures(part.findings)
    versions = dict.fromkeys(f"{engine_title(r.engine)} {r.engine_version}" for r in study.results)
    text = rendered(
        "motion", study=study, figures=figures, description=described(study.scene), loads=loads_words(study),
        exact=exact_words(study), summary=summary_words(study), results=results_table([study]),
        steps=steps_table(study), versions=", ".join(versions), command=part.command, longest=1e3 * LONGEST_STEP,
        steps_a_turn=STEPS_A_TURN, contact_steps=CONTACT_STEPS_A_TURN, seconds=float(study.exact.times[-1]),
    )  # fmt: skip
    return Page(text, figures)


def _summary(study: MotionStudy) -> dict[str, Any]:
    results = [
        {
            "engine": r.engine,
            "preset": r.preset,
            "verdict": verdict_words(r),
            "passed": r.passed,
            **{name: r.largest(name) for name in ("position", "angle", "energy")},
        }
        for r in study.results
    ]
    return {"passed": study.passed, "verdict": summary_words(study), "results": results}


def _index(index: Index[MotionStudy]) -> Page:
    studies = [index.findings(name) for name in index.entries]
    figures = [figure for study in studies for figure in _figures(study)]
    table = results_table(studies)
    return Page(
        rendered("motion-index", entries=index.entries, results=table, figures=figures[:1], origin=index.origin)
    )


def _without_clock(study: MotionStudy) -> MotionStudy:
    """The study without CPU times, which are others every time."""
    return replace(study, results=tuple(replace(r, cpu_seconds=None) for r in study.results))


KIND = Kind(
    name="motion",
    findings=MotionStudy,
    title=lambda study: study.scene.title,
    summary=_summary,
    page=_page,
    index=_index,
    results="motion.json",
    index_file="motion.md",
    suffix="-motion",
    digits=6,
    kept=_without_clock,
)
