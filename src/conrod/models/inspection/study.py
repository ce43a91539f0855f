"""The inspection of a model file, in the order in which a user can act."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np

from conrod.errors import InvalidInput
from conrod.exact.motion import Array
from conrod.mjcf.document import Document
from conrod.mjcf.loading import OWN_POSE, data_at_start
from conrod.mjcf.loop_results import LawComparison, LoopRequest, LoopStudy
from conrod.mjcf.runs import run, user_model_errors
from conrod.mjcf.unit_of_length import controls_in_metres, coordinate_powers
from conrod.models.inspection.actuators import still_bear
from conrod.models.inspection.closing import examine_closing
from conrod.models.inspection.drawn_runs import PoseRecorder, draw_law_run, draw_own_runs
from conrod.models.inspection.drive_choice import choose_drives
from conrod.models.inspection.following import drives_of_joints
from conrod.models.inspection.loading import URDF, load_for_inspection
from conrod.models.inspection.moving import MAX_DOFS, study_moving
from conrod.models.inspection.prepared_document import prepared_document
from conrod.models.inspection.results import SEARCHED_SHARE, Closing, Inspection, InspectionRequest, Moving
from conrod.models.lint.bench import LintBench
from conrod.models.lint.findings import Finding
from conrod.models.lint.linting import judge_rules, prepare_bench
from conrod.models.loops.study import study_loops
from conrod.report.drawing.moving_links import MovingLinks

CPU_TIME = 9.0  # [s] of the runs along its exact motion, after which no further one is made
RUN_TIME, TRIED_STEPS = 0.5, 40  # CPU time [s] of a run that lint repeats, and steps by which it is estimated
SILENT_RESET = "silent-reset"  # a rule of lint: of nearly every file, and of no consequence while nothing diverges


def inspect(path: Path, question: InspectionRequest, name: str) -> Inspection:
    """Inspect a model file; call it in a separate process (`conrod.execution.local`).

    Raises:
        InvalidInput: the model cannot be used, or lacks what the request names.
    """
    model, loading = load_for_inspection(path, question)
    with user_model_errors(path):
        controls = controls_in_metres(model, question.controls, question.unit)
        data, key = data_at_start(model, question.keyframe, controls)
        closing, recorder = examine_closing(model, question.keyframe, question.unit), PoseRecorder()
        moving = study_moving(model, data, question.drives, watch=recorder)
        found = Inspection(str(path), name, mujoco.__version__, question, loading, closing, moving)
    drives, not_judged = drives_of_joints(model, question.drives), ""
    if not question.drives:
        drives, not_judged = choose_drives(
            model, start_pose(model, question), pose_inside(closing, model, question.unit)
        )
    motion = None
    if closing.apart:
        drives, not_judged = {}, "its parts do not meet, so that it is another machine"
    if drives:
        try:
            motion = judge_motion(
                path, question, drives, name, largest_step(model, moving), still_bear(model, data, moving.actuators)
            )
        except InvalidInput as error:
            not_judged = str(error).removeprefix(f"{path}: ")
    found = replace(found, drives=dict(drives), motion=motion, not_judged=not_judged)
    if found.picture is None:
        found = replace(found, drawn=_draw_runs(model, data, key, moving, recorder))
    if model.nflex or model.nv > MAX_DOFS:
        what = "flexes" if model.nflex else f"{model.nv} degrees of freedom"
        return replace(found, lint_notes=(f"its {what} take long: `conrod lint` says what else it finds",))
    findings, notes = lint_findings(path, question, whole=not loading.left_out)
    return replace(found, findings=findings, lint_notes=notes)


def _draw_runs(
    model: mujoco.MjModel, start: mujoco.MjData, keyframe: int | None, moving: Moving, recorder: PoseRecorder
) -> MovingLinks | None:
    """Draw the run along the laws that were given, or the actuators' trials and the file's own run."""
    if moving.followed and recorder.poses:
        return draw_law_run(model, recorder, moving.followed)
    return draw_own_runs(model, start, keyframe, moving.actuators)


def start_pose(model: mujoco.MjModel, question: InspectionRequest) -> Array:
    """Coordinates (nq,) to assemble the loops from: the given keyframe's, or the reference pose."""
    return np.array(data_at_start(model, question.keyframe or OWN_POSE)[0].qpos)


def pose_inside(closing: Closing, model: mujoco.MjModel, unit: float) -> Array | None:
    """Nearest closed pose (nq,) [m, rad] inside all joint ranges; None if the start is inside them."""
    text = closing.start.inside
    return np.array(text.split(), dtype=float) * unit ** coordinate_powers(model) if text else None


def largest_step(model: mujoco.MjModel, moving: Moving) -> float | None:
    """Largest step [s] stable for all actuators, at least the model's; None if none was tried.

    It is that of the integrator that bears more, as settings are tried under several.
    """
    tried = [one.steps for one in moving.actuators if one.steps is not None]
    bounds = [max(steps.largest or 0.0, steps.implicitfast or 0.0) for steps in tried]
    return max(float(model.opt.timestep), min(bounds)) if bounds else None


def judge_motion(
    path: Path,
    question: InspectionRequest,
    drives: Mapping[str, str],
    name: str,
    longest: float | None,
    bears: Callable[[mujoco.MjModel], bool] = lambda model: True,
) -> LoopStudy:
    """Judge the loops by their exact motion with joints driven by laws, and search for settings.

    Args:
        longest: largest step [s] of settings; None without a limit.
        bears: whether actuators bear the model with other settings.

    Raises:
        InvalidInput: the loops cannot be judged.
    """
    asked = LoopRequest(
        drives, question.keyframe, question.controls, unit=question.unit, searched_share=SEARCHED_SHARE,
        largest_step=longest, cpu_time=CPU_TIME,
    )  # fmt: skip
    found = study_loops(path, asked, name, bears=bears)
    if question.drives:
        return found
    # The file does not claim to follow a law that was chosen here: its own run may have another speed.
    return replace(found, shipped=replace(found.shipped, laws=LawComparison()))


def affordable_steps(bench: LintBench) -> int:
    """Number of steps of a run that lint repeats some times: fewer than asked for where each takes long."""
    begun = time.process_time()
    run(bench.model, bench.start, min(TRIED_STEPS, bench.steps))
    each = (time.process_time() - begun) / TRIED_STEPS
    return min(bench.steps, max(TRIED_STEPS, round(RUN_TIME / max(each, 1e-9))))


def lint_findings(
    path: Path, question: InspectionRequest, *, whole: bool
) -> tuple[tuple[Finding, ...], tuple[str, ...]]:
    """Lint a model; return the findings, and notes on how they were judged.

    Args:
        whole: whether all that the file names is there.
    """
    try:
        is_text = whole and path.suffix.lower() != URDF
        document = Document(path, question.unit) if is_text else prepared_document(path, question.unit, whole=whole)
        controls = controls_in_metres(document.model, question.controls, question.unit)
        bench, _ = prepare_bench(document, question.keyframe, None, controls)
        steps = affordable_steps(bench)
        findings, notes, _ = judge_rules(replace(bench, steps=steps), ())
    except InvalidInput as error:
        return (), (f"lint does not take it: {str(error).removeprefix(f'{path}: ')}",)
    if steps < bench.steps:
        notes = (*notes, f"judged by a run of {steps} steps, as each takes long; `conrod lint` makes {bench.steps}")
    resets = any(one.rule == SILENT_RESET and one.severity.value == "error" for one in findings)
    return tuple(one for one in findings if resets or one.rule != SILENT_RESET), notes
