"""A user's own model, FMU or table, judged by the exact motion of the scene that it is to be."""

from __future__ import annotations

import math
import tempfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from inspect import signature
from pathlib import Path
from typing import Any

from conrod.api.baselines import BaselineCheck
from conrod.api.files import FILES, FMUS, TABLES
from conrod.api.in_memory import Model, columns_of, file_of_model, file_of_table
from conrod.api.keywords import refuse_old_keywords
from conrod.api.loops import check_loops
from conrod.api.validate import validate
from conrod.errors import InvalidInput, as_mapping, as_names, unknown_choice
from conrod.mechanism.units import check_count, check_number
from conrod.own.files import check_readable, name_file_in_errors
from conrod.own.models.frame import GivenFrame
from conrod.own.models.request import ModelRequest, controls_of, places_of
from conrod.own.models.results import ModelStudy
from conrod.own.tables.columns import column_request
from conrod.own.tables.estimation import check_estimated
from conrod.own.tables.study import TableStudy, study_table
from conrod.report import trajectory, user_model
from conrod.report.findings import Findings, text_of_call
from conrod.scenes import Scene
from conrod.scenes.space import MACHINES
from conrod.studies.execution.local import call_on_file
from conrod.studies.execution.runner import RUN_TIMEOUT, Runs
from conrod.studies.frame.resolve_arguments import (
    REVOLUTIONS_RANGE,
    TOLERANCE_NAMES,
    OneScene,
    check_tolerance,
    scene_by_name,
)

STEPS = 1000  # a revolution, of an FMU
READING_TIMEOUT = 300.0  # [s]; a table of the most rows that are kept is read in a tenth of it
TURNS = 2


def check(subject: Any, scene: OneScene | None = None, **arguments: Any) -> Findings[Any]:
    """Judge a scene, a model, an FMU or a table, by the function for its kind.

    Args:
        subject: a scene (a name, a mechanism file, or a `Scene`), a model (the path of an MJCF or binary file, or one
            in memory), an FMU (its path), or a table (the path of a file, a data frame, or a mapping of numpy
            arrays (T,), with `C` of shape (T, 2) for `C.x` and `C.y`).
        scene: the machine that a model, an FMU or a table is to be; none for a model whose joints are driven by laws.
        arguments: as of `validate`, `check_model`, `check_fmu`, `check_table` or `check_loops`. A scene's runs are made
            here and now unless `runs` says otherwise: no result of an earlier day answers for it.

    Raises:
        InvalidInput: the subject, the scene or an argument cannot be used.
    """
    refuse_old_keywords(arguments)
    name = str(subject).lower() if isinstance(subject, str | Path) else ""
    if isinstance(subject, str) and subject in MACHINES:
        return check_loops(subject, **_keywords(check_loops, "a machine in space", scene, arguments, "machine"))
    if isinstance(subject, Scene) or (name and not name.endswith(FILES)):
        if scene is not None:
            raise InvalidInput(f"scene={scene!r} is for a file: a scene is judged as it is")
        with tempfile.TemporaryDirectory() as folder:
            runs = Runs(ledger=Path(folder, "ledger.sqlite"), fresh=True, jobs=1)
            return validate(subject, **{"runs": runs, **_keywords(validate, "a scene", None, arguments)})
    is_table = name.endswith(TABLES) or columns_of(subject) is not None
    if "drives" in arguments and not is_table and not name.endswith(FMUS):
        return check_loops(subject, **_keywords(check_loops, "a model with drives", scene, arguments, "machine"))
    if scene is None:
        what = str(subject) if name else f"a {type(subject).__name__}"
        raise InvalidInput(f"{what}: say with scene=... what machine it is")
    if name.endswith(FMUS):
        return check_fmu(subject, **_keywords(check_fmu, "an FMU", scene, arguments))
    if is_table:
        return check_table(subject, **_keywords(check_table, "a table", scene, arguments))
    given = _keywords(check_model, "a model", scene, arguments)
    return check_model(subject, **{"crank": None, "points": {}, **given})


def _keywords(
    function: Callable[..., Any], subject: str, scene: OneScene | None, given: Mapping[str, Any], name: str = "scene"
) -> dict[str, Any]:
    """Arguments of a function, with the scene under a name.

    Args:
        subject: what the function judges, for the message.

    Raises:
        InvalidInput: an argument is none of the function's; says whose it is.
    """
    users: dict[str, Callable[..., Any]] = {
        "scenes": validate, "models": check_model, "FMUs": check_fmu, "tables": check_table, "closed loops": check_loops
    }  # fmt: skip
    known = {user: [*signature(one).parameters][1:] for user, one in users.items()}
    taken = [*signature(function).parameters][1:]
    for argument in given:
        if argument not in taken:
            others = [user for user, names in known.items() if argument in names]
            if others:
                raise InvalidInput(f"{argument} does not go with {subject}: it is for {', '.join(others)}")
            raise unknown_choice("keyword", argument, [one for one in taken if one not in ("scene", "progress")])
    return dict(given) if scene is None else {name: str(scene) if name == "machine" else scene, **given}


def check_model(
    model: Model,
    scene: OneScene,
    *,
    crank: str | None = None,
    points: Mapping[str, str] | None = None,
    plane: str | None = None,
    rotation: float | None = None,
    crank_zero: float | None = None,
    keyframe: str | None = None,
    controls: Mapping[str, float] | None = None,
    revolutions: int = TURNS,
    tolerance: Mapping[str, float] | None = None,
    refine: bool = False,
    baseline: str | Path | None = None,
    accept: bool = False,
) -> Findings[ModelStudy]:
    """Judge a MuJoCo model by the exact motion of the scene that it is to be.

    The file is judged as it stands first, by its own actuators from its own start; then with conrod's drive.

    Args:
        model: path of an MJCF or binary file, or a model in memory.
        crank: joint of the model that is driven.
        points: place of each observed point in the model, such as {"C": "site:tip"}; "body:" and "geom:" likewise.
        plane: directions right and up of the model that are the scene's x and y, such as "-xz"; None to find them.
        rotation: of the scene's x axis in that plane [rad]; None to find it.
        crank_zero: hinge angle at which the crank angle is 0 [rad]; None to find it.
        keyframe: to start from; None for the first, "qpos0" for none.
        controls: inputs of actuators in place of the keyframe's, in MuJoCo's units.
        tolerance: largest error by quantity, normalised.
        refine: run the model at other steps too, for the observed order.
        revolutions, baseline, accept: as of `validate`.

    Raises:
        InvalidInput: the model or an argument cannot be used; says what can.
    """
    with file_of_model(model) as (path, shown):
        check_readable(path)
        check_count("--revolutions", revolutions, *REVOLUTIONS_RANGE)
        name, machine = scene_by_name(scene)
        points = as_mapping("points", points, "{'C': 'site:tip'}")
        question = question_on_model(machine, crank, points, keyframe, controls or {})
        for angle, given in (("rotation", rotation), ("crank_zero", crank_zero)):
            if given is not None:
                check_number(angle, given, -math.inf, math.inf, "rad")
        frame = GivenFrame(plane, rotation, crank_zero)
        allowed = None if tolerance is None else check_tolerance(tolerance)
        words: dict[str, Any] = {
            "crank": crank, "point": tuple(f"{one}={where}" for one, where in points.items()), "plane": plane,
            "rotation": rotation, "crank-zero": crank_zero, "keyframe": keyframe,
            "ctrl": tuple(f"{one}={value:g}" for one, value in (controls or {}).items()),
            "revolutions": None if revolutions == TURNS else revolutions,
        }  # fmt: skip
        check = BaselineCheck.prepare(baseline, {name: machine}, words, accept=accept)

        def find(several: Sequence[Mapping[str, Scene]]) -> list[list[ModelStudy]]:
            from conrod.mjcf.loops.scene_study import study_scene_model

            given = question, frame, float(revolutions), allowed, refine
            return [
                [call_on_file(study_scene_model, path, (name, one), *given) for one in scenes.values()]
                for scenes in several
            ]

        ((found,),) = find([{name: machine}])
        compared = check.compare([found], find) if check else None
    part = path.stem if shown is None else shown
    call = text_of_call(
        "check_model",
        shown or str(path),
        name,
        crank=crank,
        points=dict(points),
        plane=plane,
        rotation=rotation,
        crank_zero=crank_zero,
        keyframe=keyframe,
        controls=controls,
        revolutions=words["revolutions"],
        tolerance=tolerance,
    )
    parts = {part: replace(found, file=shown or found.file)}
    return Findings(user_model.KIND, parts, call, typed={part: str(path)}, baseline=compared)


def question_on_model(
    scene: Scene, crank: str | None, points: Mapping[str, str], keyframe: str | None, controls: Mapping[str, float]
) -> ModelRequest:
    """The request for a model: its crank and observed points, and the mobility of its scene.

    Raises:
        InvalidInput: the crank or a point is missing or unknown.
    """
    mechanism = scene.mechanism()
    observed = [point.name for point in mechanism.observed]
    if crank is None:
        raise InvalidInput("say which joint of the model is driven: --crank JOINT")
    if not points:
        raise InvalidInput(f"say where an observed point of the scene is: --point {observed[0]}=site:NAME")
    places, contacts = places_of(points, observed), len(mechanism.cam_contacts)
    return ModelRequest(crank, places, mechanism.mobility, contacts, keyframe, controls_of(controls))


def check_table(
    table: str | Path | Mapping[str, Any] | Any,
    scene: OneScene,
    *,
    columns: Mapping[str, str] | None = None,
    units: str | Sequence[str] = (),
    estimate: str | Sequence[str] = (),
    tolerance: Mapping[str, float] | None = None,
    baseline: str | Path | None = None,
    accept: bool = False,
) -> Findings[TableStudy]:
    """Judge a trajectory, measured or simulated by any tool, by the exact motion of a scene.

    Args:
        table: path of a file, a data frame (pandas, polars, pyarrow), or a mapping of numpy arrays (T,).
        columns: heading of each quantity's column, such as {"C.x": "px"}, where it is not found by its heading.
        units: of columns whose heading has none, such as ("mm", "deg").
        estimate: unknowns to estimate first, of "time" and "phase".
        tolerance: largest error by quantity, normalised; None judges nothing.
        scene, baseline, accept: as of `check_model`.

    Raises:
        InvalidInput: the table or an argument cannot be used; says what can.
    """
    with file_of_table(table) as (path, shown):
        check_readable(path)
        name, machine = scene_by_name(scene)
        points, units, estimate = tuple(machine.lengths), as_names(units), as_names(estimate)
        wanted = column_request(columns or {}, units, points)

        def judge(one: Scene) -> TableStudy:
            from conrod.own.tables.reading import read_table

            reading = call_on_file(read_table, path, points, wanted, timeout=READING_TIMEOUT)
            return study_table(str(path), name, one, reading, check_estimated(estimate), allowed)

        allowed = None if tolerance is None else check_tolerance(tolerance, TOLERANCE_NAMES)
        check_estimated(estimate)
        words: dict[str, Any] = {"column": _texts(columns), "unit": units, "estimate": ",".join(estimate)}
        given = {"columns": columns, "units": units, "estimate": estimate, "tolerance": tolerance}
        call = text_of_call("check_table", shown or str(path), name, **given)
        return _table_findings(judge, path, shown, (name, machine), words, (baseline, accept), call)


def check_fmu(
    fmu: str | Path,
    scene: OneScene,
    *,
    columns: Mapping[str, str] | None = None,
    units: str | Sequence[str] = (),
    estimate: str | Sequence[str] = (),
    preset: str | None = None,
    steps_per_rev: int = STEPS,
    revolutions: int = TURNS,
    tolerance: Mapping[str, float] | None = None,
    timeout: float = RUN_TIMEOUT,
    baseline: str | Path | None = None,
    accept: bool = False,
) -> Findings[TableStudy]:
    """Run an FMU and judge its trajectory by the exact motion of a scene.

    Args:
        fmu: path of an FMU 2.0 or 3.0.
        preset: interface of the FMU that is run, "model-exchange" or "co-simulation"; None for what it has.
        steps_per_rev: communication steps in one revolution.
        timeout: longest wall time of the run [s].
        scene, columns, units, estimate, revolutions, tolerance, baseline, accept: as of `check_table`.

    Raises:
        InvalidInput: the FMU or an argument cannot be used; says what can.
    """
    path = Path(fmu)
    check_readable(path)
    check_count("--revolutions", revolutions, *REVOLUTIONS_RANGE)
    name, machine = scene_by_name(scene)
    units, estimate = as_names(units), as_names(estimate)
    wanted = column_request(columns or {}, units, tuple(machine.lengths))
    allowed = None if tolerance is None else check_tolerance(tolerance, TOLERANCE_NAMES)

    def judge(one: Scene) -> TableStudy:
        from conrod.own.fmu import run_fmu

        reading = run_fmu(path, one, wanted, preset, steps_per_rev, float(revolutions), timeout)
        return study_table(str(path), name, one, reading, check_estimated(estimate), allowed)

    words: dict[str, Any] = {
        "column": _texts(columns),
        "unit": units,
        "estimate": ",".join(estimate),
        "preset": preset,
    }
    words |= {"steps-per-rev": None if steps_per_rev == STEPS else steps_per_rev}
    words |= {"revolutions": None if revolutions == TURNS else revolutions}
    given = {"columns": columns, "units": units, "estimate": estimate, "preset": preset, "tolerance": tolerance}
    given |= {"steps_per_rev": words["steps-per-rev"], "revolutions": words["revolutions"]}
    call = text_of_call("check_fmu", str(path), name, **given)
    return _table_findings(judge, path, None, (name, machine), words, (baseline, accept), call)


def _table_findings(
    judge: Any,
    path: Path,
    shown: str | None,
    scene: tuple[str, Scene],
    words: Mapping[str, Any],
    baseline: tuple[str | Path | None, bool],
    call: str,
) -> Findings[TableStudy]:
    """Judge a table, and compare it with its baseline."""
    check = BaselineCheck.prepare(baseline[0], dict([scene]), words, accept=baseline[1])

    def find(several: Sequence[Mapping[str, Scene]]) -> list[list[TableStudy]]:
        with name_file_in_errors(path):
            return [[judge(one) for one in scenes.values()] for scenes in several]

    ((found,),) = find([dict([scene])])
    compared = check.compare([found], find) if check else None
    return Findings(
        trajectory.KIND, {trajectory.PART: replace(found, file=shown or found.file)}, call,
        typed={trajectory.PART: str(path)}, baseline=compared,
    )  # fmt: skip


def _texts(columns: Mapping[str, str] | None) -> tuple[str, ...]:
    return tuple(f"{name}={heading}" for name, heading in (columns or {}).items())
