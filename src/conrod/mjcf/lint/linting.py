"""All rules applied to a model, and the safe fixes made. Nothing is written but by the caller."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from pathlib import Path

import mujoco

from conrod.engines.mujoco.dynamics import warnings_kept_quiet
from conrod.errors import InvalidInput, unknown_choice
from conrod.mjcf.lint import closures, stepping
from conrod.mjcf.lint.bench import Bench, Document
from conrod.mjcf.lint.findings import Finding, Fixed, Report, Request, Severity
from conrod.mjcf.runs import data_at, state_of
from conrod.own.models.loading import check_finite, data_at_start, start_words

Rule = Callable[[Bench], Iterator[Finding]]
STEP, SOLVER = "step-too-long", "solver-stops-early"
# Each looks at a model on the bench; its docstring is what it finds, as in docs/lint.md.
RULES: Mapping[str, Rule] = {
    STEP: stepping.step_too_long,
    SOLVER: stepping.solver_stops_early,
    "soft-closure": closures.soft_closure,
    "open-start": closures.open_start,
    "redundant-closure": closures.redundant_closure,
    "joined-links-collide": closures.joined_links_collide,
    "silent-reset": stepping.silent_reset,
}
NEED_A_RUN = (SOLVER, "soft-closure")  # that holds together
DEFAULT_STEPS = 2000  # two revolutions of a machine that takes 1000 steps for one
MOST_STEPS = 1_000_000


def lint(path: Path, request: Request) -> Report:
    """Search a model for what its motion does not need, and for what will cause trouble.

    To be called in a process of its own, see `conrod.studies.execution.local`.

    Args:
        path: an MJCF file.

    Raises:
        InvalidInput: the file cannot be used, or has not what the request names.
    """
    for name in request.ignored:
        if name not in RULES:
            raise unknown_choice("rule", name, RULES)
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
    for name, rule in RULES.items():
        if name in request.ignored or (longest is None and name in NEED_A_RUN):
            continue
        found = [replace(one, rule=name) for one in rule(bench if name == STEP else solved)]
        findings += found
        if name == SOLVER and found:
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
    if other := document.otherwise(folder, edits):
        raise InvalidInput(f"--fix: write it into {document.folder}, beside the model: elsewhere it differs ({other})")
    comment = "<!-- With these changes by the lint command of conrod: -->"
    return Fixed(document.text((comment, *edits)), edits, bench.change(edits))
