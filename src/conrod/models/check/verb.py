"""`conrod check`: a user's own MuJoCo model, FMU or table."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from threading import Event
from typing import Any

import click

from conrod.cli import completion, model_completion, options, waiting
from conrod.cli.options import (
    RUNS,
    VerificationOptions,
    columns_in,
    compares_engines,
    controls_in,
    names_in,
    option,
    refuse,
    refuse_others,
    tolerance_in,
)
from conrod.errors import InvalidInput, OutsideLoopsError, named_values
from conrod.slices import has_slice
from conrod.user_files import FILES


@dataclass(frozen=True)
class CheckOptions(VerificationOptions):
    """Request to `conrod check`, as typed; None or empty where nothing was given."""

    scene: str | None = option(
        "--scene",
        metavar="SCENE",
        help="Machine that FILE is to be, see `conrod show`.",
        shell_complete=completion.scenes,
    )
    assignments: tuple[str, ...] = option("--set")
    drives: tuple[str, ...] = option(
        "--drive",
        multiple=True,
        metavar="JOINT=LAW",
        help="No --scene: `60rpm`, `sine:20deg,1Hz`, ...",
        shell_complete=partial(model_completion.names, kinds=("hinge", "slide", "actuator"), ending="="),
    )
    crank: str | None = option(
        "--crank",
        metavar="JOINT",
        help="The hinge that is driven.",
        shell_complete=partial(model_completion.names, kinds=("hinge",)),
    )
    points: tuple[str, ...] = option(
        "--point",
        multiple=True,
        metavar="NAME=site:SITE",
        help="Observed point, or body: or geom:.",
        shell_complete=model_completion.points,
    )
    plane: str | None = option("--plane", metavar="PLANE", help="Directions right and up, e.g. -xz [found].")
    rotation: str | None = option("--rotation", metavar="ANGLE", help="Of the scene's x axis [found].")
    crank_zero: str | None = option("--crank-zero", metavar="ANGLE", help="Hinge at crank angle 0 [found].")
    keyframe: str | None = option("--keyframe")
    controls: tuple[str, ...] = option("--ctrl")
    qualify: bool = option("--qualify", RUNS, is_flag=True, help="Plant known defects too: which are noticed?")
    seconds: float | None = option("--seconds", RUNS, type=float, metavar="S", help="Length of runs with --drive.")
    revolutions: int | None = option("--revolutions", RUNS, type=int, metavar="K", help="Turns of the crank [2].")
    steps_per_rev: int | None = option(
        "--steps-per-rev", RUNS, type=int, metavar="N", help="Steps a turn, of an FMU [1000]."
    )
    torque: str | None = option("--torque", RUNS, metavar="TORQUE", help="On a table's crank: 5 Nm, a column, a file.")
    start: str | None = option("--start", RUNS, metavar="SPEED", help="Of its crank, e.g. 0rpm or 0rpm,30deg.")
    preset: str | None = option("--preset", RUNS)
    cell_timeout: float | None = option("--cell-timeout", RUNS, type=float, hidden=True)  # of an FMU [600 s]
    fresh: bool = option("--fresh", RUNS, is_flag=True, help="Judge a model again that the ledger has judged.")
    ledger: str | None = option("--ledger", RUNS, hidden=True)
    engine: tuple[str, ...] = option("--engine", RUNS)

    @property
    def runs(self) -> Any:
        """How models are checked: the ledger of their findings, whether to reuse it, and a progress bar."""
        from conrod.cli.outputs import ProgressBar
        from conrod.execution.runner import Runs

        return Runs(self.ledger, self.fresh, progress=ProgressBar)


INSPECTION, COMPARISON = "models.inspection", "models.engine_comparison"
MODEL_OPTIONS = ("crank", "points", "plane", "rotation", "crank_zero", "keyframe", "controls", "qualify")
TABLE_OPTIONS = ("columns", "estimate")
TORQUE_OPTIONS = ("torque", "start")
LEDGER_OPTIONS = ("fresh", "ledger")  # of models alone
FMU_RUN_OPTIONS = ("revolutions", "steps_per_rev", "preset", "cell_timeout")
REFUSED_WITH_TORQUE = ("estimate", "baseline", "accept", "verification", "title", "measured", "limits", "uncertainties")
VERIFICATION_OPTIONS = ("title", "measured", "limits", "uncertainties")
OPTIONS_WITH_DRIVE = (
    *("--drive", "--ctrl", "--keyframe", "--point", "--scene", "--seconds", "--tolerance", "--unit", "--engine"),
    *("--out", "--html", "--verification", "--title", "--json", "--baseline", "--accept", "--fresh", "--ledger"),
)


@options.verb(CheckOptions)
@click.argument("files", nargs=-1, metavar="[FILE...]", shell_complete=completion.files_with(FILES))
def check(files: tuple[str, ...], asked: CheckOptions) -> None:
    """Judge a model, FMU or table by --scene or --drive; with neither, inspect it."""
    from conrod.cli.project import check_project_models
    from conrod.scenes import SPATIAL, machines_in_space
    from conrod.user_files import FILES, FMUS, MODELS
    from conrod.user_files.files import check_readable

    if not files:
        check_project_models(given_options=asked != CheckOptions())
        return
    scene, spatial = asked.scene, machines_in_space([*files, asked.scene or ""])
    models = all(name.lower().endswith(MODELS) or name in spatial for name in files)
    alone = scene is None and not asked.drives and not compares_engines(asked, COMPARISON)
    if alone and all(name.lower().endswith(MODELS) for name in files) and has_slice(INSPECTION):
        _inspect(files, asked)
        return
    if models and (scene is None or (scene in spatial and scene != SPATIAL) or scene.lower().endswith(MODELS)):
        judge_loops("check", files, asked)
        return
    name = next((name for name in files if name.lower().endswith(FILES)), files[0])
    if not name.lower().endswith(FILES):
        _refuse_kind(name, FILES)
    check_readable(Path(name))
    if len(files) > 1:
        others = [one for one in files if one != name]
        beside = f"without {others[0]}" if others else "but it is named twice"
        if others and others[0].lower().endswith(".toml"):
            beside += f"; as the machine of {others[0]}: conrod check {name} --scene {others[0]}"
        raise InvalidInput(f"{name}: a file is judged on its own, {beside}")
    if scene is None:
        raise InvalidInput(f"{name}: say with --scene what machine it is; `conrod show` lists them")
    refuse(asked, "--scene: it is for a model that is its own reference", "drives", "seconds")
    if asked.engine:
        raise InvalidInput("--engine does not go with --scene: engines are compared on a model's own --drive")
    if name.lower().endswith(MODELS):
        _judge_model(name, asked)
    else:
        _judge_table(name, asked, is_fmu=name.lower().endswith(FMUS))


def _refuse_kind(name: str, endings: Sequence[str]) -> None:
    """Refuse a scene, which is validated, and a file of no kind that can be judged."""
    from conrod.user_files.files import check_readable

    path = Path(name)
    if (not path.suffix and not path.exists()) or name.lower().endswith(".toml"):
        raise InvalidInput(f"{name}: a scene is validated: conrod validate {name}")
    check_readable(path)
    raise InvalidInput(f"{name}: a file is known by its ending, one of {', '.join(endings)}; save a sheet as CSV")


# -- a model -----------------------------------------------------------------------------------------------------------


def _judge_model(name: str, asked: CheckOptions) -> None:
    from conrod.cli.outputs import check_outputs, exit_with_verdict
    from conrod.execution.local import FILE_TIMEOUT
    from conrod.execution.resolve_arguments import select_scene
    from conrod.execution.tolerances import TOLERANCE_NAMES
    from conrod.mechanism.units import parse_quantity
    from conrod.models.check.api import TURNS, check_model
    from conrod.models.check.report import MODEL_REPORT
    from conrod.user_files.files import protected_model_files

    path, scene = Path(name), select_scene(str(asked.scene), asked.assignments)
    scene = str(asked.scene), scene[1]
    refuse(
        asked, "a model: it is judged as it is, in MuJoCo, at its own step", "preset", "steps_per_rev", "cell_timeout"
    )
    refuse(asked, "a model: it is for a table", *(() if asked.measured else TABLE_OPTIONS), *TORQUE_OPTIONS)
    points = _points_in(asked, scene[1])
    files = check_outputs(MODEL_REPORT, [path.stem], asked, protected_model_files(path))
    dossier = _dossier("check", (name,), asked, dict([scene]))
    angles = {"--rotation": asked.rotation, "--crank-zero": asked.crank_zero}
    rotation, zero = (None if text is None else parse_quantity(one, text, "rad") for one, text in angles.items())
    with waiting(path, FILE_TIMEOUT):
        found = check_model(
            path,
            scene,
            crank=asked.crank,
            points=points,
            plane=asked.plane,
            rotation=rotation,
            crank_zero=zero,
            keyframe=asked.keyframe,
            controls=controls_in(asked.controls),
            unit=None if asked.measured else _unit_of_model(asked),
            revolutions=TURNS if asked.revolutions is None else asked.revolutions,
            tolerance=tolerance_in(asked.tolerance, TOLERANCE_NAMES),
            refine=asked.verification is not None,
            qualify=asked.qualify,
            baseline=asked.baseline,
            accept=asked.accept,
            runs=asked.runs,
        )
    files.print_and_write(found, "check", {path.stem: name}, machines=dict([scene]) if asked.assignments else {})
    if dossier:
        dossier.write(found)
    exit_with_verdict(found)


def _unit_of_model(asked: CheckOptions) -> str | None:
    """Return the unit of a model's lengths; None where none is given.

    Raises:
        InvalidInput: several units are given: a model has one.
    """
    if len(asked.units) > 1:
        raise InvalidInput(f"--unit {' and '.join(asked.units)}: the lengths of a model are in one unit")
    return asked.units[0] if asked.units else None


def _points_in(asked: CheckOptions, scene: Any) -> dict[str, str]:
    """Return the places of observed points that the options name; empty where they are to be found."""
    observed = [point.name for point in scene.mechanism().observed]
    form = f"it as {observed[0]}=site:SITE"
    return named_values(asked.points, "--point", form, "observed point", observed)


# -- a table, or an FMU that makes one ---------------------------------------------------------------------------------


def _judge_table(name: str, asked: CheckOptions, *, is_fmu: bool) -> None:
    from conrod.cli.outputs import check_outputs, exit_with_verdict
    from conrod.exact.link_rotations import rotating_links
    from conrod.execution.resolve_arguments import select_scene
    from conrod.execution.tolerances import ALL_TOLERANCE_NAMES
    from conrod.models.fmu.api import STEPS, TURNS, check_fmu
    from conrod.models.tables.api import READING_TIMEOUT, check_table
    from conrod.models.tables.report import PART, TABLE_REPORT

    path, scene = Path(name), (str(asked.scene), select_scene(str(asked.scene), asked.assignments)[1])
    what = "an FMU" if is_fmu else "a table"
    if not is_fmu and asked.torque is not None:
        _judge_torque_run(path, scene, asked)
        return
    if is_fmu:
        refuse(asked, f"{what}: it is for a table", *TORQUE_OPTIONS)
    refuse(asked, f"{what} without --torque: it is for a run under one", "start")
    refuse(asked, f"{what}: it is for a model", *MODEL_OPTIONS, *LEDGER_OPTIONS)
    refuse(asked, f"{what}: it is for runs of an engine", *(() if is_fmu else FMU_RUN_OPTIONS))
    files = check_outputs(TABLE_REPORT, [PART], asked, {f"the {what.rsplit(maxsplit=1)[-1]}": path})
    dossier = _dossier("check", (name,), asked, dict([scene]))
    common: dict[str, Any] = {
        "columns": columns_in(asked.columns, tuple(scene[1].lengths), rotating_links(scene[1].kinematics)),
        "units": asked.units,
        "estimate": names_in(asked.estimate) or (),
        "tolerance": tolerance_in(asked.tolerance, ALL_TOLERANCE_NAMES),
        "baseline": asked.baseline,
        "accept": asked.accept,
    }
    timeout = options.RUN_TIMEOUT if asked.cell_timeout is None else asked.cell_timeout
    with waiting(path, timeout if is_fmu else READING_TIMEOUT):
        if is_fmu:
            found = check_fmu(
                path,
                scene,
                preset=asked.preset,
                steps_per_rev=STEPS if asked.steps_per_rev is None else asked.steps_per_rev,
                revolutions=TURNS if asked.revolutions is None else asked.revolutions,
                timeout=timeout,
                **common,
            )
        else:
            found = check_table(path, scene, **common)
    files.print_and_write(found, "check", {PART: name}, machines=dict([scene]) if asked.assignments else {})
    if dossier:
        dossier.write(found)
    exit_with_verdict(found)


def _judge_torque_run(path: Path, scene: tuple[str, Any], asked: CheckOptions) -> None:
    """Judge a run under a torque on the crank."""
    from conrod.cli.outputs import check_outputs, exit_with_verdict
    from conrod.mechanism.units import parse_quantity
    from conrod.models.tables.api import READING_TIMEOUT
    from conrod.models.torque_runs.api import check_torque_run
    from conrod.models.torque_runs.comparison import JUDGED_QUANTITIES
    from conrod.models.torque_runs.report import PART, TORQUE_RUN_REPORT

    refuse(asked, "--torque: a run under a torque", *MODEL_OPTIONS, *FMU_RUN_OPTIONS, *REFUSED_WITH_TORQUE)
    files = check_outputs(TORQUE_RUN_REPORT, [PART], asked, {"the table": path})
    start = None
    if asked.start is not None:
        speed, _, angle = asked.start.partition(",")
        start = parse_quantity("--start", speed, "rad/s"), parse_quantity("--start", angle or "0", "rad")
    with waiting(path, READING_TIMEOUT):
        found = check_torque_run(
            path,
            scene,
            str(asked.torque),
            start=start,
            columns=columns_in(asked.columns, tuple(scene[1].lengths)),
            units=asked.units,
            tolerance=tolerance_in(asked.tolerance, JUDGED_QUANTITIES),
        )
    files.print_and_write(found, "check", {PART: str(path)}, machines=dict([scene]) if asked.assignments else {})
    exit_with_verdict(found)


# -- a model of which nothing is said ----------------------------------------------------------------------------------


def _inspect(names: tuple[str, ...], asked: CheckOptions, drives: Mapping[str, str] | None = None, *said: str) -> None:
    """Inspect model files; `drives` are laws of actuators, or of joints outside loops, `said` files said to run."""
    from conrod.models.inspection.verb import inspect_models

    inspect_models(names, asked, _unit_of_model(asked), drives, said)


# -- closed loops ------------------------------------------------------------------------------------------------------


def judge_loops(command: str, names: tuple[str, ...], asked: CheckOptions) -> None:
    """Judge model files and machines in space by their own exact motion."""
    from conrod.cli.outputs import check_outputs, exit_with_verdict
    from conrod.exact.space.drive_laws import FORMS
    from conrod.execution.local import FILE_TIMEOUT
    from conrod.mjcf.loop_results import LOOP_UNITS
    from conrod.models.loops.api import check_loops
    from conrod.models.loops.report import LOOPS_REPORT
    from conrod.scenes.space import MACHINES, SPATIAL
    from conrod.user_files.files import check_readable, protected_model_files

    if compares_engines(asked, COMPARISON):
        from conrod.models.engine_comparison.verb import compare_engines

        compare_engines(names, asked, _unit_of_model(asked))
        return
    refuse_others(asked, "--drive" if asked.drives or asked.scene else "a model without --scene", *OPTIONS_WITH_DRIVE)
    subjects = tuple(MACHINES) if SPATIAL in names else names
    parts, inputs = dict[str, str](), dict[str, Path]()
    for name in subjects:
        part = name if name in MACHINES else Path(name).stem
        if part in parts:
            raise InvalidInput(f"{name}: another has the same name in the report: judge it by itself")
        if name not in MACHINES:
            check_readable(Path(name))
            inputs |= protected_model_files(Path(name))
        parts[part] = name
    if asked.scene and asked.scene not in MACHINES:
        inputs |= protected_model_files(Path(asked.scene))
    drives = named_values(asked.drives, "--drive", f"a joint and its law, JOINT=LAW; LAW: {FORMS}")
    files = check_outputs(LOOPS_REPORT, parts, asked, inputs)
    dossier = _dossier(command, names, asked, {})
    notices = dict[str, Event]()
    with ExitStack() as under_way:

        def begin(name: str) -> None:
            under_way.close()
            notices[name] = under_way.enter_context(waiting(name, FILE_TIMEOUT))

        try:
            found = check_loops(
                subjects,
                drives=drives,
                points=asked.points,
                keyframe=asked.keyframe,
                controls=controls_in(asked.controls),
                seconds=asked.seconds,
                tolerance=tolerance_in(asked.tolerance, LOOP_UNITS),
                machine=asked.scene,
                unit=_unit_of_model(asked),
                baseline=asked.baseline,
                accept=asked.accept,
                progress=begin,
                runs=asked.runs,
            )
        except OutsideLoopsError:
            if not has_slice(INSPECTION) or SPATIAL in names or any(name in MACHINES for name in subjects):
                raise
            under_way.close()
            _inspect(names, asked, drives, *(name for name, printed in notices.items() if printed.is_set()))
            return
    files.print_and_write(found, command, parts)
    if dossier:
        dossier.write(found)
    exit_with_verdict(found)


def _dossier(command: str, names: tuple[str, ...], asked: CheckOptions, scenes: dict[str, Any]) -> Any:
    """Prepare the verification report that --verification asks for; None without this option.

    Raises:
        InvalidInput: the report cannot be made, or options that need --verification were given without.
    """
    if asked.verification is None:
        refuse(asked, "no --verification", *VERIFICATION_OPTIONS)
        return None
    from conrod.verification.verb import Dossier

    return Dossier.prepare(command, names, asked, scenes)
