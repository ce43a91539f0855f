"""Validation of a user's own model on the command line.

`conrod validate` of a user's own MuJoCo model.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING

from conrod.cli import options as exit_status
from conrod.cli.options import ModelOptions
from conrod.cli.outputs import outputs
from conrod.errors import InvalidInput
from conrod.own.models.study import ModelStudy
from conrod.report import user_model_words as words
from conrod.report.terminal import console, print_lines, print_table
from conrod.report.user_model import KIND, runs_table

if TYPE_CHECKING:
    from collections.abc import Mapping

    from conrod.scenes import Scene


def print_model_study(study: ModelStudy) -> None:
    """Verdict, frame, wiring, paths, runs."""
    out = console()
    out.print(f"{study.file}: {words.verdict(study)}", style="green" if study.passed else "red", markup=False,
              soft_wrap=True)  # fmt: skip
    for title, lines in (
        ("frame", words.frame(study)),
        ("wiring", words.wiring(study)),
        ("paths (kinematic mode)", words.paths(study)),
        ("its own settings", [words.own_settings(study), *study.model.remarks]),
    ):
        print_lines(out, ("", title))
        print_lines(out, lines, indent=2)
    out.print()
    if study.runs:
        print_table(out, runs_table(study), folding=("verdict",))
    print_lines(out, words.drive(study), indent=2)


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
    from conrod.cli.model_request import model_command_line
    from conrod.own.files import as_outputs_must_not_be
    from conrod.report.reproduction import Reproduction
    from conrod.studies.frame.files import naming
    from conrod.studies.frame.resolve_arguments import parse_tolerance, select_scene

    for name, value in (("--engine", engine), ("--preset", preset), ("--steps-per-rev", steps_per_rev)):
        if value is not None:
            raise InvalidInput(f"{name} does not go with a model: it is judged as it is, in MuJoCo, at its own step")
    machine = select_scene(scene, assignments)[1]
    asked = None if tolerance is None else parse_tolerance(tolerance)
    name = Path(file).stem
    files = outputs(KIND, [name], out, document, as_outputs_must_not_be(Path(file)))
    judged = judge_model(
        file, (scene, machine), options, DEFAULT_REVOLUTIONS if revolutions is None else revolutions, asked
    )
    with naming("standard output"):
        print_model_study(judged)
    command = None
    if files.folder:
        line = model_command_line(file, scene, options, revolutions, tolerance, assignments, files.folder)
        command = Reproduction(line)
    files.write({name: judged}, command)
    if not judged.passed:
        sys.exit(exit_status.FAILED)


def judge_model(
    file: str,
    scene: tuple[str, Scene],
    options: ModelOptions,
    revolutions: int,
    tolerance: Mapping[str, float] | None,
) -> ModelStudy:
    """Study a model; all that touches the engine runs in processes of its own.

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
    from conrod.studies.execution.isolation import confined
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
