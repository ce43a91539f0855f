"""`conrod validate` of the trajectory of any tool, as a table."""

from __future__ import annotations

import sys
from pathlib import Path

from rich.text import Text

from conrod.cli import options as exit_status
from conrod.cli.options import refuse
from conrod.cli.outputs import outputs, reproduction
from conrod.cli.validate_request import ModelOptions, Request
from conrod.cli.waiting import waiting
from conrod.own.files import check_readable
from conrod.own.tables.columns import request
from conrod.own.tables.estimation import parse_estimate
from conrod.own.tables.reading import read_table
from conrod.own.tables.study import TableStudy, study_table
from conrod.report import trajectory as words
from conrod.report.terminal import console, print_lines, print_table
from conrod.scenes import Scene
from conrod.studies.execution import isolation
from conrod.studies.frame.files import naming
from conrod.studies.frame.resolve_arguments import TOLERANCES, parse_tolerance, scene_text, select_scene

# A table of the most rows that are kept is read in a tenth of it.
READING = 300.0  # [s]


def print_table_study(study: TableStudy) -> None:
    """Print the table's columns, the estimates, the errors, their causes and the verdict."""
    out = console()
    print_lines(out, [words.summary_line(study)])
    print_table(out, words.columns_table(study))
    if study.estimation is not None:
        print_lines(out, [f"estimated from {study.estimation.rows} rows"])
        if estimates := words.estimates_table(study.estimation):
            print_table(out, estimates)
        print_lines(out, words.estimation_lines(study))
    if study.errors:
        print_lines(out, ["errors over the run, normalised by L, ω L, ω² L"])
        print_table(out, words.errors_table(study))
    unused = ", ".join(name or "(no name)" for name in study.unused)
    lines = [words.figure_line(study), words.crank_text(study), f"columns not used: {unused}" if unused else ""]
    lines += [f"note: {note}" for note in study.notes]
    lines += [words.cause_line(study, cause) for cause in study.causes]
    if study.causes == () and study.passed is False:
        lines.append("none of the common causes reproduces the difference")
    colour = {True: "green", False: "red", None: "default"}[study.passed]
    print_lines(out, [*filter(None, lines), Text(words.verdict_text(study), colour)])


def validate_table(file: str, scene: str, asked: Request) -> None:
    """Judge a table, print what was found, and write what is to be written; raises InvalidInput as `judge_table`."""
    files = outputs(words.KIND, [words.PART], asked.out, asked.document, {"the table": Path(file)})
    with waiting(Path(file), READING):
        study = judge_table(Path(file), scene, asked)
    with naming("standard output"):
        print_table_study(study)
    again = reproduction("validate", {words.PART: file}, asked.given, asked.assignments, files.folder)
    files.write({words.PART: study}, again)
    if study.passed is False:
        sys.exit(exit_status.FAILED)


def judge_table(table: Path, scene: str | Scene, asked: Request) -> TableStudy:
    """A table against the machine that a scene is.

    Raises:
        InvalidInput: the table or an option cannot be used; those of an engine's runs may not be given.
    """
    refuse(asked, "a table: it is for a model", ModelOptions)
    refuse(asked, "a table: it is for runs of an engine", "engine", "preset", "steps_per_rev", "revolutions")
    machine = select_scene(scene, asked.assignments)[1]
    allowed = None if asked.tolerance is None else parse_tolerance(asked.tolerance, TOLERANCES)
    estimate = () if asked.estimate is None else parse_estimate(asked.estimate)
    points = tuple(machine.lengths)
    wanted = request(asked.columns, asked.units, points)
    check_readable(table)
    reading = isolation.confined(read_table, table, points, wanted, timeout=READING)
    return study_table(str(table), scene_text(scene), machine, reading, estimate, allowed)
