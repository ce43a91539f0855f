"""The report on a user's table of a trajectory, on the console and as a page."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Any

from conrod.exact.link_rotations import ROTATIONS
from conrod.mechanism.units import unit_in_prose
from conrod.models.tables.causes import Cause
from conrod.models.tables.columns import MOTION, Column
from conrod.models.tables.errors import ALL_ERRORS
from conrod.models.tables.study import TableStudy
from conrod.report import numbers
from conrod.report.figure import Figure
from conrod.report.kind import Kind
from conrod.report.results import distrust_words, exceeded_words, within_words
from conrod.report.table import Table, table
from conrod.report.terminal import PrintedPart, indented_under, verdict_line

PART = "table"  # name of the report's only part
# Printed unit, factor from SI and meaning of each estimated quantity.
ESTIMATE_UNITS = {
    "time": ("ms", 1e3, "the table's clock minus the scene's"),
    "phase": ("deg", 180.0 / math.pi, "crank angle at the scene's time 0"),
    "zero": ("deg", 180.0 / math.pi, "crank angle where the table's crank angle is 0"),
}

# -- words: mm and degrees, two digits for what was measured ---------------------------------------------------------


def summary_line(study: TableStudy) -> str:
    """Return the table's rows, times, revolutions and scene in a line."""
    first, last = (f"{t:.6g}" for t in study.span)
    revolutions = _revolutions_text(study)
    return f"{study.file}: {study.rows} rows, {first} to {last} s, {revolutions} of {study.scene_name} ({study.form})"


def _revolutions_text(study: TableStudy) -> str:
    return f"{study.revolutions:.4g} revolution{'' if study.revolutions == 1.0 else 's'}"


def verdict_text(study: TableStudy) -> str:
    """Return the verdict on a table, with the quantities out of tolerance and those not judged."""
    if study.distrust:
        return distrust_words(study)
    if study.passed is None:
        return f"measured, not judged: {_largest_words(study)}give --tolerance"
    scales = {name: scale for name in study.tolerance if (scale := study.judged_scale(name)) is not None}
    unjudged = f"; not judged: {', '.join(_unjudged_words(study))}" if study.unjudged else ""
    unjudged += "".join(f"; {words}" for words in contradiction_words(study))
    if study.passed:
        judged = {name: (study.largest(name), limit) for name, limit in study.tolerance.items()}
        within = within_words(judged, numbers.given_tolerance_text, scales)
        return f"within tolerance: {', '.join(within)}{unjudged}"
    over = exceeded_words(study.exceeded, numbers.given_tolerance_text, scales)
    return f"OUT OF TOLERANCE: {', '.join(over)}{unjudged}"


def _largest_words(study: TableStudy) -> str:
    """Say how far a table is off, in the first quantity that it has, and the likely cause; each ends in '; '."""
    known = ((name, study.largest(name)) for name in (*MOTION, *ALL_ERRORS, "phase"))
    name, size = next(((name, size) for name, size in known if size is not None), ("", 0.0))
    shown = numbers.with_size(numbers.error(name, size), name, size, study.judged_scale(name))
    off = f"{_in_words(name)} off by {shown}; " if name else ""
    return off + "".join(f"likely cause: {cause.text}; " for cause in study.causes[:1])


def _unjudged_words(study: TableStudy) -> Iterator[str]:
    """Yield the quantities that are not judged, with their sizes where the table has them."""
    for words in study.unjudged:
        name, of, _ = words.partition(" of ")
        error = name.replace(" ", "_")
        size = study.largest(error) if error in ALL_ERRORS and not (of and name in MOTION) else None
        if name == "crank angle" and study.phase is not None:
            yield f"{words} (off by {numbers.in_degrees(study.phase)} deg)"
        elif size is None:
            yield words
        else:
            sizes = (numbers.measured_text(size), numbers.size_text(error, size, study.judged_scale(error)))
            yield f"{words} (off by {', '.join(filter(None, sizes))})"


def contradiction_words(study: TableStudy) -> Iterator[str]:
    """Say which velocities contradict the table's positions, and which accelerations its velocities."""
    integrals = {"velocity": "velocities contradict the table's own positions", "acceleration": "accelerations "
                 "contradict the table's own velocities"}  # fmt: skip
    for name in study.contradictory:
        yield f"its {integrals[name]}, whose change is not their integral"


def _in_words(name: str) -> str:
    """Return the name of an error as it is printed, without underscore."""
    return name.replace("angular_", "angular ")


def estimation_lines(study: TableStudy) -> list[str]:
    """List the estimates with their standard errors and the remaining errors."""
    lines = []
    for one in study.estimates:
        unit, factor, meaning = ESTIMATE_UNITS[one.name]
        error = numbers.measured_text(one.error * factor)
        left = numbers.error("total" if study.errors else "phase", one.remaining, study.scene.lengths)
        value = f"{one.value * factor:.10g} {unit}, standard error {error} {unit}"
        lines.append(f"{one.name}, {meaning}: {value}; what is left is {left} rms")
    return lines


def findings(study: TableStudy) -> list[str]:
    """List estimates, unused columns, notes and likely causes, in sentences."""
    unused = ", ".join(name or "(no name)" for name in study.unused)
    lines = [
        *estimation_lines(study),
        f"crank angle off the nominal one by {numbers.in_degrees(study.phase)} deg at most" if study.phase else "",
        f"columns not used: {unused}" if unused else "",
        *(f"note: {note}" for note in study.notes),
        *(_cause_line(study, cause) for cause in study.causes),
        "none of the common causes reproduces the difference" if study.passed is False and not study.causes else "",
    ]
    return [line for line in lines if line]


def _cause_line(study: TableStudy, cause: Cause) -> str:
    """Name a likely cause, with each error that it explains before and after undoing it."""
    lengths = study.scene.lengths
    without = ", ".join(
        f"{_in_words(name)} is {numbers.error(name, after, lengths)} instead of {numbers.error(name, before, lengths)}"
        for name, (before, after) in cause.explains.items()
    )
    return f"likely cause: {cause.text}; without it {without}"


# -- tables ----------------------------------------------------------------------------------------------------------


def columns_table(columns: Sequence[Column]) -> Table:
    """Return a row for each column that was used: quantity, heading, unit."""
    rows = [(column.name, column.heading, unit_in_prose(column.unit), column.unit_from) for column in columns]
    return table(("quantity", "column", "unit", "unit from"), rows)


def errors_table(study: TableStudy) -> Table:
    """Return a row for each point or link and error: max, rms, final and tolerance."""
    rows = []
    for point, curves in study.errors.items():
        for name in ALL_ERRORS:
            if name in curves:
                size, limit = curves[name].size, study.tolerance.get(name)
                sizes = (numbers.measured_text(value) for value in (size.max, size.rms, size.final))
                shown = (
                    numbers.in_mm({point: size.max}, study.scene.lengths) if name in numbers.QUANTITIES_OVER_L else ""
                )
                rows.append(
                    (
                        point,
                        _in_words(name),
                        *sizes,
                        shown,
                        "not judged" if limit is None else numbers.given_tolerance_text(name, limit),
                    )
                )
    right = ("max", "rms", "final", "max [mm]")
    return table(("point", "error", *right, "tolerance"), rows, right, names=2)


def compared_links(study: TableStudy) -> list[str]:
    """Return the names of the links whose rotation, or a derivative of it, the table has."""
    return [name for name, curves in study.errors.items() if set(ROTATIONS) & curves.keys()]


# -- the report ------------------------------------------------------------------------------------------------------


def figure(study: TableStudy) -> Figure | None:
    """Return the figure of errors over the run; None without errors."""
    from conrod.models.tables.charts import table_figure

    return Figure("error", "Error of the table over the run", lambda: table_figure(study)) if study.errors else None


def _summary(study: TableStudy) -> dict[str, Any]:
    return {
        "passed": study.passed,
        "figure": study.largest("total"),
        "errors": {p: {name: curve.size for name, curve in curves.items()} for p, curves in study.errors.items()},
        "exceeded": study.exceeded,
        "causes": [cause.kind for cause in study.causes],
    }


def results_to_print(studies: Sequence[TableStudy]) -> Iterator[PrintedPart]:
    """Yield the verdict, errors, estimates, notes, likely causes and columns of each table."""
    for study in studies:
        yield verdict_line(f"{study.file}: {verdict_text(study)}", study.passed)
        yield errors_table(study)
        yield from indented_under(summary_line(study), findings(study))
        yield columns_table(study.columns)


TABLE_REPORT = Kind(
    name="trajectory",
    findings=TableStudy,
    title=lambda study: f"{study.file} against {study.scene_name}",
    summary=_summary,
    printed=results_to_print,
    verdict=verdict_text,
    one_part=True,
    schema=4,
)
