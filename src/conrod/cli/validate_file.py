"""`conrod validate` of a user's own file: a MuJoCo model, an FMU, or the trajectory of any tool as a table."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from conrod.cli import waiting
from conrod.cli.options import RUNS, refuse
from conrod.cli.validate_request import FMUS, MODEL, MODELS, MOTION, TABLE, TABLES, Judge, Judging, Request
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
from conrod.report.terminal import Part, said, under
from conrod.scenes import Scene
from conrod.studies.execution.local import FILE_TIMEOUT, confined
from conrod.studies.frame.resolve_arguments import REVOLUTIONS, TOLERANCES, parse_tolerance, select_scene

STEPS = 1000  # a revolution, of an FMU
# A table of the most rows that are kept is read in a tenth of it.
READING = 300.0  # [s]


def judging(asked: Request) -> Judging:
    """A user's own model, FMU or table against a scene.

    Raises:
        InvalidInput: it cannot be judged, or an option is not for it.
    """
    file = next(name for name in asked.subjects if name.lower().endswith((*MODELS, *FMUS, *TABLES)))
    path, is_fmu = Path(file), file.lower().endswith(FMUS)
    check_readable(path)
    if len(asked.subjects) > 1:
        others = [name for name in asked.subjects if name != file]
        beside = f"without {others[0]}" if others else "but it is named twice"
        raise InvalidInput(f"{file}: a file is judged on its own, {beside}")
    if asked.scene is None:
        raise InvalidInput(f"{file}: say with --scene what machine it is; `conrod show` lists them")
    refuse(asked, "--scene: it is for a model that is its own reference", "drives")
    limited = ("ledger", "fresh", "jobs", "cluster", "cell_memory") if is_fmu else (RUNS,)
    refuse(asked, "a file: it is for scenes", MOTION, *limited, "quantity")
    scene = select_scene(asked.machine or asked.scene, asked.assignments)
    return _model(path, scene, asked) if file.lower().endswith(MODELS) else _table(path, scene, asked, is_fmu)


def _each(path: Path, timeout: float, judged: Callable[[Scene], Any]) -> Judge:
    """A file judged against each of some scenes."""

    def judge(_: Request, others: Sequence[Mapping[str, Scene]]) -> list[list[Any]]:
        with waiting(path, timeout):
            return [[judged(scene) for scene in scenes.values()] for scenes in others]

    return judge


# -- a model -----------------------------------------------------------------------------------------------------------


def _model(path: Path, named: tuple[str, Scene], asked: Request) -> Judging:
    from conrod.mjcf.loops.scene_study import study

    its_own = "a model: it is judged as it is, in MuJoCo, at its own step"
    refuse(asked, its_own, "engine", "preset", "steps_per_rev", "qualify")
    refuse(asked, "a model: it is for a table", *(() if asked.measured else (TABLE,)))
    check_count("--revolutions", asked.turns, *REVOLUTIONS)
    tolerance = None if asked.tolerance is None else parse_tolerance(asked.tolerance)
    angles = {"--rotation": asked.rotation, "--crank-zero": asked.crank_zero}
    rotation, zero = (None if text is None else parse_quantity(name, text, "rad") for name, text in angles.items())
    given = question_of(asked, named[1]), GivenFrame(asked.plane, rotation, zero), float(asked.turns), tolerance

    def judged(scene: Scene) -> ModelStudy:
        return confined(study, path, (asked.scene, scene), *given, asked.report is not None)

    return Judging(
        kind=user_model.KIND,
        typed={path.stem: str(path)},
        parts=[path.stem],
        judge=_each(path, FILE_TIMEOUT, judged),
        told=lambda found: model_found(*found),
        verdict=user_model.verdict,
        scenes=dict([named]),
        inputs=as_outputs_must_not_be(path),
    )


def question_of(asked: Request, scene: Scene) -> Question:
    """What the options ask of the model.

    Raises:
        InvalidInput: the crank or a point is missing, unknown or given twice.
    """
    mechanism = scene.mechanism()
    observed = [point.name for point in mechanism.observed]
    if asked.crank is None:
        raise InvalidInput("say which joint of the model is driven: --crank JOINT")
    if not asked.points:
        raise InvalidInput(f"say where an observed point of the scene is: --point {observed[0]}=site:NAME")
    places, contacts = places_of(asked.points, observed), len(mechanism.cam_contacts)
    return Question(asked.crank, places, mechanism.mobility, contacts, asked.keyframe, controls_of(asked.controls))


def model_found(found: ModelStudy) -> Iterator[Part]:
    """Verdict, runs, frame, wiring, paths."""
    yield said(f"{found.file}: {user_model.verdict(found)}", found.passed)
    yield user_model.runs_table(found)
    for subject, lines in {"runs": user_model.drive(found), **user_model.findings(found)}.items():
        yield from under(subject, lines)


# -- a table, or an FMU that makes one ---------------------------------------------------------------------------------


def _table(path: Path, named: tuple[str, Scene], asked: Request, is_fmu: bool) -> Judging:
    what, ours = ("an FMU", ()) if is_fmu else ("a table", ("preset", "steps_per_rev", "revolutions"))
    refuse(asked, f"{what}: it is for a model", MODEL)
    refuse(asked, f"{what}: it is for runs of an engine", "engine", "qualify", *ours)
    check_count("--revolutions", asked.turns, *REVOLUTIONS)
    points = tuple(named[1].lengths)
    allowed = None if asked.tolerance is None else parse_tolerance(asked.tolerance, TOLERANCES)
    estimated = () if asked.estimate is None else parse_estimate(asked.estimate)
    wanted = request(asked.columns, asked.units, points)

    def judged(scene: Scene) -> TableStudy:
        with of_file(path):
            if is_fmu:
                steps = STEPS if asked.steps_per_rev is None else asked.steps_per_rev
                reading = run_fmu(path, scene, wanted, asked.preset, steps, float(asked.turns), asked.timeout)
            else:
                reading = confined(read_table, path, points, wanted, timeout=READING)
            return study_table(str(path), str(asked.scene), scene, reading, estimated, allowed)

    return Judging(
        kind=trajectory.KIND,
        typed={trajectory.PART: str(path)},
        parts=[trajectory.PART],
        judge=_each(path, asked.timeout if is_fmu else READING, judged),
        told=lambda found: table_found(*found),
        verdict=trajectory.verdict_text,
        scenes=dict([named]),
        inputs={f"the {what.split()[-1]}": path},
    )


def table_found(found: TableStudy) -> Iterator[Part]:
    """Verdict, errors, the table's columns, what was estimated, notes and causes."""
    yield said(f"{found.file}: {trajectory.verdict_text(found)}", found.passed)
    yield trajectory.errors_table(found)
    yield from under(trajectory.summary_line(found), trajectory.findings(found))
    yield trajectory.columns_table(found)
