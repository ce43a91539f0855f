"""The report on a trajectory that came as a table: on the console, and as a page."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

from conrod.mechanism.units import in_prose
from conrod.own.tables.causes import Cause
from conrod.own.tables.estimation import Estimation
from conrod.own.tables.samples import ERRORS
from conrod.own.tables.study import TableStudy
from conrod.report import numbers
from conrod.report.charts.own import error_figure
from conrod.report.figure import Figure
from conrod.report.kind import Kind, Page, Part
from conrod.report.results import exceeded_words
from conrod.report.scene_words import parameters_table
from conrod.report.table import Table, table
from conrod.report.template import rendered

PART = "table"  # of the report, which has one
# Of what is estimated: the unit that it is shown in, the factor from SI, its meaning.
SHOWN = {
    "time": ("ms", 1e3, "the table's clock minus the scene's"),
    "phase": ("deg", 180.0 / math.pi, "crank angle at the scene's time 0"),
    "zero": ("deg", 180.0 / math.pi, "crank angle where the table's crank angle is 0"),
    "x": ("mm", 1e3, "the scene's origin in the table's frame, x"),
    "y": ("mm", 1e3, "the scene's origin in the table's frame, y"),
    "rotation": ("deg", 180.0 / math.pi, "turn of the scene's axes in the table's frame"),
}
LEAST_DIGITS, MOST_DIGITS = 2, 10
# Below a part in so many of its unit an estimate is rounding.
ROUNDING = 1e-13


# -- words: mm and degrees, two digits for what was measured ---------------------------------------------------------


def summary_line(study: TableStudy) -> str:
    """The table in a line."""
    first, last = (f"{t:.6g}" for t in study.span)
    return f"{study.file}: {study.rows} rows, {first} to {last} s, {_turns(study)} of {study.scene_name} ({study.form})"


def figure_line(study: TableStudy) -> str:
    """The one figure that counts; empty where the table has no positions."""
    errors = {point: curves["total"].size.max for point, curves in study.errors.items() if "total" in curves}
    shown = numbers.with_mm(errors, study.scene.lengths)
    return f"largest position error / L over {_turns(study)}: {shown}" if errors else ""


def _turns(study: TableStudy) -> str:
    return f"{study.revolutions:.4g} revolution{'' if study.revolutions == 1.0 else 's'}"


def verdict_text(study: TableStudy) -> str:
    """The verdict, with what is out of tolerance."""
    if study.passed is None:
        return "measured, not judged: give --tolerance"
    if study.passed:
        found = ((name, study.largest(name), limit) for name, limit in study.tolerance.items())
        within = (f"{name} {numbers.error(name, size)} <= {_allowed(name, limit)}" for name, size, limit in found)
        return f"within tolerance: {', '.join(within)}"
    return f"OUT OF TOLERANCE: {', '.join(exceeded_words(study.exceeded, _allowed))}"


def _allowed(name: str, limit: float) -> str:
    """A tolerance that was given or follows from one, that of the crank's angle in deg."""
    return numbers.allowed(name, limit) if name == "phase" else numbers.quantity(limit)


def crank_text(study: TableStudy) -> str:
    """Deviation of the crank; empty where the table has no crank angle."""
    if study.crank is None:
        return ""
    largest, final = numbers.in_degrees(study.crank.phase_max), numbers.in_degrees(study.crank.phase_final)
    speed = "" if study.crank.speed is None else f"; its speed by {numbers.measured(study.crank.speed)} at most"
    return f"crank angle against the nominal one: off by {largest} deg at most, {final} deg at the end{speed}"


def estimation_lines(study: TableStudy) -> list[str]:
    """Estimates in words: the sense, quantities that cannot be determined, and what is left."""
    found = study.estimation
    if found is None:
        return []
    left = f"what is left after it: {_remaining(study, found.remaining)} rms"
    return [*([] if found.sense is None else [_sense_text(study, *found.sense)]), *found.undetermined, left]


def _remaining(study: TableStudy, size: float) -> str:
    """A rest of a fit, of places over L where there are any."""
    return numbers.error("total" if study.errors else "phase", size, study.scene.lengths)


def _sense_text(study: TableStudy, value: int, *rests: float) -> str:
    name = "the scene's" if value > 0 else "opposite to the scene's"
    left, opposite = (_remaining(study, rest) for rest in rests)
    return f"sense of rotation: {name} (leaves {left} rms, the other one {opposite})"


def cause_line(study: TableStudy, cause: Cause) -> str:
    """A cause with what it explains."""
    without = ", ".join(f"{name} is {after} instead of {before}" for name, before, after in _explained(study, cause))
    return f"likely cause: {cause.text}; without it {without}"


def _explained(study: TableStudy, cause: Cause) -> Iterator[tuple[str, str, str]]:
    """Each error that a cause explains, as it is and without the cause."""
    for name, (before, after) in cause.explains.items():
        lengths = study.scene.lengths
        yield name, numbers.error(name, before, lengths), numbers.error(name, after, lengths)


# -- tables ----------------------------------------------------------------------------------------------------------


def columns_table(study: TableStudy) -> Table:
    """The columns that are used."""
    rows = [(column.target.name, column.heading, in_prose(column.unit), column.unit_from) for column in study.columns]
    return table(("quantity", "column", "unit", "unit from"), rows)


def runs_table(study: TableStudy) -> Table:
    """Largest errors of an FMU's runs, the judged one first, and their orders; no row for a table."""
    names = tuple(study.runs[0].sizes) if study.runs else ()
    rows = [(run.setting, *(numbers.measured(run.sizes.get(n)) for n in names), run.ended) for run in study.runs]
    if any(found := tuple(study.orders.values())):
        rows.append(("order in the step", *("" if order is None else f"{order:.1f}" for order in found), ""))
    return table(("run", *names, "ended by"), rows, names, "largest errors of each run, normalised by L, ω L, ω² L")


def errors_table(study: TableStudy) -> Table:
    """Errors over the run by point."""
    rows = []
    for point, curves in study.errors.items():
        for name in ERRORS:
            if name in curves:
                size, limit = curves[name].size, study.tolerance.get(name)
                sizes = (numbers.measured(value) for value in (size.max, size.rms, size.final))
                shown = numbers.in_mm({point: size.max}, study.scene.lengths) if name in numbers.PLACES else ""
                rows.append((point, name, *sizes, shown, "not judged" if limit is None else _allowed(name, limit)))
    right = ("max", "rms", "final", "max [mm]")
    return table(("point", "error", *right, "tolerance"), rows, right, names=2)


def estimates_table(estimation: Estimation | None) -> Table:
    """Estimated quantities; a value has the digits that its error leaves it."""
    rows = []
    for one in estimation.estimates if estimation else ():
        unit, factor, meaning = SHOWN[one.name]
        value, error = one.value * factor, one.error * factor
        rows.append((one.name, _with_digits(value, error), numbers.measured(error), unit, meaning))
    return table(("what", "value", "standard error", "unit", "meaning"), rows, right=("value", "standard error"))


def _with_digits(value: float, error: float) -> str:
    if abs(value) < ROUNDING:
        return numbers.measured(value)
    digits = LEAST_DIGITS + math.ceil(math.log10(abs(value) / error)) if 0.0 < error < abs(value) else LEAST_DIGITS
    return f"{value:.{min(digits, MOST_DIGITS) if error else MOST_DIGITS}g}"


def _causes_table(study: TableStudy) -> Table:
    rows = [(cause.text, *explained) for cause in study.causes for explained in _explained(study, cause)]
    return table(("cause", "error", "as it is", "without the cause"), rows)


# -- the report ------------------------------------------------------------------------------------------------------


def _page(part: Part[TableStudy]) -> Page:
    study = part.findings
    alt = "Error of the table over the run"
    figures = (Figure("error", alt, lambda: error_figure(study)),) if study.errors else ()
    text = rendered(
        "trajectory", study=study, command=part.command, verdict=verdict_text(study), summary=summary_line(study),
        counts=figure_line(study), figures=figures, errors=errors_table(study), crank=crank_text(study),
        causes=_causes_table(study), estimates=estimates_table(study.estimation), columns=columns_table(study),
        estimation=estimation_lines(study), runs=runs_table(study), parameters=parameters_table(study.scene),
    )  # fmt: skip
    return Page(text, figures)


def _summary(study: TableStudy) -> dict[str, Any]:
    return {
        "passed": study.passed,
        "figure": study.largest("total"),
        "errors": {p: {name: curve.size for name, curve in curves.items()} for p, curves in study.errors.items()},
        "exceeded": study.exceeded,
        "causes": [cause.kind for cause in study.causes],
    }


KIND = Kind(
    name="trajectory",
    findings=TableStudy,
    title=lambda study: f"{study.file} against {study.scene_name}",
    summary=_summary,
    page=_page,
)
