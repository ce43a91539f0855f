"""`conrod validate` of a user's own MuJoCo model."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING

import click

from conrod.commands import exit_status
from conrod.commands.model_options import ModelOptions
from conrod.errors import InvalidInput

if TYPE_CHECKING:
    from collections.abc import Mapping

    from conrod.scenes import Scene
    from conrod.studies.user_model.study import ModelStudy

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
    from conrod.files import naming, write_together
    from conrod.report.user_model.document import outputs_of, results_file
    from conrod.selection import parse_tolerance, select_scene
    from conrod.user_model_console import print_model_study

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
        from conrod.commands.model_request import model_command_line
        from conrod.report.user_model.writer import model_report_batch

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
    from conrod.commands.model_request import given_frame, question_of
    from conrod.confined import confined
    from conrod.engines import engine_named
    from conrod.engines.mujoco.user_model.driving import drive_model
    from conrod.engines.mujoco.user_model.scanning import scan
    from conrod.ranges import check_count
    from conrod.selection import MOST_SAMPLES, REVOLUTIONS
    from conrod.studies.user_model.study import study
    from conrod.user_model import Drive, DrivenRun, Order

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
