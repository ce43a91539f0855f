"""Free motion on the command line: progress, and a line for each result."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor
from typing import Any

from rich.console import Console
from rich.markup import escape
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn
from rich.table import Table

from conrod.console import console
from conrod.engines import Engine
from conrod.execution.validation import run_jobs
from conrod.report import numbers
from conrod.report.free_motion.words import exact_words, loads_words, step_text, verdict_words
from conrod.scenes import Scene
from conrod.studies.free_motion.jobs import ExactJob, motion_jobs, motion_study
from conrod.studies.free_motion.plan import MotionPlan
from conrod.studies.free_motion.results import MotionResult, MotionStudy

WIDE = 170
HEADINGS = ("scene", "engine", "preset", "step", "position", "rms", "final", "crank [rad]", "energy", "leaves at")


def run_motions(
    scenes: Mapping[str, Scene],
    engines: Sequence[Engine[Any]],
    presets: Mapping[str, tuple[str, ...]],
    plan: MotionPlan,
    executor: Executor,
) -> list[MotionStudy]:
    """The exact motions, then the engines', with a bar on standard error where that is a terminal.

    Raises:
        InvalidInput: a scene has no such motion.
    """
    err = Console(stderr=True)
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    with Progress(*columns, console=err, transient=True, disable=not err.is_terminal) as progress:
        runs = sum(len(presets[engine.name]) for engine in engines)
        bar = progress.add_task("", total=len(scenes) * (1 + runs))
        done: Callable[[Any], None] = lambda job: progress.update(bar, advance=1, description=job.label)  # noqa: E731
        exact = run_jobs([ExactJob(name, scene, plan) for name, scene in scenes.items()], executor, done)
        courses = dict(zip(scenes, exact, strict=True))
        found = run_jobs(motion_jobs(courses, engines, presets, plan), executor, done)
    return [
        motion_study(name, scene, courses[name], plan, [result for result in found if result.scene == name])
        for name, scene in scenes.items()
    ]


def print_motions(studies: Sequence[MotionStudy]) -> None:
    """A line for each result, and what is to be said of the exact motion."""
    table = Table(title="error at the same time over the run, positions over L, energy over the largest that took part")
    table.title_justify = "left"
    for heading in HEADINGS:
        table.add_column(heading, justify="left" if heading in HEADINGS[:3] else "right", no_wrap=True)
    table.add_column("order x, E", justify="right", no_wrap=True)
    table.add_column("CPU", justify="right", no_wrap=True)
    table.add_column("verdict", overflow="fold")
    for study in studies:
        for result in study.results:
            table.add_row(*_row(result))
    out = console(WIDE)
    out.print(table)
    for study in studies:
        out.print(f"{escape(study.name)}: {escape(' '.join([loads_words(study), exact_words(study)]))}", soft_wrap=True)


def _row(result: MotionResult) -> list[str]:
    errors = [numbers.measured(result.largest("position", measure)) for measure in ("max", "rms", "final")]
    others = [numbers.measured(result.largest(name)) for name in ("angle", "energy")]
    leaves = "-" if result.errors is None else "never" if result.leaves is None else f"{result.leaves:.4g} s"
    order = "" if result.order is None else ", ".join(numbers.order(value) for value in result.order.values())
    return [
        escape(result.scene), result.engine, result.preset, step_text(result.step), *errors, *others, leaves, order,
        numbers.duration(result.cpu_seconds), _coloured(result),
    ]  # fmt: skip


def _coloured(result: MotionResult) -> str:
    text = escape(verdict_words(result))
    if result.outcome != "completed":
        return f"[yellow]{text}[/]"
    return text if result.passed is None else f"[green]{text}[/]" if result.passed else f"[red]{text}[/]"
