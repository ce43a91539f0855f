"""All rules applied to a model, and the safe fixes made. Nothing is written but by the caller."""

from __future__ import annotations

import math
from pathlib import Path

import mujoco

from conrod.engines.mujoco.recorder import warnings_kept_quiet
from conrod.errors import InvalidInput, unknown_choice
from conrod.mjcf.lint import closures, collisions, stepping
from conrod.mjcf.lint.bench import Bench, Rule
from conrod.mjcf.lint.document import Document, differing
from conrod.mjcf.lint.findings import Finding, Fixed, Report, Request, Severity
from conrod.mjcf.runs import data_at, state_of
from conrod.own.models.loading import check_finite, data_at_start, start_words

STEP, SOLVER = stepping.step_too_long, stepping.solver_stops_early
RULES: tuple[Rule, ...] = (
    STEP,
    SOLVER,
    closures.soft_closure,
    closures.open_start,
    collisions.joined_links_collide,
    stepping.silent_reset,
)
DEFAULT_STEPS = 2000  # two revolutions of a machine that takes 1000 steps for one
MOST_STEPS = 1_000_000


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
    return Bench(document, model, (), state_of(model, data), steps, keyframe)


def described(bench: Bench) -> str:
    """The run in a sentence."""
    controls = data_at(bench.model, bench.start).ctrl
    kind = "an actuated" if controls.any() else "a free"
    start = start_words(bench.model, bench.keyframe, controls)
    return f"{kind} run of {bench.steps} steps of {bench.step:g} s from {start}"


def judged(bench: Bench, path: str, request: Request) -> Report:
    """All rules; what the step or the solver makes wrong must not be laid to something else."""
    longest = stepping.longest_stable(bench)
    steady, notes, findings = bench, list[str](), list[Finding]()
    if longest is None:
        notes.append("rules that need a run that holds together are not judged")
    elif longest is not bench:
        steady = longest.finer
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
    findings.sort(key=lambda finding: (list(Severity).index(finding.severity), -(finding.change or 0.0)))
    fixed = None if request.fix_folder is None else fix(steady, tuple(findings), Path(request.fix_folder))
    return Report(path, described(bench), tuple(findings), tuple(notes), fixed)


def fix(bench: Bench, findings: tuple[Finding, ...], folder: Path) -> Fixed:
    """The model with the safe edits of all findings, as a file of a folder.

    Raises:
        InvalidInput: from there it would not find what it needs.
    """
    edits = tuple(edit for finding in findings if finding.safe for edit in finding.edits)
    if not edits:
        return Fixed()
    document = bench.document
    try:
        other = differing(document.compiled(edits), document.compiled(edits, folder))
    except ValueError as error:
        other = " ".join(str(error).split())
    if other:
        raise InvalidInput(f"--fix: write it into {document.folder}, beside the model: elsewhere it differs ({other})")
    comment = "<!-- With these changes by the lint command of conrod: -->"
    return Fixed(document.text((comment, *edits)), edits, bench.change(edits))
