"""The report on a run under a torque, on the console and as a page."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Any

from conrod.mechanism.units import RPM
from conrod.models.tables.causes import Cause
from conrod.models.tables.report import columns_table
from conrod.models.torque_runs.comparison import CRANK, JUDGED_QUANTITIES, PHASE
from conrod.models.torque_runs.study import TorqueRunStudy
from conrod.report import numbers
from conrod.report.figure import Figure
from conrod.report.kind import Kind
from conrod.report.results import distrust_words, exceeded_words, within_words
from conrod.report.table import Table, table
from conrod.report.terminal import PrintedPart, indented_under, verdict_line

PART = "run"  # name of the report's only part


def summary_line(study: TorqueRunStudy) -> str:
    """Return the run's rows, times, machine, torque and start in a line."""
    first, last = (f"{t:.6g}" for t in study.span)
    return (
        f"{study.file}: {study.rows} rows, {first} to {last} s, of {study.scene_name} under {study.torque} "
        f"({study.form}); {start_words(study)}"
    )


def start_words(study: TorqueRunStudy) -> str:
    """Return the start of the exact motion in words."""
    angle, speed, given = study.start
    who = "--start" if given else "the machine's own"
    at = f"crank angle {math.degrees(angle):.6g} deg" + ("" if math.isnan(speed) else f" and {speed / RPM:.6g} rpm")
    return f"it starts at {at} ({who})"


def exact_words(study: TorqueRunStudy) -> str:
    """Return how precise the exact motion is."""
    return f"the exact motion keeps its balance of energy to {study.drift:.1g} of the largest energy"


def verdict_text(study: TorqueRunStudy) -> str:
    """Return the verdict on a run: exceeded limits with their instants, or the largest errors."""
    if study.distrust:
        return distrust_words(study)
    unjudged = f"; not judged: {', '.join(study.unjudged)}" if study.unjudged else ""
    scales = {name: scale for name in study.tolerance if (scale := study.judged_scale(name)) is not None}
    if study.exceeded:
        words = exceeded_words(study.exceeded, numbers.given_tolerance_text, scales)
        when = ", ".join(f"{name} at {_time_of_largest(study, name):.4g} s" for name in study.exceeded)
        return f"OUT OF TOLERANCE: {', '.join(words)} (largest: {when}){unjudged}"
    judged = {name: (study.largest(name) or 0.0, limit) for name, limit in study.tolerance.items()}
    within = within_words(judged, numbers.given_tolerance_text, scales)
    return f"within tolerance: {', '.join(within)}{unjudged}"


def _time_of_largest(study: TorqueRunStudy, name: str) -> float:
    """Time [s] of the largest error of a quantity."""
    own = [one[name] for one in study.errors.values() if name in one]
    return max(own, key=lambda error: error.size.max).time


def findings(study: TorqueRunStudy) -> list[str]:
    """List unused columns, notes, likely causes and the precision of the exact motion, in sentences."""
    unused = ", ".join(name or "(no name)" for name in study.unused)
    lines = [
        f"columns not used: {unused}" if unused else "",
        *(f"note: {note}" for note in study.notes),
        *(_cause_line(study, cause) for cause in study.causes),
        "none of the common causes reproduces the difference" if not study.passed and not study.causes else "",
        exact_words(study),
    ]
    return [line for line in lines if line]


def _cause_line(study: TorqueRunStudy, cause: Cause) -> str:
    """Name a likely cause, with each error that it explains before and after undoing it."""
    lengths = study.scene.lengths
    explained = {name: pair for name, pair in cause.explains.items() if pair[0] != pair[1]}
    if not explained:
        return f"likely cause: {cause.text}"
    without = ", ".join(
        f"{name} is {numbers.error(name, after, lengths)} instead of {numbers.error(name, before, lengths)}"
        for name, (before, after) in explained.items()
    )
    return f"likely cause: {cause.text}; without it, over the first turns, {without}"


# -- tables ----------------------------------------------------------------------------------------------------------


def errors_table(study: TorqueRunStudy) -> Table:
    """Return a row for each point, or the crank, and error: sizes, the largest in its unit and when, tolerance."""
    rows = []
    for point, errors in study.errors.items():
        for name in JUDGED_QUANTITIES:
            if name in errors:
                error, limit = errors[name], study.tolerance.get(name)
                sizes = (numbers.measured_text(value) for value in (error.size.max, error.size.rms, error.size.final))
                allowed = "not judged" if limit is None else numbers.given_tolerance_text(name, limit)
                rows.append((point, name, *sizes, _error_cell(study, point, name), f"{error.time:.4g}", allowed))
    right = ("max", "rms", "final", "max, shown", "at [s]")
    return table(("point", "error", *right, "tolerance"), rows, right, names=2)


def _error_cell(study: TorqueRunStudy, point: str, name: str) -> str:
    """The largest error in mm, m/s, m/s², deg or rpm."""
    size, lengths = study.errors[point][name].size.max, study.scene.lengths
    if point == CRANK:
        return (
            f"{numbers.in_degrees(size)} deg"
            if name == PHASE
            else f"{numbers.scaled_text(size, study.speed / RPM)} rpm"
        )
    if name == "position":
        return f"{numbers.scaled_text(size, 1e3 * lengths[point])} mm"
    order, unit = (1, "m/s") if name == "velocity" else (2, "m/s²")
    return f"{numbers.scaled_text(size, lengths[point] * study.speed**order)} {unit}"


# -- the report ------------------------------------------------------------------------------------------------------


def figure(study: TorqueRunStudy) -> Figure:
    """Return the figure of errors over time."""
    from conrod.models.torque_runs.charts import torque_run_figure

    return Figure("error", "Error of the run over time", lambda: torque_run_figure(study))


def _summary(study: TorqueRunStudy) -> dict[str, Any]:
    return {
        "passed": study.passed,
        "errors": {
            p: {name: vars(one.size) | {"time": one.time} for name, one in e.items()} for p, e in study.errors.items()
        },
        "exceeded": study.exceeded,
        "causes": [cause.kind for cause in study.causes],
    }


def results_to_print(studies: Sequence[TorqueRunStudy]) -> Iterator[PrintedPart]:
    """Yield the verdict, errors, notes, likely causes and columns of each run."""
    for study in studies:
        yield verdict_line(f"{study.file}: {verdict_text(study)}", study.passed)
        yield errors_table(study)
        yield from indented_under(summary_line(study), findings(study))
        yield columns_table(study.columns)


TORQUE_RUN_REPORT = Kind(
    name="torque-run",
    findings=TorqueRunStudy,
    title=lambda study: f"{study.file}: {study.scene_name} under a torque",
    summary=_summary,
    printed=results_to_print,
    verdict=verdict_text,
    one_part=True,
    schema=1,
)
