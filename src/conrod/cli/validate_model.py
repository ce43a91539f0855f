"""`conrod validate` of a user's own MuJoCo model."""

from __future__ import annotations

import sys
from pathlib import Path

from rich.text import Text

from conrod.cli import options as exit_status
from conrod.cli.options import refuse
from conrod.cli.outputs import outputs, reproduction
from conrod.cli.validate_request import ModelOptions, Request, TableOptions
from conrod.cli.waiting import waiting
from conrod.errors import InvalidInput, unknown_choice
from conrod.mechanism.units import check_count, parse_quantity
from conrod.own.files import as_outputs_must_not_be
from conrod.own.models.frame import UNITS, GivenFrame
from conrod.own.models.request import Drive, DrivenRun, Order, Question, controls_of, places_of
from conrod.own.models.study import ModelStudy, study
from conrod.report.terminal import console, print_lines, print_table
from conrod.report.user_model import KIND, drive, findings, runs_table, verdict
from conrod.scenes import Scene
from conrod.studies.execution import isolation
from conrod.studies.frame.files import naming
from conrod.studies.frame.resolve_arguments import MOST_SAMPLES, REVOLUTIONS, parse_tolerance, scene_text, select_scene

DEFAULT_REVOLUTIONS = 2


def print_model_study(found: ModelStudy) -> None:
    """Verdict, frame, wiring, paths, runs."""
    out, style = console(), "green" if found.passed else "red"
    print_lines(out, [Text(f"{found.file}: {verdict(found)}", style)])
    for title, lines in findings(found).items():
        print_lines(out, ("", title))
        print_lines(out, lines, indent=2)
    print_lines(out, [""])
    print_table(out, runs_table(found))
    print_lines(out, drive(found), indent=2)


def validate_model(file: str, scene: str, asked: Request) -> None:
    """Judge a file, print what was found, and write what is to be written; raises InvalidInput as `judge_model`."""
    path = Path(file)
    files = outputs(KIND, [path.stem], asked.out, asked.document, as_outputs_must_not_be(path))
    with waiting(path):
        judged = judge_model(path, scene, asked)
    with naming("standard output"):
        print_model_study(judged)
    again = reproduction("validate", {path.stem: file}, asked.given, asked.assignments, files.folder)
    files.write({path.stem: judged}, again)
    if not judged.passed:
        sys.exit(exit_status.FAILED)


def judge_model(path: Path, scene: str | Scene, asked: Request) -> ModelStudy:
    """A model against the machine that a scene is; all that touches the engine runs in processes of its own.

    Raises:
        InvalidInput: the model cannot be used, or is not what was said.
    """
    from conrod.engines import engine_named
    from conrod.own.models.driving import drive_model
    from conrod.own.models.scanning import scan

    its_own = "a model: it is judged as it is, in MuJoCo, at its own step"
    refuse(asked, its_own, "engine", "preset", "steps_per_rev")
    refuse(asked, "a model: it is for a table", TableOptions)
    machine = select_scene(scene, asked.assignments)[1]
    tolerance = None if asked.tolerance is None else parse_tolerance(asked.tolerance)
    revolutions = DEFAULT_REVOLUTIONS if asked.revolutions is None else asked.revolutions
    check_count("--revolutions", revolutions, *REVOLUTIONS)
    question, given = question_of(asked, machine), given_frame(asked)
    scanned = isolation.confined(scan, path, question)

    def run(drive: Drive, orders: tuple[Order, ...]) -> tuple[DrivenRun, ...]:
        return isolation.confined(drive_model, path, question, scanned, drive, orders)

    engine, turns, one, file = engine_named("mujoco"), float(revolutions), (scene_text(scene), machine), str(path)
    try:
        return study(file, one, question, scanned, given, engine, run, turns, MOST_SAMPLES, tolerance)
    except InvalidInput as error:
        raise error if str(error).startswith(file) else InvalidInput(f"{file}: {error}") from None


def question_of(options: ModelOptions, scene: Scene) -> Question:
    """Return what the options ask of the model.

    Raises:
        InvalidInput: the crank or a point is missing, unknown or given twice.
    """
    mechanism, touching = scene.mechanism(), None
    observed = [point.name for point in mechanism.observed]
    if options.crank is None:
        raise InvalidInput("say which joint of the model is driven: --crank JOINT")
    if not options.points:
        raise InvalidInput(f"say where an observed point of the scene is: --point {observed[0]}=site:NAME")
    if options.touching is not None:
        first, _, second = (part.strip() for part in options.touching.partition(","))
        if not first or not second or "," in second:
            raise InvalidInput(f"--touching {options.touching!r}: give two geoms, CAM,ROLLER")
        if not mechanism.cam_contacts:
            raise InvalidInput(f"--touching {options.touching}: the machine has no cam that touches anything")
        touching = first, second
    places, contacts = places_of(options.points, observed), len(mechanism.cam_contacts)
    controls = controls_of(options.controls)
    return Question(options.crank, places, mechanism.mobility, contacts, touching, options.keyframe, controls)


def given_frame(options: ModelOptions) -> GivenFrame:
    """Frame that the options give.

    Raises:
        InvalidInput: an angle or a unit that is none.
    """
    unit = options.length_unit
    if unit is not None and unit not in UNITS:
        raise unknown_choice("--length-unit", unit, UNITS)
    return GivenFrame(
        plane=options.plane,
        rotation=None if options.rotation is None else parse_quantity("--rotation", options.rotation, "rad"),
        zero=None if options.crank_zero is None else parse_quantity("--crank-zero", options.crank_zero, "rad"),
        unit=None if unit is None else UNITS[unit],
    )
