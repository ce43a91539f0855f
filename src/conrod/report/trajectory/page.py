"""The folder of a table's report.

The page of a judged table, in Markdown.

All files of a table's report, rendered before any is written.
"""

from __future__ import annotations

from pathlib import Path

from conrod.own.tables.document import table_document, table_text
from conrod.own.tables.judging import ERRORS
from conrod.own.tables.study import TableStudy
from conrod.report import numbers
from conrod.report.charts.canvas import drawing_style, svg_text
from conrod.report.folder import check_own_folder, holds_document
from conrod.report.tables import paragraphs, table
from conrod.report.trajectory.figure import error_figure
from conrod.report.trajectory.words import (
    estimate_rows,
    figure_line,
    remaining_text,
    sense_text,
    summary_line,
    verdict_text,
)
from conrod.studies.frame.files import Batch

PAGE, RESULTS, FIGURES = "README.md", "results.json", "figures"
ERROR_FIGURE = f"{FIGURES}/error.svg"
FILES = (PAGE, RESULTS, ERROR_FIGURE, FIGURES)
# Of a table's results, by which its report is known.
KEYS = {"schema", "table", "scene", "causes"}


def check_table_folder(directory: Path) -> None:
    """Refuse a folder in which a table's report would replace what is none.

    Raises:
        InvalidInput: names the file that is in the way.
    """
    own = holds_document(directory / RESULTS, KEYS)
    check_own_folder(directory, (PAGE, RESULTS), (ERROR_FIGURE,), FIGURES, own, "the report of a table")


READING = (
    "`total` is the position against the exact one at the nominal time; `position`, `velocity` and `acceleration` are "
    "taken at the crank angle, rate and angular acceleration that the table itself says, where it does. Errors are "
    "Euclidean norms, divided by L, ω L or ω² L, where L is the largest distance between two exact positions of the "
    "point and ω the nominal crank speed. Below 1e-12 an error is rounding noise."
)
CAUSES = (
    "A cause is named only where undoing it takes the difference away: no more than a twentieth of it is left. Several "
    "may look the same in one table."
)
ESTIMATES = (
    "By least squares of the positions on the exact motion. The standard errors hold for errors of one size, "
    "independent from row to row; a table whose error is smooth has larger ones."
)


def table_page(study: TableStudy, command: str, with_figure: bool) -> str:
    """The page.

    Args:
        command: what makes it again.
    """
    blocks = [
        f"# {study.file} against {study.scene_name}",
        f"**{verdict_text(study)}.**",
        f"{summary_line(study)}.",
        "" if study.largest("total") is None else f"{_begun(figure_line(study))}.",
        f"Judged against: {study.scene.title}. Frame: {study.scene.frame}",
        f"Reproduced by `{command}`.",
        "## Errors",
        f"![Error of the table over the run]({ERROR_FIGURE})" if with_figure else "",
        _errors(study),
        READING if study.errors else "",
        _crank(study),
        *_causes(study),
        *_estimation(study),
        "## Columns",
        table(
            ("quantity", "column", "unit", "unit from"),
            [(f"`{c.target.name}`", c.heading, c.unit, c.told_by) for c in study.columns],
        ),
        f"Not used: {', '.join(study.unused)}." if study.unused else "",
        "\n".join(f"- {_begun(note)}." for note in study.notes),
        "## Parameters",
        _parameters(study),
    ]
    return paragraphs(*blocks) + "\n"


def _errors(study: TableStudy) -> str:
    rows = []
    for point, errors in study.errors.items():
        for name in ERRORS:
            if name in errors:
                size, limit = errors[name].size, study.tolerance.get(name)
                sizes = (numbers.measured(value) for value in (size.max, size.rms, size.final))
                rows.append((point, name, *sizes, "not judged" if limit is None else f"{limit:g}"))
    return table(("point", "error", "max", "rms", "final", "tolerance"), rows)


def _crank(study: TableStudy) -> str:
    if study.crank is None:
        return ""
    speed = "" if study.crank.speed is None else f" Its speed is off by {numbers.measured(study.crank.speed)} at most."
    return (
        f"The crank's angle is off its nominal one by {numbers.measured(study.crank.phase_max)} rad at most, "
        f"{numbers.measured(study.crank.phase_final)} rad at the end.{speed}"
    )


def _causes(study: TableStudy) -> list[str]:
    if not study.causes:
        return []
    rows = [
        (cause.text, name, numbers.measured(before), numbers.measured(after))
        for cause in study.causes
        for name, (before, after) in cause.explains.items()
    ]
    return ["## Likely causes", table(("cause", "error", "as it is", "without the cause"), rows), CAUSES]


def _estimation(study: TableStudy) -> list[str]:
    if study.estimation is None:
        return []
    found = study.estimation
    return [
        "## Estimates",
        table(("what", "value", "standard error", "unit", "meaning"), estimate_rows(found)),
        "" if found.sense is None else f"{_begun(sense_text(found.sense))}.",
        "\n".join(f"- {text}." for text in found.undetermined),
        f"Made from {found.rows} rows; {remaining_text(study)}.",
        ESTIMATES,
    ]


def _parameters(study: TableStudy) -> str:
    facts = study.scene.parameter_facts()
    rows = [
        (f"`{name}`", *numbers.in_shown_unit(value, facts[name].unit), facts[name].meaning)
        for name, value in study.scene.parameters.items()
    ]
    return table(("parameter", "value", "unit", "meaning"), rows)


def _begun(text: str) -> str:
    """With a capital; `capitalize` would make the others small."""
    return text[0].upper() + text[1:]


def table_report_batch(study: TableStudy, folder: Path, command: str) -> Batch:
    """The report: a figure where there are errors to draw, the numbers, and the page last."""
    files: dict[str, str | bytes] = {}
    if study.errors:
        with drawing_style():
            files[ERROR_FIGURE] = svg_text(error_figure(study))
    files[RESULTS] = table_text(table_document(study))
    files[PAGE] = table_page(study, command, with_figure=bool(study.errors))
    stale = ERROR_FIGURE not in files and (folder / ERROR_FIGURE).is_file()
    return Batch(folder, files, (ERROR_FIGURE,) if stale else ())
