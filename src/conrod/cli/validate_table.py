"""What `conrod validate TABLE` prints.

`conrod validate` of the trajectory of any tool, as a table.
"""

from __future__ import annotations

import sys
from pathlib import Path

import click
from rich.console import Console
from rich.table import Table

from conrod.cli import options as exit_status
from conrod.cli.options import TableOptions
from conrod.errors import InvalidInput
from conrod.own.tables.judging import ERRORS
from conrod.own.tables.study import TableStudy
from conrod.report import numbers
from conrod.report.terminal import console
from conrod.report.trajectory.words import (
    estimate_rows,
    explained,
    figure_line,
    remaining_text,
    sense_text,
    summary_line,
    verdict_text,
)


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
        sizes = (study.crank.phase_max, study.crank.phase_final)
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


# A table of the most rows that are kept is read in a tenth of it.
READING = 300.0  # [s]


def validate_table(
    file: str,
    scene: str,
    options: TableOptions,
    *,
    engine: str | None,
    preset: str | None,
    steps_per_rev: int | None,
    revolutions: int | None,
    assignments: tuple[str, ...],
    tolerance: str | None,
    out: str | None,
    document: str | None,
) -> None:
    """Judge a table against the machine that a scene is."""
    from conrod.own.readable import check_readable
    from conrod.own.tables.columns import request
    from conrod.own.tables.estimation import parse_estimate
    from conrod.own.tables.reading import read_table
    from conrod.own.tables.study import study_table
    from conrod.studies.execution.confined import confined
    from conrod.studies.frame.files import naming, write_together
    from conrod.studies.frame.resolve_arguments import TOLERANCES, parse_tolerance, select_scene

    _check_lone(
        {"--engine": engine, "--preset": preset, "--steps-per-rev": steps_per_rev, "--revolutions": revolutions}
    )
    machine = select_scene(scene, assignments)[1]
    allowed = None if tolerance is None else parse_tolerance(tolerance, (*TOLERANCES, "phase"))
    asked = () if options.estimate is None else parse_estimate(options.estimate)
    points = tuple(machine.lengths)
    wanted = request(options.columns, options.units, points)
    table = Path(file)
    check_readable(table)
    folder, results = _checked_outputs(table, out, document)
    reading = confined(read_table, table, points, wanted, timeout=READING)
    study = study_table(file, scene, machine, reading, asked, allowed)
    with naming("standard output"):
        print_table_study(study)
    batches = []
    if results:
        from conrod.own.tables.document import table_document, table_text
        from conrod.studies.frame.files import single

        batches.append(single(results, table_text(table_document(study))))
    if folder:
        from conrod.report.trajectory.page import table_report_batch

        batches.append(
            table_report_batch(study, folder, _command(file, scene, options, assignments, tolerance, folder))
        )
    write_together(batches)
    if folder:
        click.echo(f"report: {folder / 'README.md'}")
    if study.passed is False:
        sys.exit(exit_status.FAILED)


def _check_lone(runs: dict[str, object]) -> None:
    for option, value in runs.items():
        if value is not None:
            raise InvalidInput(f"{option} does not go with a table: it is for runs of an engine")


def _checked_outputs(table: Path, out: str | None, document: str | None) -> tuple[Path | None, Path | None]:
    """The report's folder and the JSON file, refused before any work where the table or anything else would be lost."""
    from conrod.report.folder import check_beside
    from conrod.report.trajectory.page import FILES, check_table_folder
    from conrod.studies.frame.files import check_apart, file_to_write, folder_to_write

    results = None if document is None else file_to_write(document, "--json")
    if results:
        check_apart({"the table": table, "--json": results})
    folder = None if out is None else folder_to_write(out, "--out")
    if folder:
        check_beside(table, folder, FILES)
        check_table_folder(folder)
        if results:
            check_beside(results, folder, FILES)
    return folder, results


def _command(
    file: str, scene: str, options: TableOptions, assignments: tuple[str, ...], tolerance: str | None, folder: Path
) -> str:
    """What makes the report again."""
    from conrod.cli.reproduction import command_line
    from conrod.report.reproduction import Reproduction

    given = {
        "--scene": scene,
        "--column": options.columns,
        "--unit": options.units,
        "--estimate": options.estimate,
        "--tolerance": tolerance,
    }
    return Reproduction(command_line("validate", given, assignments, folder)).of(file)
