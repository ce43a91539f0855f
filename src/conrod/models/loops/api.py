"""Closed loops of any MuJoCo model, judged by the model's own exact motion; no scene is needed."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Generator, Mapping, Sequence
from contextlib import closing
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from conrod.errors import InvalidInput, as_mapping, as_names
from conrod.execution.local import call_named, call_on_own_files
from conrod.execution.runner import Runs, available_cores
from conrod.execution.tolerances import UnscaledLimit, check_tolerance
from conrod.mechanism.units import check_number
from conrod.mjcf.loop_results import LOOP_UNITS, LoopRequest, LoopStudy
from conrod.mjcf.request import controls_of, size_of_unit
from conrod.models.loops.report import LOOPS_REPORT
from conrod.report.findings import Findings, text_of_call
from conrod.scenes.space import MACHINES
from conrod.user_files.files import check_readable
from conrod.user_files.in_memory import file_of_model
from conrod.user_files.kept_checks import check_or_recall

if TYPE_CHECKING:
    import mujoco

    from conrod.execution.baseline_check import BaselineCheck

STUDY = "conrod.models.loops.study.study_loops"
SHORTEST_RUN, LONGEST_RUN = 1e-6, 1e6  # [s]


def check_loops(
    model: str | Path | mujoco.MjModel | mujoco.MjSpec | Sequence[str | Path],
    *,
    drives: Mapping[str, str] | None = None,
    points: str | Sequence[str] = (),
    keyframe: str | None = None,
    controls: Mapping[str, float] | None = None,
    seconds: float | None = None,
    tolerance: Mapping[str, float | str] | None = None,
    machine: str | None = None,
    unit: str | None = None,
    baseline: str | Path | None = None,
    accept: bool = False,
    progress: Callable[[str], object] = lambda name: None,
    runs: Runs | None = None,
) -> Findings[LoopStudy]:
    """Judge the closed loops of MuJoCo models by their own exact motion.

    Args:
        model: paths of MJCF or binary files, a model in memory, or names of machines in space.
        drives: law of each driven joint, such as `{"hip": "60rpm"}` or `{"boom": "sine:20deg,1Hz"}`.
        points: sites or bodies that are judged; all that the drives move where none is given.
        keyframe: keyframe to assemble the model from; None for its reference pose.
        controls: inputs of actuators where the model runs as its file has it.
        seconds: length of the runs; None for a period of the slowest drive.
        tolerance: largest error by quantity: a number [m, m/s, m/s^2], or a text with a unit, or a share of the range
            of motion (of the largest speed or acceleration), as "0.1mm" or "1e-4L"; a position's bounds the opening of
            the loops, too.
        machine: machine that the model must be: a machine in space by name, or another model's file.
        unit: unit of the model's lengths: m, cm, mm or inch; metres where none is given.
        baseline, accept: as in `validate`.
        progress: called with the name of each model before it is judged.
        runs: as in `check_model`.

    Raises:
        InvalidInput: a model or an argument cannot be used; says what can.
    """
    if seconds is not None:
        check_number("--seconds", seconds, SHORTEST_RUN, LONGEST_RUN, "s")
    laws = as_mapping("drives", drives, "{'hip': '60 rpm'}")
    if not laws and machine is not None and machine in MACHINES:
        laws = dict(MACHINES[machine]().drives)
    places = tuple(place.removeprefix("site:").removeprefix("body:") for place in as_names(points))
    given = {} if tolerance is None else check_tolerance(tolerance, LOOP_UNITS)
    shares = {name: limit.size for name, limit in given.items() if isinstance(limit, UnscaledLimit)}
    allowed = {name: limit for name, limit in given.items() if not isinstance(limit, UnscaledLimit)}
    question = LoopRequest(
        laws, keyframe, controls_of(controls or {}), seconds, places, allowed, machine, size_of_unit(unit), shares
    )
    several = [model] if isinstance(model, str | Path) or not isinstance(model, Sequence) else list(model)
    options = {
        "drive": tuple(f"{joint}={law}" for joint, law in laws.items()), "point": places, "keyframe": keyframe,
        "ctrl": tuple(f"{one}={value:g}" for one, value in (controls or {}).items()), "seconds": seconds,
        "machine": machine, "unit": unit,
        "model": tuple(one for one in several if isinstance(one, str) and one in MACHINES),
    }  # fmt: skip
    baseline_check: BaselineCheck | None = None
    if baseline is not None or accept:
        from conrod.execution.baseline import SPEED_FACTORS as STEP_FACTORS
        from conrod.execution.baseline_check import BaselineCheck
        from conrod.models.loops.baseline_lines import loop_lines

        baseline_check = BaselineCheck.prepare(baseline, {}, options, accept=accept)
    found, typed = dict[str, LoopStudy](), dict[str, str]()
    for one, (part, study) in zip(
        several, _check_all(several, question, 1.0, runs, progress, recall=not baseline_check), strict=True
    ):
        if part in found:
            raise InvalidInput(f"{one}: another has the same name in the report: judge it by itself")
        found[part], typed[part] = study, str(one)
    compared = None
    if baseline_check:
        # No scene's speed drives these: their steps are otherwise in the last bits instead.
        compared = baseline_check.compare(
            list(found.values()),
            lambda _: [[study for _, study in _check_all(several, question, factor, runs)] for factor in STEP_FACTORS],
            loop_lines,
        )
    asked = [str(one) if isinstance(one, str | Path) else "the model" for one in several]
    call = text_of_call(
        "check_loops",
        asked,
        drives=laws or None,
        points=tuple(points),
        keyframe=keyframe,
        controls=controls,
        seconds=seconds,
        tolerance=tolerance,
        machine=machine,
        unit=unit,
    )
    return Findings(LOOPS_REPORT, found, call, typed=typed, baseline=compared)


def _check_all(
    models: Sequence[str | Path | mujoco.MjModel | mujoco.MjSpec],
    question: LoopRequest,
    step_factor: float,
    runs: Runs | None,
    progress: Callable[[str], object] = lambda name: None,
    *,
    recall: bool = False,
) -> Generator[tuple[str, LoopStudy], None, None]:
    """Judge models in turn, and machines in space in parallel; yield name in the report and study of each.

    Args:
        recall: whether the ledger is asked.
    """
    names = [one for one in models if isinstance(one, str) and one in MACHINES]
    jobs = (runs or Runs()).jobs or available_cores()
    with closing(_check_machines(names, question, step_factor, jobs)) as machines:
        for one in models:
            progress(str(one))
            if isinstance(one, str) and one in MACHINES:
                yield one, next(machines)
            else:
                yield _check_file(one, question, step_factor, runs if recall else None)


def _check_file(
    model: str | Path | mujoco.MjModel | mujoco.MjSpec, question: LoopRequest, step_factor: float, runs: Runs | None
) -> tuple[str, LoopStudy]:
    """Judge one model; return its name in the report, and its study."""
    with file_of_model(model) as (path, shown):
        check_readable(path)
        part = shown or path.stem
        study = check_model_loops(path, question, part, step_factor, runs if shown is None else None)
        return part, study if shown is None else replace(study, file=shown)


def _check_machines(
    names: Sequence[str], question: LoopRequest, step_factor: float, jobs: int
) -> Generator[LoopStudy, None, None]:
    """Judge machines in space by their models, driven by their default laws unless others are given."""
    if not names:
        return
    with tempfile.TemporaryDirectory() as folder:
        calls = list[tuple[Path, tuple[str, LoopRequest, str, float]]]()
        for name in names:
            machine = MACHINES[name]()
            own = replace(question, machine=name, drives=question.drives or dict(machine.drives))
            path = Path(folder, f"{name}.xml")
            path.write_text(machine.mjcf, encoding="utf-8", newline="\n")
            calls.append((path, (STUDY, own, name, step_factor)))
        with closing(call_on_own_files(call_named, calls, jobs)) as studies:
            for name, (path, _) in zip(names, calls, strict=True):
                try:
                    study: LoopStudy = next(studies)
                except InvalidInput as error:
                    raise InvalidInput(str(error).replace(f"{path}", name)) from None
                yield replace(study, file=name)


def check_model_loops(
    path: Path, question: LoopRequest, name: str, step_factor: float = 1.0, runs: Runs | None = None
) -> LoopStudy:
    """Judge the loops of a model file in another process; `step_factor` as in `study_loops`."""
    beside = "" if question.machine is None or question.machine in MACHINES else question.machine
    return check_or_recall(STUDY, LoopStudy, path, question, name, step_factor, runs=runs, beside=beside)
