"""All rules applied to a model, and the safe fixes made. Nothing is written but by the caller."""

from __future__ import annotations

import time
from pathlib import Path

import mujoco

from conrod.engines.mujoco.recorder import warnings_kept_quiet
from conrod.errors import InvalidInput, unknown_choice
from conrod.mjcf.lint.bench import Bench
from conrod.mjcf.lint.document import Document, differing
from conrod.mjcf.lint.edits import Edit
from conrod.mjcf.lint.findings import Finding, Fixed, Harm, Note, Report, Request
from conrod.mjcf.lint.preparing import described, prepared
from conrod.mjcf.lint.rules import RULES, SOLVER, STEP
from conrod.mjcf.lint.solver import longest_stable
from conrod.studies.frame.paired_timing import Clock


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
    run = described(bench, request)
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
    return Report(path, run, tuple(findings), tuple(notes), fixed)


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
