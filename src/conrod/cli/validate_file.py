"""`conrod validate` of a user's own file: a MuJoCo model, an FMU, or the trajectory of any tool as a table."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple, TypeAlias

from rich.text import Text

from conrod.cli import FAILED, waiting
from conrod.cli.baseline import Holding, holds
from conrod.cli.options import refuse
from conrod.cli.outputs import outputs
from conrod.cli.validate_request import DEFAULT_REVOLUTIONS, FMUS, MODELS, ModelOptions, Request, TableOptions
from conrod.errors import InvalidInput
from conrod.mechanism.units import check_count, parse_quantity
from conrod.own.files import as_outputs_must_not_be, check_readable, of_file
from conrod.own.fmu import run_fmu
from conrod.own.models.frame import GivenFrame
from conrod.own.models.request import Question, controls_of, places_of
from conrod.own.models.results import ModelStudy
from conrod.own.tables.columns import request
from conrod.own.tables.estimation import parse_estimate
from conrod.own.tables.reading import read_table
from conrod.own.tables.study import TableStudy, study_table
from conrod.report import trajectory, user_model
from conrod.report.kind import Kind
from conrod.report.table import Table
from conrod.report.terminal import console, print_lines, print_table
from conrod.scenes import Scene
from conrod.studies.execution import local
from conrod.studies.frame.baseline import Held
from conrod.studies.frame.resolve_arguments import (
    REVOLUTIONS,
    TOLERANCES,
    parse_tolerance,
    scene_text,
    select_scene,
)
from conrod.studies.frame.writing import naming

Part: TypeAlias = Table | tuple[str, Sequence[str]]  # a table, or sentences under their subject
Judge = Callable[[Path, str | Scene, Request], Any]
STEPS = 1000  # a revolution, of an FMU
# A table of the most rows that are kept is read in a tenth of it.
READING = 300.0  # [s]
TONES = {True: "green", False: "red", None: "default"}


class Subject(NamedTuple):
    """A kind of file: its report, how it is judged, shown and put in words, and the longest time that takes [s]."""

    kind: Kind[Any]
    judge: Judge
    show: Callable[[Any], None]
    verdict: Callable[[Any], str]
    timeout: float


def validate_file(path: Path, scene: str, asked: Request) -> None:
    """Judge a file, print what was found, and write what is to be written; raises InvalidInput as its judge."""
    from conrod.cli.verification import Dossier

    subject = subject_of(path)
    part, its_name = part_of(subject, path), "the FMU" if is_fmu(path) else "the table"
    given = as_outputs_must_not_be(path) if subject is MODEL else {its_name: path}
    name, machine = select_scene(scene, asked.assignments)
    holding = Holding.of(asked, {name: machine})
    files, dossier = outputs(subject.kind, [part], asked, given), Dossier.of(asked, {part: machine})
    with waiting(path, asked.timeout if is_fmu(path) else subject.timeout):
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
    own = replace(asked, assignments=())

    def again(others: Sequence[Mapping[str, Scene]]) -> list[list[Any]]:
        return [[judge(path, scene, own) for scene in scenes.values()] for scenes in others]

    return None if holding is None else holding.held((found,), again)


def print_found(headline: str, passed: bool | None, parts: Iterable[Part]) -> None:
    """Print a verdict, and below it tables, and sentences by subject."""
    out = console()
    print_lines(out, [Text(headline, TONES[passed])])
    for part in parts:
        if isinstance(part, Table):
            print_table(out, part)
        elif part[1]:
            print_lines(out, ("", part[0]))
            print_lines(out, part[1], indent=2)


def _turns(asked: Request) -> float:
    turns = DEFAULT_REVOLUTIONS if asked.revolutions is None else asked.revolutions
    check_count("--revolutions", turns, *REVOLUTIONS)
    return float(turns)


# -- a model ---------------------------------------------------------------------------------------------------------


def judge_model(path: Path, scene: str | Scene, asked: Request) -> ModelStudy:
    """A model against the machine that a scene is, in a process of its own.

    Raises:
        InvalidInput: the model cannot be used, or is not what was said.
    """
    from conrod.own.models.study import study

    its_own = "a model: it is judged as it is, in MuJoCo, at its own step"
    refuse(asked, its_own, "engine", "preset", "steps_per_rev", "qualify")
    refuse(asked, "a model: it is for a table", *(() if asked.measured else (TableOptions,)))
    machine = select_scene(scene, asked.assignments)[1]
    tolerance = None if asked.tolerance is None else parse_tolerance(asked.tolerance)
    angles = {"--rotation": asked.rotation, "--crank-zero": asked.crank_zero}
    rotation, zero = (None if text is None else parse_quantity(name, text, "rad") for name, text in angles.items())
    judged = question_of(asked, machine), GivenFrame(asked.plane, rotation, zero), _turns(asked), tolerance
    return local.confined(study, path, (scene_text(scene), machine), *judged, asked.report is not None)


def question_of(options: ModelOptions, scene: Scene) -> Question:
    """Return what the options ask of the model.

    Raises:
        InvalidInput: the crank or a point is missing, unknown or given twice.
    """
    mechanism = scene.mechanism()
    observed = [point.name for point in mechanism.observed]
    if options.crank is None:
        raise InvalidInput("say which joint of the model is driven: --crank JOINT")
    if not options.points:
        raise InvalidInput(f"say where an observed point of the scene is: --point {observed[0]}=site:NAME")
    places, contacts = places_of(options.points, observed), len(mechanism.cam_contacts)
    controls = controls_of(options.controls)
    return Question(options.crank, places, mechanism.mobility, contacts, options.keyframe, controls)


def print_model_study(found: ModelStudy) -> None:
    """Verdict, runs, frame, wiring, paths."""
    parts: list[Part] = [
        user_model.runs_table(found),
        ("runs", list(user_model.drive(found))),
        *user_model.findings(found).items(),
    ]
    headline = f"{found.file}: {user_model.verdict(found)}"
    print_found(headline, found.passed, parts)


# -- a table, or an FMU that makes one ---------------------------------------------------------------------------------


def judge_table(path: Path, scene: str | Scene, asked: Request) -> TableStudy:
    """A table, or the trajectory of an FMU, against the machine that a scene is.

    Raises:
        InvalidInput: the file or an option cannot be used; those of an engine's runs may not be given for a table.
    """
    runs_itself = is_fmu(path)
    what = "an FMU" if runs_itself else "a table"
    refuse(asked, f"{what}: it is for a model", ModelOptions)
    ours = () if runs_itself else ("preset", "steps_per_rev", "revolutions")
    refuse(asked, f"{what}: it is for runs of an engine", "engine", "qualify", *ours)
    machine = select_scene(scene, asked.assignments)[1]
    allowed = None if asked.tolerance is None else parse_tolerance(asked.tolerance, TOLERANCES)
    estimated = () if asked.estimate is None else parse_estimate(asked.estimate)
    points = tuple(machine.lengths)
    wanted = request(asked.columns, asked.units, points)
    check_readable(path)
    with of_file(path):
        if runs_itself:
            steps = STEPS if asked.steps_per_rev is None else asked.steps_per_rev
            reading = run_fmu(path, machine, wanted, asked.preset, steps, _turns(asked), asked.timeout)
        else:
            reading = local.confined(read_table, path, points, wanted, timeout=READING)
        return study_table(str(path), scene_text(scene), machine, reading, estimated, allowed)


def print_table_study(study: TableStudy) -> None:
    """Verdict, errors, the table's columns, what was estimated, notes and causes."""
    parts: list[Part] = [
        trajectory.errors_table(study),
        (trajectory.summary_line(study), trajectory.findings(study)),
        trajectory.columns_table(study),
    ]
    print_found(f"{study.file}: {trajectory.verdict_text(study)}", study.passed, parts)


MODEL = Subject(user_model.KIND, judge_model, print_model_study, user_model.verdict, local.FILE_TIMEOUT)
TABLE = Subject(trajectory.KIND, judge_table, print_table_study, trajectory.verdict_text, READING)


def is_fmu(path: Path) -> bool:
    """True if a file is an FMU, by its ending."""
    return path.name.lower().endswith(FMUS)


def part_of(subject: Subject, path: Path) -> str:
    """The part of the report that a file is."""
    return trajectory.PART if subject is TABLE else path.stem


def subject_of(path: Path) -> Subject:
    """Kind of a file, by its ending."""
    return MODEL if path.name.lower().endswith(MODELS) else TABLE
