"""All rules. A new one is a module that has it and a line here.

All rules asked about a model, and the safe fixes made. Nothing is written but by whoever asked.
"""

from __future__ import annotations

import math
import time
from pathlib import Path

import mujoco
import numpy as np

from conrod.engines.mujoco.recorder import warnings_kept_quiet
from conrod.errors import InvalidInput, unknown_choice
from conrod.mjcf.lint import freedoms, inertias, redundant, soft, starting, touching
from conrod.mjcf.lint import inertias as gravity
from conrod.mjcf.lint import sensors as carried
from conrod.mjcf.lint import sensors as delayed
from conrod.mjcf.lint import solver as stability
from conrod.mjcf.lint import solver as unsolved
from conrod.mjcf.lint import starting as resetting
from conrod.mjcf.lint.bench import Bench
from conrod.mjcf.lint.document import Document, differing
from conrod.mjcf.lint.driving import driven, driven_crank, speed_off
from conrod.mjcf.lint.edits import Edit
from conrod.mjcf.lint.finding import DEFAULT_STEPS, MOST_STEPS, Finding, Fixed, Note, Report, Request
from conrod.mjcf.lint.motion import Observed, Start
from conrod.mjcf.lint.rule import Rule
from conrod.mjcf.lint.solver import STABILITY as STEP
from conrod.mjcf.lint.solver import UNSOLVED as SOLVER
from conrod.mjcf.lint.solver import longest_stable
from conrod.own.models.loading import keyframe_to_start_from, name_or_number, told_start
from conrod.own.models.points import KINDS, find_point
from conrod.studies.frame.paired_timing import Clock

RULES: tuple[Rule, ...] = (
    stability.STABILITY,
    unsolved.UNSOLVED,
    soft.RULE,
    starting.POSE,
    starting.SPEEDS,
    touching.JOINED,
    touching.APART,
    freedoms.RULE,
    redundant.RULE,
    gravity.GRAVITY,
    inertias.INERTIAS,
    delayed.RULE,
    resetting.RULE,
    carried.SENSORS,
    carried.SEEN,
)


def lint(path: Path, request: Request, clock: Clock = time.thread_time_ns) -> Report:
    """What a model carries that its motion does not need, and what will bite.

    To be called in a process of its own, see `conrod.studies.execution.confined`.

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
    told = _told(bench, request)
    longest = longest_stable(bench)
    steady, notes = _steady(bench, longest)
    solved = steady
    findings: list[Finding] = []
    for rule in RULES:
        if rule.name in request.ignored or (rule.needs_motion and longest is None):
            continue
        for answer in rule.judge({STEP.name: bench, SOLVER.name: steady}.get(rule.name, solved)):
            if isinstance(answer, Note):
                notes.append(answer)
                continue
            findings.append(answer)
            if rule.name == SOLVER.name:
                notes.append(Note(rule.name, "the rules after it are judged with the solver as it should be"))
                solved = steady.with_edits(answer.edits)
    findings.sort(key=lambda finding: (finding.harm, -(finding.change or 0.0)))
    fixed = None if request.fix_folder is None else fix(steady, tuple(findings), Path(request.fix_folder))
    return Report(path, told, tuple(findings), tuple(notes), fixed)


def _steady(bench: Bench, longest: float | None) -> tuple[Bench, list[Note]]:
    """The model with a step at which it runs: what the step makes wrong must not be laid to something else."""
    if longest is None:
        return bench, [Note(STEP.name, "rules that need a run that holds together are not judged")]
    if longest < float(bench.model.opt.timestep):
        step = 0.5 * longest
        return bench.with_step(step), [Note(STEP.name, f"all other rules are judged with a step of {step:.4g} s")]
    return bench, []


def fix(bench: Bench, findings: tuple[Finding, ...], folder: Path) -> Fixed:
    """The model with the safe edits of all findings, as a file of a folder.

    Raises:
        InvalidInput: from there it would not find what it needs.
    """
    edits: tuple[Edit, ...] = tuple(edit for finding in findings if finding.safe for edit in finding.edits)
    if not edits:
        return Fixed("", (), 0.0, None)
    document, moved = bench.document, bench.document.moved(folder)
    try:
        other = differing(bench.copy(edits), document.compiled((*bench.drive, *edits, *moved), folder))
    except ValueError as error:
        other = " ".join(str(error).split())
    if other:
        raise InvalidInput(f"--fix: write it into {document.folder}, beside the model: elsewhere it differs ({other})")
    lines = [f"    {edit.told}" for edit in edits]
    comment = "\n".join(("", "  With these changes by the lint command of conrod:", *lines, "  "))
    return Fixed(document.text((*edits, *moved), comment), edits, bench.change(edits), bench.cost(edits))


# -- what is run -----------------------------------------------------------------------------------------------------


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
    observed = _observed(model, request)
    return Bench(document, Start.of(data), steps, observed, keyframe=keyframe, drive=drive, clock=clock)


def _told(bench: Bench, request: Request) -> str:
    model = bench.model
    start = told_start(model, bench.keyframe)
    run = f"run of {bench.steps} steps of {float(model.opt.timestep):g} s from {start}"
    if request.speed is None:
        return f"a free {run}"
    crank = driven_crank(model, request.crank)
    off = speed_off(np.array([state.qvel[crank.rate] for state in bench.run.states]), request.speed)
    name = name_or_number(model, "joint", crank.joint)
    return f"a driven {run}; {name} turns at {request.speed:.4g} rad/s, kept to {100.0 * off:.2g} %"


def _observed(model: mujoco.MjModel, request: Request) -> Observed:
    points = [find_point(model, place) for place in request.points]
    return Observed(*(tuple(point.index for point in points if point.kind == kind) for kind in KINDS))
