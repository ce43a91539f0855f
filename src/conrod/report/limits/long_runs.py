"""Long runs: what grows with the number of revolutions, and what does not."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from conrod.report import numbers
from conrod.report.charts.canvas import on_log_grid, whole_decades
from conrod.report.charts.layout import Layout, log_axis, preset_handles
from conrod.report.charts.styles import preset_style
from conrod.report.limits.words import WHO, who
from conrod.report.table import Table, table
from conrod.studies.limits.extremes import Mark
from conrod.studies.limits.results import LongRun

WIDTH, PANEL = 9.5, 3.1  # [inch]
LEFT, RIGHT, TOP, GAP, BOTTOM = 0.9, 0.25, 0.5, 0.85, 0.5  # margins [inch]
CLOCK = "a clock that sums its steps, x ω"

Quantity = Callable[[Mark], float]


def long_run_figure(runs: Sequence[LongRun]) -> Figure:
    """Draw loop error on the left, phase on the right, against revolutions; at least one run has marks."""
    runs = [run for run in runs if run.marks]
    height = TOP + PANEL + BOTTOM
    layout = Layout(WIDTH, height)
    wide = (WIDTH - LEFT - RIGHT - GAP) / 2.0
    left, right = (layout.axes(x, BOTTOM, wide, PANEL) for x in (LEFT, LEFT + wide + GAP))
    _panel(left, runs, [(lambda mark: mark.closure, {})], "largest gap of a joint since the mark before, / L")
    clock: dict[str, Any] = {"linestyle": (0, (1, 2)), "color": "black", "marker": "none"}
    _panel(right, runs, [(lambda m: abs(m.phase), {}), (lambda m: abs(m.clock), clock)], "phase error (rad)")
    handles = [*preset_handles((run.engine, run.preset) for run in runs), Line2D([], [], label=CLOCK, **clock)]
    layout.legend(handles, 3, handlelength=3.0)
    return layout.figure


def _panel(
    axes: Axes, runs: Sequence[LongRun], quantities: Sequence[tuple[Quantity, dict[str, Any]]], label: str
) -> None:
    drawn = []
    for run in runs:
        turns = on_log_grid(np.array([float(mark.revolution) for mark in run.marks]))
        for of, other in quantities:
            heights = on_log_grid(np.array([of(mark) for mark in run.marks]))
            drawn.append(heights)
            axes.plot(turns, heights, **(preset_style(run.engine, run.preset) | other))
    whole_decades(axes, drawn)
    last = max(mark.revolution for run in runs for mark in run.marks)
    decades = range(int(np.floor(np.log10(last))) + 1)
    log_axis(axes, (10.0**-0.1, last * 10.0**0.1), [10.0**k for k in decades])
    axes.set_xlabel("revolutions")
    axes.set_ylabel(label)


def long_run_table(runs: Iterable[LongRun]) -> Table:
    """Return a row for each run: the first mark beside the last one."""
    head = (*WHO, "steps per revolution", "revolutions", "ended", "loop error / L, first revolution", "at the end")
    return table((*head, "phase at the end (rad)", "of a clock that sums its steps (rad)"), map(_long_run, runs))


def _long_run(run: LongRun) -> tuple[str, ...]:
    first, last = (run.marks[0], run.marks[-1]) if run.marks else (None, None)
    failed = run.outcome != "completed" and last is not None
    ended = f"{run.outcome} after {numbers.quantity(last.revolution)}" if failed and last else run.outcome
    sizes = [None] * 4 if first is None or last is None else [first.closure, last.closure, last.phase, last.clock]
    return (
        *who(run),
        str(run.steps_per_revolution),
        numbers.quantity(run.revolutions),
        ended,
        *map(numbers.measured, sizes),
    )
