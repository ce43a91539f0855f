"""What `conrod validate TABLE` prints."""

from __future__ import annotations

from rich.console import Console
from rich.table import Table

from conrod.console import console
from conrod.report import numbers
from conrod.report.trajectory.words import (
    estimate_rows,
    explained,
    figure_line,
    remaining_text,
    sense_text,
    summary_line,
    verdict_text,
)
from conrod.tables.judging import ERRORS
from conrod.tables.study import TableStudy


def print_table_study(study: TableStudy) -> None:
    """What the table has, what was estimated, how far it is off, why, and the verdict."""
    out = console()
    _line(out, summary_line(study))
    _print_columns(out, study)
    _print_estimation(out, study)
    if study.errors:
        _print_errors(out, study)
    if study.largest("total") is not None:
        _line(out, figure_line(study))
    if study.crank is not None:
        sizes = (study.largest("phase"), abs(float(study.crank.phase[-1])))
        largest, final = map(numbers.measured, sizes)
        _line(out, f"crank angle against the nominal one: off by {largest} rad at most, {final} rad at the end")
    if study.unused:
        _line(out, f"columns not used: {', '.join(name or '(no name)' for name in study.unused)}")
    for note in study.notes:
        _line(out, f"note: {note}")
    for cause in study.causes:
        _line(out, f"likely cause: {cause.text}; without it {explained(cause)}")
    if study.causes == () and study.passed is False:
        _line(out, "none of the common causes reproduces the difference")
    colour = {True: "green", False: "red", None: "default"}[study.passed]
    out.print(verdict_text(study), style=colour, markup=False, soft_wrap=True)


def _line(out: Console, text: str) -> None:
    out.print(text, markup=False, soft_wrap=True)


def _print_columns(out: Console, study: TableStudy) -> None:
    table = Table(box=None, pad_edge=False)
    for heading in ("quantity", "column", "unit", "from"):
        table.add_column(heading, no_wrap=True)
    for column in study.columns:
        table.add_row(column.target.name, column.heading, column.unit, column.told_by)
    out.print(table)


def _print_estimation(out: Console, study: TableStudy) -> None:
    if study.estimation is None:
        return
    _line(out, f"estimated from {study.estimation.rows} rows")
    table = Table()
    for heading in ("what", "value", "standard error", "unit", "meaning"):
        table.add_column(heading, justify="right" if heading in ("value", "standard error") else "left")
    for row in estimate_rows(study.estimation):
        table.add_row(*row)
    if table.row_count:
        out.print(table)
    if study.estimation.sense is not None:
        _line(out, sense_text(study.estimation.sense))
    for text in study.estimation.undetermined:
        _line(out, text)
    _line(out, remaining_text(study))


def _print_errors(out: Console, study: TableStudy) -> None:
    _line(out, "errors over the run, normalised by L, omega L, omega^2 L")
    table = Table()
    for heading in ("point", "error", "max", "rms", "final"):
        table.add_column(heading, justify="left" if heading in ("point", "error") else "right", no_wrap=True)
    for point, errors in study.errors.items():
        for name in ERRORS:
            if name in errors:
                size = errors[name].size
                table.add_row(point, name, *(numbers.measured(value) for value in (size.max, size.rms, size.final)))
    out.print(table)
