"""Judged closed loops as the lines of a baseline."""

from __future__ import annotations

from collections.abc import Sequence

from conrod.execution.baseline import ORDER_PREFIX, PATH, BaselineLine
from conrod.execution.baseline_check import baseline_line
from conrod.mjcf.loop_results import LOOPS, OWN_SETTINGS, LoopRun, LoopStudy


def loop_lines(found: Sequence[LoopStudy]) -> dict[str, BaselineLine]:
    """Return the baseline's lines on judged loops: MuJoCo's kinematics, the file's own run, and each driven run."""
    return {
        f"{study.name} {name}" if len(found) > 1 else name: line
        for study in found
        for name, line in _lines(study).items()
    }


def _lines(study: LoopStudy) -> dict[str, BaselineLine]:
    shipped = study.shipped
    lines = {
        "kinematics": baseline_line("completed", study.agrees and study.is_machine, study.kinematic),
        # The gap of a run that chatters, or comes apart, is no number that rounding leaves as it is.
        "its own run": baseline_line(
            shipped.outcome.slug,
            not study.shipped_failed,
            {} if shipped.failed else {LOOPS: shipped.gap, PATH: shipped.path},
        ),
    }
    return lines | {f"driven, {run.label}": _run_line(study, run) for run in study.runs}


def _run_line(study: LoopStudy, run: LoopRun) -> BaselineLine:
    """The line of a run with conrod's drives; its cost is of the hour, and not in it."""
    sizes = {**run.errors, LOOPS: run.gap, f"{ORDER_PREFIX}position": run.order}
    passed = run.is_within(study.question.tolerance) if run.label == OWN_SETTINGS else None
    return baseline_line(run.outcome.slug, passed, sizes)
