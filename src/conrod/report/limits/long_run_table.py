"""Long runs in numbers: the first mark beside the last one."""

from __future__ import annotations

from collections.abc import Sequence

from conrod.report import numbers
from conrod.report.styles import engine_title
from conrod.report.tables import table
from conrod.studies.limits.results import LongRun

HEAD = ["engine", "preset", "steps per revolution", "revolutions", "ended", "loop error / L, first revolution"]
HEAD += ["at the end", "phase at the end (rad)", "of a clock that sums its steps (rad)"]


def long_run_table(runs: Sequence[LongRun], with_scene: bool = False) -> str:
    """A row for each run; nothing where there is none."""
    rows = [[*([run.scene] if with_scene else []), *_cells(run)] for run in runs]
    return table([*(["machine"] if with_scene else []), *HEAD], rows)


def _cells(run: LongRun) -> list[str]:
    first, last = (run.marks[0], run.marks[-1]) if run.marks else (None, None)
    return [
        engine_title(run.engine),
        run.preset,
        str(run.steps_per_revolution),
        numbers.quantity(run.revolutions),
        run.outcome + (f" after {numbers.quantity(last.revolution)}" if run.outcome != "completed" and last else ""),
        *(numbers.measured(None if mark is None else mark.closure) for mark in (first, last)),
        numbers.measured(None if last is None else last.phase),
        numbers.measured(None if last is None else last.clock),
    ]
