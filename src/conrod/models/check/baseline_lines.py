"""A judged model as the lines of a baseline."""

from __future__ import annotations

from collections.abc import Sequence

from conrod.exact.motion import QUANTITIES
from conrod.execution.baseline import BaselineLine
from conrod.execution.baseline_check import baseline_line
from conrod.models.check.results import JudgedRun, ModelStudy


def model_lines(found: Sequence[ModelStudy]) -> dict[str, BaselineLine]:
    """Return the baseline's lines on one judged model: one on its paths, and one on each run."""
    (study,) = found
    runs = [*study.runs.values(), *([study.own_run] if study.own_run else [])]
    paths = baseline_line("completed", study.is_machine, {"position": study.identity.largest})
    return {"paths": paths} | {run.label: _run_line(study, run) for run in runs}


def _run_line(study: ModelStudy, run: JudgedRun) -> BaselineLine:
    passed = not study.exceeded_limits(run) if run in study.judged else None
    sizes = {} if run.errors is None else {q: run.worst(q) for q in QUANTITIES} | {"phase": run.phase}
    return baseline_line(run.outcome.slug, passed, sizes)
