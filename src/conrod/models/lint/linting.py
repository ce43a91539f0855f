"""Apply all rules to a model, and make the safe fixes. Only the caller writes files."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import mujoco

from conrod.comparison.other_forces import acting_sentences
from conrod.errors import InvalidInput, unknown_choice
from conrod.mjcf.document import Document
from conrod.mjcf.loading import check_finite, data_at_start, start_words
from conrod.mjcf.request import Controls
from conrod.mjcf.runs import state_of, user_model_errors
from conrod.mjcf.unit_of_length import controls_in_metres
from conrod.models.lint import closures, stepping
from conrod.models.lint.bench import LintBench
from conrod.models.lint.findings import Finding, FixedModel, Report, Severity

Rule = Callable[[LintBench], Iterator[Finding]]
STEP, SOLVER = "step-too-long", "solver-stops-early"
# Each looks at a model on the bench; its docstring is what it finds, as in docs/lint.md.
RULES: Mapping[str, Rule] = {
    STEP: stepping.step_too_long,
    SOLVER: stepping.solver_stops_early,
    "soft-closure": closures.soft_closure,
    "open-start": closures.open_start,
    "parts-apart": closures.parts_do_not_meet,
    "redundant-closure": closures.redundant_closure,
    "joined-links-collide": closures.joined_links_collide,
    "nothing-moves": stepping.nothing_moves,
    "silent-reset": stepping.silent_reset,
}
NEED_A_RUN = (SOLVER, "soft-closure")  # rules that say nothing of a run that does not hold together
DEFAULT_STEPS = 2000  # two revolutions of a machine that takes 1000 steps for one
MAX_STEPS = 1_000_000


def lint(
    path: Path,
    keyframe: str | None = None,
    seconds: float | None = None,
    ignored: Sequence[str] = (),
    fix_folder: Path | None = None,
    controls: Controls = (),
    unit: float = 1.0,
) -> Report:
    """Search a model for what its motion does not need, and for what will cause trouble.

    To be called in a process of its own, see `conrod.execution.local`.

    Args:
        path: an MJCF file.
        keyframe, controls: as in `data_at_start`.
        seconds: length of the run [s]; None for `DEFAULT_STEPS` steps.
        ignored: names of rules that are left out.
        fix_folder: folder for a model with the safe fixes; None for no such model.
        unit: unit of the file's lengths [m].

    Raises:
        InvalidInput: the file cannot be used, or lacks a named keyframe or control.
    """
    for name in ignored:
        if name not in RULES:
            raise unknown_choice("rule", name, RULES)
    document = Document(path, unit)
    with user_model_errors(path):
        controls = controls_in_metres(document.model, controls, unit)
        bench, run = prepare_bench(document, keyframe, seconds, controls)
        findings, notes, steady = judge_rules(bench, ignored)
        engine, acting = f"MuJoCo {mujoco.__version__}", bench.run.acting
        notes = (*notes, *acting_sentences(acting, engine, "in its own run", judged=False))
        fixed = None if fix_folder is None else fix(steady, findings, fix_folder)
        return Report(str(path), run, findings, notes, fixed)


def prepare_bench(
    document: Document, keyframe: str | None, seconds: float | None, controls: Controls
) -> tuple[LintBench, str]:
    """Prepare the bench for a model's run, and describe the run in a sentence."""
    model = document.model
    check_finite(model)
    if not model.nv:
        raise InvalidInput("nothing in the model can move")
    data, index = data_at_start(model, keyframe, controls)
    step = float(model.opt.timestep)
    steps = DEFAULT_STEPS if seconds is None else max(2, math.ceil(seconds / step))
    if steps > MAX_STEPS:
        raise InvalidInput(f"{seconds:g} s are {steps} steps of {step:g} s: at most {MAX_STEPS}")
    kind, start = "an actuated" if data.ctrl.any() else "a free", start_words(model, index, data.ctrl)
    bench = LintBench(document, model, (), state_of(model, data), steps, index)
    return bench, f"{kind} run of {steps} steps of {step:g} s from {start}"


def judge_rules(bench: LintBench, ignored: Sequence[str]) -> tuple[tuple[Finding, ...], tuple[str, ...], LintBench]:
    """Apply all rules; return findings, worst first, notes, and the bench of most rules."""
    longest = stepping.longest_stable(bench)
    steady, notes, findings = bench, list[str](), list[Finding]()
    if longest is None:
        notes.append("rules that need a run that holds together are not judged")
    elif longest is not bench:
        steady = longest.finer
        notes.append(f"all other rules are judged with a step of {steady.step:.4g} s")
    solved = steady
    for name, rule in RULES.items():
        if name in ignored or (longest is None and name in NEED_A_RUN):
            continue
        found = [replace(one, rule=name) for one in rule(bench if name == STEP else solved)]
        findings += found
        if name == SOLVER and found:
            notes.append("the rules after it are judged with the solver as it should be")
            solved = steady.with_edits(found[0].edits)
    findings.sort(key=lambda finding: (list(Severity).index(finding.severity), -(finding.change or 0.0)))
    return tuple(findings), tuple(notes), steady


def fix(bench: LintBench, findings: tuple[Finding, ...], folder: Path) -> FixedModel:
    """Make a model with the safe edits of all findings, to be written into a folder.

    Raises:
        InvalidInput: in this folder the model would not find its includes and assets.
    """
    edits = tuple(edit for finding in findings if finding.safe for edit in finding.edits)
    if not edits:
        return FixedModel()
    document = bench.document
    if other := document.recompile_difference(folder, edits):
        raise InvalidInput(f"--fix: write it into {document.folder}, beside the model: elsewhere it differs ({other})")
    comment = "<!-- With these changes by the lint command of conrod: -->"
    return FixedModel(document.text_with((comment, *edits)), edits, bench.change(edits))
