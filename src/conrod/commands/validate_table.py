"""`conrod validate` of the trajectory of any tool, as a table."""

from __future__ import annotations

import sys
from pathlib import Path

import click

from conrod.commands import exit_status
from conrod.commands.table_options import TableOptions
from conrod.errors import InvalidInput

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
    from conrod.confined import confined
    from conrod.files import naming, write_together
    from conrod.selection import TOLERANCES, parse_tolerance, select_scene
    from conrod.table_console import print_table_study
    from conrod.tables.columns import request
    from conrod.tables.estimation import parse_estimate
    from conrod.tables.reading import check_table_file, read_table
    from conrod.tables.study import study_table

    _check_lone(
        {"--engine": engine, "--preset": preset, "--steps-per-rev": steps_per_rev, "--revolutions": revolutions}
    )
    machine = select_scene(scene, assignments)[1]
    allowed = None if tolerance is None else parse_tolerance(tolerance, (*TOLERANCES, "phase"))
    asked = () if options.estimate is None else parse_estimate(options.estimate)
    points = tuple(machine.lengths)
    wanted = request(options.columns, options.units, points)
    table = Path(file)
    check_table_file(table)
    folder, results = _checked_outputs(table, out, document)
    reading = confined(read_table, table, points, wanted, timeout=READING)
    study = study_table(file, scene, machine, reading, asked, allowed)
    with naming("standard output"):
        print_table_study(study)
    batches = []
    if results:
        from conrod.files import single
        from conrod.tables.document import table_document, table_text

        batches.append(single(results, table_text(table_document(study))))
    if folder:
        from conrod.report.trajectory.writer import table_report_batch

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
    from conrod.files import check_apart, file_to_write, folder_to_write
    from conrod.report.apart import check_beside
    from conrod.report.trajectory.folder import FILES, check_table_folder

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
    from conrod.commands.reproduction import command_line
    from conrod.report.reproduction import Reproduction

    given = {
        "--scene": scene,
        "--column": options.columns,
        "--unit": options.units,
        "--estimate": options.estimate,
        "--tolerance": tolerance,
    }
    return Reproduction(command_line("validate", given, assignments, folder)).of(file)
