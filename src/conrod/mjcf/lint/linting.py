"""All rules applied to a model, and the safe fixes made. Nothing is written but by the caller."""

from __future__ import annotations

import copy
import math
from pathlib import Path

import mujoco
import numpy as np

from conrod.engines.mujoco.recorder import warnings_kept_quiet
from conrod.errors import InvalidInput, unknown_choice
from conrod.exact.motion import Array
from conrod.mjcf.equalities import rows_at
from conrod.mjcf.lint import bodies, closures, stepping
from conrod.mjcf.lint.bench import Bench, Rule
from conrod.mjcf.lint.document import Document, differing
from conrod.mjcf.lint.findings import Change, Edit, Finding, Fixed, Harm, Report, Request, SetOption
from conrod.mjcf.runs import data_at, run, state_of
from conrod.own.models.loading import (
    Crank,
    check_finite,
    crank_of,
    data_at_start,
    find_crank,
    find_point,
    listed,
    name_or_number,
    names_of,
    start_words,
)

STEP, SOLVER = stepping.step_too_long, stepping.solver_stops_early
RULES: tuple[Rule, ...] = (
    STEP,
    SOLVER,
    closures.soft_closure,
    closures.open_start,
    closures.torn_start,
    bodies.joined_links_collide,
    bodies.never_touch,
    bodies.freedom_taken_away,
    closures.redundant_closure,
    bodies.gravity_across,
    bodies.changed_inertia,
    stepping.late_sensor,
    stepping.silent_reset,
)
DEFAULT_STEPS = 2000  # two revolutions of a machine that takes 1000 steps for one
MOST_STEPS = 1_000_000
# Flywheel of a crank, over the inertia that the machine shows to it: what the machine exchanges with it in a turn then
# changes the speed by a per cent.
FLYWHEEL = 100.0
# A speed that is off by more, because of dampers, friction or a servo on the crank, asks for a heavier flywheel: by
# what is missing and a little more, at most so often.
KEPT, SPARE, ATTEMPTS = 0.01, 1.25, 4


def lint(path: Path, request: Request) -> Report:
    """Search a model for what its motion does not need, and for what will cause trouble.

    To be called in a process of its own, see `conrod.studies.execution.isolation`.

    Args:
        path: an MJCF file.

    Raises:
        InvalidInput: the file cannot be used, or has not what the request names.
    """
    names = [rule.name for rule in RULES]
    for name in request.ignored:
        if name not in names:
            raise unknown_choice("rule", name, names)
    document = Document(path)
    with warnings_kept_quiet():
        try:
            return judged(prepared(document, request), str(path), request)
        except mujoco.FatalError as error:
            raise InvalidInput(f"{path}: MuJoCo gives up on it: {' '.join(str(error).split())}") from None
        except InvalidInput as error:
            raise InvalidInput(f"{path}: {error}") from None


def judged(bench: Bench, path: str, request: Request) -> Report:
    """All rules; what the step or the solver makes wrong must not be laid to something else."""
    sentence, longest = described(bench, request), stepping.longest_stable(bench)
    steady, notes, findings = bench, list[str](), list[Finding]()
    if longest is None:
        notes.append("rules that need a run that holds together are not judged")
    elif longest < bench.step:
        steady = bench.with_step(0.5 * longest)
        notes.append(f"all other rules are judged with a step of {steady.step:.4g} s")
    solved = steady
    for rule in RULES:
        if rule.name in request.ignored or (rule.needs_motion and longest is None):
            continue
        found = list(rule.findings(bench if rule is STEP else solved))
        findings += found
        if rule is SOLVER and found:
            notes.append("the rules after it are judged with the solver as it should be")
            solved = steady.edited(found[0].edits)
    findings.sort(key=lambda finding: (list(Harm).index(finding.harm), -(finding.change or 0.0)))
    fixed = None if request.fix_folder is None else fix(steady, tuple(findings), Path(request.fix_folder))
    return Report(path, sentence, tuple(findings), tuple(notes), fixed)


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
        other = differing(bench.edited(edits).model, document.compiled((*bench.edits, *edits, *moved), folder))
    except ValueError as error:
        other = " ".join(str(error).split())
    if other:
        raise InvalidInput(f"--fix: write it into {document.folder}, beside the model: elsewhere it differs ({other})")
    lines = [f"    {edit.words}" for edit in edits]
    comment = "\n".join(("", "  With these changes by the lint command of conrod:", *lines, "  "))
    return Fixed(document.text((*edits, *moved), comment), edits, bench.change(edits))


# -- the run -----------------------------------------------------------------------------------------------------------


def prepared(document: Document, request: Request) -> Bench:
    """The model on the bench, as it was asked for."""
    model = document.model
    check_finite(model)
    if not model.nv:
        raise InvalidInput("nothing in the model can move")
    data, keyframe = data_at_start(model, request.keyframe, request.controls)
    step = float(model.opt.timestep)
    steps = DEFAULT_STEPS if request.seconds is None else max(2, math.ceil(request.seconds / step))
    if steps > MOST_STEPS:
        raise InvalidInput(f"{request.seconds:g} s are {steps} steps of {step:g} s: at most {MOST_STEPS}")
    start, drive = state_of(model, data), tuple[Edit, ...]()
    if request.speed is not None:
        start, drive = driven(document, start, driven_crank(model, request.crank), request.speed, steps)
    elif request.crank is not None:
        raise InvalidInput(f"--crank {request.crank}: say with --scene how fast it turns")
    observed = tuple(find_point(model, place) for place in request.points)
    return Bench(document, start, steps, observed, keyframe, drive)


def described(bench: Bench, request: Request) -> str:
    """The run in a sentence."""
    model = bench.model
    controls = data_at(model, bench.start).ctrl
    start = start_words(model, bench.keyframe, controls)
    sentence = f"run of {bench.steps} steps of {bench.step:g} s from {start}"
    if request.speed is None:
        return f"{'an actuated' if controls.any() else 'a free'} {sentence}"
    crank = driven_crank(model, request.crank)
    off = _speed_off(bench.run.states[:, model.nq + crank.rate], request.speed)
    name = name_or_number(model, "joint", crank.joint)
    return f"a driven {sentence}; {name} turns at {request.speed * 30.0 / math.pi:.4g} rpm, kept to {100.0 * off:.2g} %"


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
        names = listed(filter(None, names_of(model, "joint"))) or "none has a name"
        raise InvalidInput(f"{len(on_frame)} hinges are on the frame: name the crank with --crank (joints: {names})")
    return crank_of(model, on_frame[0])


def driven(document: Document, start: Array, crank: Crank, speed: float, steps: int) -> tuple[Array, tuple[Edit, ...]]:
    """Set the machine in motion, and give its crank a flywheel that keeps it at its speed [rad/s] for some steps.

    MuJoCo scales the solver's tolerance by the mean inertia, which the flywheel is part of: the tolerance is made as
    much finer, so that the solver stops where it would without.

    Returns:
        The start with speeds that part no closure, the least of them where the crank leaves some free; and the edits.
    """
    model, rate = document.model, crank.rate
    if not document.can_edit("joint", crank.joint):
        raise InvalidInput("the crank is made by a macro of the model; it cannot be driven")
    data, momentum = data_at(model, start), np.empty(model.nv)
    data.qvel[:] = 0.0
    mujoco.mj_forward(model, data)
    jacobian, others = rows_at(model, data).jacobian, np.delete(np.arange(model.nv), rate)
    data.qvel[rate] = speed
    data.qvel[others] = -np.linalg.pinv(jacobian[:, others], rcond=1e-9) @ jacobian[:, rate] * speed
    mujoco.mj_mulM(model, data, momentum, data.qvel)
    moving, trial = start.copy(), copy.copy(model)
    moving[model.nq : model.nq + model.nv] = data.qvel
    armature = max(float(model.dof_armature[rate]), FLYWHEEL * float(data.qvel @ momentum) / speed**2)
    for _ in range(ATTEMPTS):
        trial.dof_armature[rate] = armature
        off = _speed_off(run(trial, moving, steps).states[:, model.nq + rate], speed)
        if not KEPT < off < np.inf:
            break
        armature *= SPARE * off / KEPT
    flywheel = Change("joint", crank.joint, name_or_number(model, "joint", crank.joint), "armature", repr(armature))
    heavier = document.compiled((flywheel,)).stat.meaninertia / model.stat.meaninertia
    return moving, (flywheel, SetOption(("option",), "tolerance", repr(float(model.opt.tolerance / heavier))))


def _speed_off(speeds: Array, nominal: float) -> float:
    """Largest deviation of speeds from the nominal one, over it."""
    return float(np.abs(speeds / nominal - 1.0).max())
