"""All rules applied to a model, and the safe fixes made. Nothing is written but by the caller."""

from __future__ import annotations

import copy
import math
import time
from pathlib import Path

import mujoco
import numpy as np

from conrod.engines.mujoco.recorder import warnings_kept_quiet
from conrod.errors import InvalidInput, unknown_choice
from conrod.exact.motion import Array
from conrod.mjcf.equalities import rows_at
from conrod.mjcf.lint.bench import Bench
from conrod.mjcf.lint.document import Document, differing
from conrod.mjcf.lint.edits import Edit, SetAttribute, SetOption
from conrod.mjcf.lint.findings import DEFAULT_STEPS, MOST_STEPS, Finding, Fixed, Harm, Note, Report, Request
from conrod.mjcf.lint.rules import RULES, SOLVER, STEP
from conrod.mjcf.lint.runs import Observed, Start, run
from conrod.mjcf.lint.solver import longest_stable
from conrod.own.models.loading import keyframe_to_start_from, listed, name_or_number, names_of, start_words
from conrod.own.models.points import KINDS, Crank, crank_of, find_crank, find_point
from conrod.studies.frame.paired_timing import Clock

# Flywheel of a crank, over the inertia that the machine shows to it: what the machine exchanges with it in a turn then
# changes the speed by a per cent.
FLYWHEEL = 100.0
# A speed that is off by more, because of dampers, friction or a servo on the crank, asks for a heavier flywheel: by
# what is missing and a little more, at most so often.
KEPT, SPARE, ATTEMPTS = 0.01, 1.25, 4


def lint(path: Path, request: Request, clock: Clock = time.thread_time_ns) -> Report:
    """Search a model for what its motion does not need, and for what will cause trouble.

    To be called in a process of its own, see `conrod.studies.execution.isolation`.

    Args:
        path: an MJCF file.
        clock: for the costs.

    Raises:
        InvalidInput: the file cannot be used, or has not what the request names.
    """
    check_rules(request.ignored)
    document = Document(path)
    with warnings_kept_quiet():
        try:
            return judged(prepared(document, request, clock), str(path), request)
        except mujoco.FatalError as error:
            raise InvalidInput(f"{path}: MuJoCo gives up on it: {' '.join(str(error).split())}") from None
        except InvalidInput as error:
            raise InvalidInput(f"{path}: {error}") from None


def check_rules(names: tuple[str, ...]) -> None:
    """Refuse a name that no rule has."""
    for name in names:
        if name not in {rule.name for rule in RULES}:
            raise unknown_choice("rule", name, [rule.name for rule in RULES])


def judged(bench: Bench, path: str, request: Request) -> Report:
    """All rules."""
    sentence = described(bench, request)
    longest = longest_stable(bench)
    steady, notes = _steady(bench, longest)
    solved = steady
    findings: list[Finding] = []
    for rule in RULES:
        if rule.name in request.ignored or (rule.needs_motion and longest is None):
            continue
        for answer in rule.answers({STEP.name: bench, SOLVER.name: steady}.get(rule.name, solved)):
            if isinstance(answer, Note):
                notes.append(answer)
                continue
            findings.append(answer)
            if rule.name == SOLVER.name:
                notes.append(Note("the rules after it are judged with the solver as it should be", rule=rule.name))
                solved = steady.with_edits(answer.edits)
    findings.sort(key=lambda finding: (list(Harm).index(finding.harm), -(finding.change or 0.0)))
    fixed = None if request.fix_folder is None else fix(steady, tuple(findings), Path(request.fix_folder))
    return Report(path, sentence, tuple(findings), tuple(notes), fixed)


def _steady(bench: Bench, longest: float | None) -> tuple[Bench, list[Note]]:
    """The model with a step at which it runs: what the step makes wrong must not be laid to something else."""
    if longest is None:
        return bench, [Note("rules that need a run that holds together are not judged", rule=STEP.name)]
    if longest < float(bench.model.opt.timestep):
        step = 0.5 * longest
        return bench.with_step(step), [Note(f"all other rules are judged with a step of {step:.4g} s", rule=STEP.name)]
    return bench, []


def fix(bench: Bench, findings: tuple[Finding, ...], folder: Path) -> Fixed:
    """The model with the safe edits of all findings, as a file of a folder.

    Raises:
        InvalidInput: from there it would not find what it needs.
    """
    edits: tuple[Edit, ...] = tuple(edit for finding in findings if finding.safe for edit in finding.edits)
    if not edits:
        return Fixed()
    document, moved = bench.document, bench.document.moved(folder)
    try:
        other = differing(bench.copy(edits), document.compiled((*bench.drive, *edits, *moved), folder))
    except ValueError as error:
        other = " ".join(str(error).split())
    if other:
        raise InvalidInput(f"--fix: write it into {document.folder}, beside the model: elsewhere it differs ({other})")
    lines = [f"    {edit.words}" for edit in edits]
    comment = "\n".join(("", "  With these changes by the lint command of conrod:", *lines, "  "))
    return Fixed(document.text((*edits, *moved), comment), edits, bench.change(edits), bench.cost(edits))


# -- the run -----------------------------------------------------------------------------------------------------------


def prepared(document: Document, request: Request, clock: Clock) -> Bench:
    """The model on the bench, as it was asked for."""
    model = document.model
    if not model.nv:
        raise InvalidInput("nothing in the model can move")
    data = mujoco.MjData(model)
    keyframe = keyframe_to_start_from(model, request.keyframe)
    if keyframe is not None:
        mujoco.mj_resetDataKeyframe(model, data, keyframe)
    step = float(model.opt.timestep)
    steps = DEFAULT_STEPS if request.seconds is None else max(2, math.ceil(request.seconds / step))
    if steps > MOST_STEPS:
        raise InvalidInput(f"{request.seconds:g} s are {steps} steps of {step:g} s: at most {MOST_STEPS}")
    drive: tuple[Edit, ...] = ()
    if request.speed is not None:
        drive = driven(document, data, driven_crank(model, request.crank), request.speed, steps)
    elif request.crank is not None:
        raise InvalidInput(f"--crank {request.crank}: say with --scene how fast it turns")
    points = [find_point(model, place) for place in request.points]
    observed = Observed(*(tuple(point.index for point in points if point.kind == kind) for kind in KINDS))
    return Bench(document, Start.of(data), steps, observed, keyframe=keyframe, drive=drive, clock=clock)


def described(bench: Bench, request: Request) -> str:
    """The run in a sentence."""
    model = bench.model
    start = start_words(model, bench.keyframe)
    run = f"run of {bench.steps} steps of {float(model.opt.timestep):g} s from {start}"
    if request.speed is None:
        return f"a free {run}"
    crank = driven_crank(model, request.crank)
    off = speed_off(np.array([state.qvel[crank.rate] for state in bench.run.states]), request.speed)
    name = name_or_number(model, "joint", crank.joint)
    return f"a driven {run}; {name} turns at {request.speed:.4g} rad/s, kept to {100.0 * off:.2g} %"


# -- a crank that is driven -------------------------------------------------------------------------------------------


def driven_crank(model: mujoco.MjModel, name: str | None) -> Crank:
    """The hinge of a name, or the only one on the frame.

    Raises:
        InvalidInput: there is none, it is no hinge, or there is no telling which.
    """
    if name is not None:
        return find_crank(model, name)
    hinges = np.flatnonzero(model.jnt_type == mujoco.mjtJoint.mjJNT_HINGE).tolist()
    on_frame = [j for j in hinges if model.body_weldid[model.body_parentid[model.jnt_bodyid[j]]] == 0]
    if len(on_frame) != 1:
        names = listed(names_of(model, "joint")) or "none has a name"
        raise InvalidInput(f"{len(on_frame)} hinges are on the frame: name the crank with --crank (joints: {names})")
    return crank_of(model, on_frame[0])


def driven(document: Document, data: mujoco.MjData, crank: Crank, speed: float, steps: int) -> tuple[Edit, ...]:
    """Set the machine in motion, in `data`, and give its crank a flywheel that keeps it at its speed.

    MuJoCo scales the solver's tolerance by the mean inertia, which the flywheel is part of: the tolerance is made as
    much finer, so that the solver stops where it would without.

    Args:
        speed: of the crank [rad/s].
        steps: for which it is to be kept.
    """
    model = document.model
    if not document.can_edit("joint", crank.joint):
        raise InvalidInput("the crank is made by a macro of the model; it cannot be driven")
    data.qvel[:] = fitting_speeds(model, data, crank, speed)
    momentum = np.empty(model.nv)
    mujoco.mj_mulM(model, data, momentum, data.qvel)
    inertia = float(data.qvel @ momentum) / speed**2
    start, trial = Start.of(data), copy.copy(model)
    armature = max(float(model.dof_armature[crank.rate]), FLYWHEEL * inertia)
    for _ in range(ATTEMPTS):
        trial.dof_armature[crank.rate] = armature
        off = speed_off(np.array([s.qvel[crank.rate] for s in run(trial, start, steps, Observed()).states]), speed)
        if not KEPT < off < np.inf:
            break
        armature *= SPARE * off / KEPT
    flywheel = SetAttribute("joint", crank.joint, "crank", "armature", repr(armature))
    heavier = document.compiled((flywheel,)).stat.meaninertia / model.stat.meaninertia
    return flywheel, SetOption(("option",), "tolerance", repr(float(model.opt.tolerance / heavier)))


def speed_off(speeds: Array, nominal: float) -> float:
    """Largest deviation of speeds from the nominal one, over it."""
    return float(np.abs(speeds / nominal - 1.0).max())


def fitting_speeds(model: mujoco.MjModel, data: mujoco.MjData, crank: Crank, speed: float) -> Array:
    """Joint rates (nv,) that part no closure at a rate of the crank, the least of them where it leaves some free."""
    data.qvel[:] = 0.0
    mujoco.mj_forward(model, data)
    jacobian = rows_at(model, data).jacobian
    others = np.delete(np.arange(model.nv), crank.rate)
    speeds = np.zeros(model.nv)
    speeds[crank.rate] = speed
    speeds[others] = -np.linalg.pinv(jacobian[:, others], rcond=1e-9) @ jacobian[:, crank.rate] * speed
    return speeds
