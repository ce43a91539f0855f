"""`conrod validate` of a user's own file: a MuJoCo model, an FMU, or the trajectory of any tool as a table."""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

from rich.text import Text

from conrod.cli import FAILED
from conrod.cli.baseline import Holding, holds
from conrod.cli.options import refuse
from conrod.cli.outputs import outputs
from conrod.cli.say import waiting
from conrod.cli.validate_request import DEFAULT_REVOLUTIONS, FMUS, MODELS, ModelOptions, Request, TableOptions
from conrod.errors import InvalidInput, unknown_choice
from conrod.mechanism.units import check_count, parse_quantity
from conrod.own.files import as_outputs_must_not_be, check_readable
from conrod.own.fmu.study import in_columns, study_fmu
from conrod.own.models.frame import UNITS, GivenFrame
from conrod.own.models.request import Question, controls_of, places_of
from conrod.own.models.results import ModelStudy
from conrod.own.tables.columns import request
from conrod.own.tables.estimation import parse_estimate
from conrod.own.tables.reading import read_table
from conrod.own.tables.study import TableStudy, study_table
from conrod.report import trajectory, user_model
from conrod.report.kind import Kind
from conrod.report.terminal import console, print_lines, print_table
from conrod.scenes import Scene
from conrod.studies.execution import isolation
from conrod.studies.frame.baseline import Held
from conrod.studies.frame.resolve_arguments import (
    REVOLUTIONS,
    TOLERANCES,
    parse_tolerance,
    scene_text,
    select_scene,
)
from conrod.studies.frame.writing import naming

Judge = Callable[[Path, str | Scene, Request], Any]
STEPS = 1000  # a revolution, of an FMU
OF_MODELS = ("drives", "plane", "rotation", "crank_zero", "length_unit", "keyframe", "controls", "touching")
# A table of the most rows that are kept is read in a tenth of it.
READING = 300.0  # [s]


def validate_file(path: Path, scene: str, asked: Request) -> None:
    """Judge a file, print what was found, and write what is to be written; raises InvalidInput as its judge."""
    from conrod.cli.verification import Dossier

    subject = subject_of(path)
    part, given = (
        subject.part(path),
        as_outputs_must_not_be(path) if subject is MODEL else {"the table" if subject is TABLE else "the FMU": path},
    )
    name, machine = select_scene(scene, asked.assignments)
    holding = Holding.of(asked, {name: machine})
    files, dossier = outputs(subject.kind, [part], asked, given), Dossier.of(asked, {part: machine})
    with waiting(path, asked.timeout if subject is FMU else subject.timeout):
        found = subject.judge(path, scene, asked)
        baseline = held_file(holding, subject.judge, path, asked, found)
    with naming("standard output"):
        subject.show(found)
    files.write({part: found}, "validate", {part: str(path)}, asked)
    if dossier:
        dossier.write(found, subject.verdict(found))
    if not holds(baseline) or found.passed is False:
        sys.exit(FAILED)


def held_file(holding: Holding | None, judge: Judge, path: Path, asked: Request, found: Any) -> Held | None:
    """A study of a file held against the baseline, if any; it is judged again as that needs."""
    own = replace(asked, assignments=(), qualify=False)

    def again(others: Sequence[Mapping[str, Scene]]) -> list[list[Any]]:
        return [[judge(path, scene, own) for scene in scenes.values()] for scenes in others]

    return None if holding is None else holding.held((found,), again)


# -- a model ---------------------------------------------------------------------------------------------------------


def judge_model(path: Path, scene: str | Scene, asked: Request) -> ModelStudy:
    """A model against the machine that a scene is, in a process of its own.

    Raises:
        InvalidInput: the model cannot be used, or is not what was said.
    """
    from conrod.own.models.study import study

    its_own = "a model: it is judged as it is, in MuJoCo, at its own step"
    refuse(asked, its_own, "engine", "preset", "steps_per_rev")
    refuse(asked, "a model: it is for a table", *(() if asked.measured else (TableOptions,)))
    machine = select_scene(scene, asked.assignments)[1]
    tolerance = None if asked.tolerance is None else parse_tolerance(asked.tolerance)
    if asked.qualify and tolerance is None:
        raise InvalidInput(
            "--qualify: without --tolerance none of its runs is judged: say e.g. --tolerance position=1e-4"
        )
    revolutions = DEFAULT_REVOLUTIONS if asked.revolutions is None else asked.revolutions
    check_count("--revolutions", revolutions, *REVOLUTIONS)
    question, given, one = question_of(asked, machine), given_frame(asked), (scene_text(scene), machine)
    judged = question, given, float(revolutions), tolerance, asked.qualify, asked.report is not None
    return isolation.confined(study, path, one, *judged)


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


def print_model_study(found: ModelStudy) -> None:
    """Verdict, frame, wiring, paths, runs."""
    out, style = console(), "green" if found.passed else "red"
    print_lines(out, [Text(f"{found.file}: {user_model.verdict(found)}", style)])
    for title, lines in user_model.findings(found).items():
        print_lines(out, ("", title))
        print_lines(out, lines, indent=2)
    print_lines(out, [""])
    print_table(out, user_model.runs_table(found))
    print_lines(out, user_model.drive(found), indent=2)
    print_table(out, user_model.qualification(found))


# -- a table ---------------------------------------------------------------------------------------------------------


def judge_table(table: Path, scene: str | Scene, asked: Request) -> TableStudy:
    """A table against the machine that a scene is.

    Raises:
        InvalidInput: the table or an option cannot be used; those of an engine's runs may not be given.
    """
    refuse(asked, "a table: it is for a model", ModelOptions)
    refuse(asked, "a table: it is for runs of an engine", "engine", "preset", "steps_per_rev", "revolutions", "qualify")
    machine = select_scene(scene, asked.assignments)[1]
    allowed = None if asked.tolerance is None else parse_tolerance(asked.tolerance, TOLERANCES)
    estimate = () if asked.estimate is None else parse_estimate(asked.estimate)
    points = tuple(machine.lengths)
    wanted = request(asked.columns, asked.units, points)
    check_readable(table)
    reading = isolation.confined(read_table, table, points, wanted, timeout=READING)
    return study_table(str(table), scene_text(scene), machine, reading, estimate, allowed)


def judge_fmu(path: Path, scene: str | Scene, asked: Request) -> TableStudy:
    """An FMU against the machine that a scene is.

    Raises:
        InvalidInput: the FMU or an option cannot be used.
    """
    refuse(asked, "an FMU: it is for scenes or MuJoCo models", *OF_MODELS, "engine", "qualify")
    machine = select_scene(scene, asked.assignments)[1]
    points, steps = tuple(machine.lengths), STEPS if asked.steps_per_rev is None else asked.steps_per_rev
    revolutions = DEFAULT_REVOLUTIONS if asked.revolutions is None else asked.revolutions
    check_count("--revolutions", revolutions, *REVOLUTIONS)
    wanted = request((*asked.columns, *in_columns(asked.points, asked.crank, points)), asked.units, points)
    estimate = () if asked.estimate is None else parse_estimate(asked.estimate)
    allowed = None if asked.tolerance is None else parse_tolerance(asked.tolerance, TOLERANCES)
    one, mode, turns = (scene_text(scene), machine), asked.preset, float(revolutions)
    try:
        return study_fmu(path, one, wanted, mode, steps, turns, estimate, allowed, asked.timeout)
    except InvalidInput as error:
        raise error if str(error).startswith(f"{path}: ") else InvalidInput(f"{path}: {error}") from None


def print_table_study(study: TableStudy) -> None:
    """Print the table's columns, the estimates, the errors, their causes and the verdict."""
    out = console()
    print_lines(out, [trajectory.summary_line(study)])
    print_table(out, trajectory.columns_table(study))
    if study.estimation is not None:
        print_lines(out, [f"estimated from {study.estimation.rows} rows"])
        if estimates := trajectory.estimates_table(study.estimation):
            print_table(out, estimates)
        print_lines(out, trajectory.estimation_lines(study))
    if study.errors:
        print_lines(out, ["errors over the run, normalised by L, ω L, ω² L"])
        print_table(out, trajectory.errors_table(study))
    print_table(out, trajectory.runs_table(study))
    unused = ", ".join(name or "(no name)" for name in study.unused)
    lines = [
        trajectory.figure_line(study),
        trajectory.crank_text(study),
        f"columns not used: {unused}" if unused else "",
    ]
    lines += [f"note: {note}" for note in study.notes]
    lines += [trajectory.cause_line(study, cause) for cause in study.causes]
    if study.causes == () and study.passed is False:
        lines.append("none of the common causes reproduces the difference")
    colour = {True: "green", False: "red", None: "default"}[study.passed]
    print_lines(out, [*filter(None, lines), Text(trajectory.verdict_text(study), colour)])


class Subject(NamedTuple):
    """A kind of file: its report, how it is judged, shown and put in words, and the longest time that takes [s]."""

    kind: Kind[Any]
    judge: Judge
    show: Callable[[Any], None]
    verdict: Callable[[Any], str]
    timeout: float

    def part(self, path: Path) -> str:
        """The part of the report that a file is."""
        return path.stem if self is MODEL else trajectory.PART


MODEL = Subject(user_model.KIND, judge_model, print_model_study, user_model.verdict, isolation.FILE_TIMEOUT)
FMU = Subject(trajectory.KIND, judge_fmu, print_table_study, trajectory.verdict_text, isolation.FILE_TIMEOUT)
TABLE = Subject(trajectory.KIND, judge_table, print_table_study, trajectory.verdict_text, READING)


def subject_of(path: Path) -> Subject:
    """What a file is, by its ending."""
    name = path.name.lower()
    return MODEL if name.endswith(MODELS) else FMU if name.endswith(FMUS) else TABLE
