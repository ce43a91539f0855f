"""What the command line prints of a user's own model.

`conrod validate` of a user's own MuJoCo model.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING

import click
from rich.markup import escape
from rich.table import Table

from conrod.cli import options as exit_status
from conrod.cli.model_options import ModelOptions
from conrod.errors import InvalidInput
from conrod.own.models.study import ModelStudy
from conrod.report.terminal import console
from conrod.report.user_model import words
from conrod.report.user_model import words as run_words

if TYPE_CHECKING:
    from collections.abc import Mapping

    from conrod.scenes import Scene


def print_model_study(study: ModelStudy) -> None:
    """Verdict, frame, wiring, paths, runs."""
    out = console()
    colour = "green" if study.passed else "red"
    out.print(f"[{colour}]{escape(study.file)}: {escape(words.verdict(study))}[/]", soft_wrap=True)
    for title, lines in (
        ("frame", words.frame(study)),
        ("wiring", words.wiring(study)),
        ("paths (kinematic mode)", words.paths(study)),
        ("its own settings", [run_words.own_settings(study), *study.model.remarks]),
    ):
        out.print(f"\n{title}")
        for line in lines:
            out.print(f"  {escape(line)}", soft_wrap=True)
    out.print()
    if study.runs:
        table = Table(title="driven: largest error, normalised by L, omega L, omega^2 L", title_justify="left")
        for heading in run_words.HEAD:
            table.add_column(heading, justify="left" if heading in ("settings", "verdict") else "right")
        for row in run_words.rows(study):
            table.add_row(*(escape(cell) for cell in row))
        out.print(table)
    for line in run_words.drive(study):
        out.print(f"  {escape(line)}", soft_wrap=True)


DEFAULT_REVOLUTIONS = 2


def validate_model(
    file: str,
    scene: str,
    options: ModelOptions,
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
    """Judge a file against the machine that a scene is."""
    from conrod.report.user_model.page import outputs_of, results_file
    from conrod.studies.frame.files import naming, write_together
    from conrod.studies.frame.resolve_arguments import parse_tolerance, select_scene

    for name, value in (("--engine", engine), ("--preset", preset), ("--steps-per-rev", steps_per_rev)):
        if value is not None:
            raise InvalidInput(f"{name} does not go with a model: it is judged as it is, in MuJoCo, at its own step")
    machine = select_scene(scene, assignments)[1]
    asked = None if tolerance is None else parse_tolerance(tolerance)
    folder, target = outputs_of(file, out, document)
    judged = judge_model(
        file, (scene, machine), options, DEFAULT_REVOLUTIONS if revolutions is None else revolutions, asked
    )
    with naming("standard output"):
        print_model_study(judged)
    batches = [results_file(judged, target)] if target else []
    if folder:
        from conrod.cli.model_request import model_command_line
        from conrod.report.user_model.page import model_report_batch

        command = model_command_line(file, scene, options, revolutions, tolerance, assignments, folder)
        batches.append(model_report_batch(judged, folder, command))
    write_together(batches)
    if folder:
        click.echo(f"report: {folder / Path(file).stem}.md")
    if not judged.passed:
        sys.exit(exit_status.FAILED)


def judge_model(
    file: str,
    scene: tuple[str, Scene],
    options: ModelOptions,
    revolutions: int,
    tolerance: Mapping[str, float] | None,
) -> ModelStudy:
    """What is found of a model; all that touches the engine is in processes of its own.

    Raises:
        InvalidInput: the model cannot be used, or is not what was said.
    """
    from conrod.cli.model_request import given_frame, question_of
    from conrod.engines import engine_named
    from conrod.mechanism.units import check_count
    from conrod.own.models.driving import drive_model
    from conrod.own.models.request import Drive, DrivenRun, Order
    from conrod.own.models.scanning import scan
    from conrod.own.models.study import study
    from conrod.studies.execution.confined import confined
    from conrod.studies.frame.resolve_arguments import MOST_SAMPLES, REVOLUTIONS

    check_count("--revolutions", revolutions, *REVOLUTIONS)
    question, given, path = question_of(options, scene[1]), given_frame(options), Path(file)
    scanned = confined(scan, path, question)

    def run(drive: Drive, orders: tuple[Order, ...]) -> tuple[DrivenRun, ...]:
        return confined(drive_model, path, question, scanned, drive, orders)

    try:
        return study(
            file,
            scene,
            question,
            scanned,
            given,
            engine_named("mujoco"),
            run,
            float(revolutions),
            MOST_SAMPLES,
            tolerance,
        )
    except InvalidInput as error:
        raise error if str(error).startswith(file) else InvalidInput(f"{file}: {error}") from None
