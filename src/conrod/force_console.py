"""What `conrod validate --quantity` prints, and its progress."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from concurrent.futures import Executor
from typing import Any

from rich.console import Console
from rich.markup import escape
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn
from rich.table import Table

from conrod.console import console
from conrod.engines import Engine
from conrod.execution.validation import run_jobs
from conrod.report.forces.words import blind_words, reasons, unseen_words, verdict
from conrod.scenes import Scene
from conrod.studies.forces.job import force_jobs
from conrod.studies.forces.names import GROUPS
from conrod.studies.forces.results import ForceResult, ForceStudy
from conrod.studies.forces.seen import seen_of
from conrod.studies.forces.study import ForcePlan

TITLE = "largest error over the run, by the exact peak; of contact rms between arc joints, of means of 16 steps"
COLOURS = {True: "green", False: "red", None: "yellow"}


def run_forces(
    scenes: Mapping[str, Scene],
    engines: Sequence[Engine[Any]],
    presets: Mapping[str, tuple[str, ...]],
    plan: ForcePlan,
    executor: Executor,
) -> list[ForceStudy]:
    """Run everything, with a bar on standard error where that is a terminal."""
    jobs = force_jobs(scenes, engines, presets, plan)
    err = Console(stderr=True)
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn())
    with Progress(*columns, console=err, transient=True, disable=not err.is_terminal) as progress:
        bar = progress.add_task("", total=len(jobs))
        found = run_jobs(jobs, executor, lambda job: progress.update(bar, advance=1, description=job.label))
    return [
        ForceStudy(name, scene, tuple(r for r in found if r.scene == name), seen_of(scene, plan.quantities))
        for name, scene in scenes.items()
    ]


def print_force_verdicts(studies: Sequence[ForceStudy]) -> None:
    """A line for each result: largest errors, observed orders, verdict; then what no quantity sees of a wrong mass."""
    groups = [g for g in GROUPS if any(g in result.groups for study in studies for result in study.results)]
    table = Table(title=TITLE, title_justify="left")
    for heading in ("scene", "engine", "preset", "steps/rev", *groups, f"order {', '.join(groups)}"):
        number = heading in ("steps/rev", *groups)
        table.add_column(heading, justify="right" if number else "left", no_wrap=True)
    table.add_column("verdict", overflow="fold")
    for study in studies:
        for result in study.results:
            table.add_row(*_row(result, groups))
    out = console()
    out.print(table)
    for reason in reasons([r for study in studies for r in study.results]):
        out.print(escape(f"tolerance: {reason}"))
    for study in studies:
        unseen = [*unseen_words(study.seen), *blind_words(study.seen)]
        if unseen:
            out.print(f"{escape(study.name)}: no quantity depends on: {escape('; '.join(unseen))}")


def _row(result: ForceResult, groups: Sequence[str]) -> list[str]:
    errors = [_error(result.judged(group)) for group in groups]
    orders = "" if result.order is None else ", ".join(_order(result.order.get(group)) for group in groups)
    words = escape(verdict(result))
    colour = COLOURS[result.passed] if result.passed is not None or result.outcome != "completed" else ""
    shown = f"[{colour}]{words}[/]" if colour else words
    return [result.scene, result.engine, result.preset, str(result.steps_per_revolution), *errors, orders, shown]


def _error(value: float | None) -> str:
    return "-" if value is None else f"{value:.1e}"


def _order(value: float | None) -> str:
    return "-" if value is None else f"{value:.2f}"
