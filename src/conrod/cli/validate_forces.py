"""What `conrod validate --quantity` prints, and its progress.

`conrod validate --quantity`: forces in scenes by engines' accounts.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import replace
from typing import Any

import click
from rich.console import Console
from rich.markup import escape
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn
from rich.table import Table

from conrod.cli import options as exit_status
from conrod.cli.console import console
from conrod.engines import Engine
from conrod.errors import InvalidInput, unknown_choice
from conrod.report.forces.words import blind_words, reasons, unseen_words, verdict
from conrod.scenes import Scene
from conrod.studies.execution.validation import run_jobs
from conrod.studies.forces.exact import GROUPS
from conrod.studies.forces.results import ForceResult, ForceStudy
from conrod.studies.forces.seen import seen_of
from conrod.studies.forces.study import ForcePlan, force_jobs

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


DEFAULT_REVOLUTIONS = 2


def validate_forces(
    scenes: tuple[str, ...],
    quantity: str,
    *,
    engine: str | None,
    preset: str | None,
    steps_per_rev: int | None,
    revolutions: int | None,
    assignments: tuple[str, ...],
    jobs: int | None,
    tolerance: str | None,
    out: str | None,
    document: str | None,
    figures: str | None,
) -> None:
    """Compare drive torque, reactions and contact forces of engines with the exact ones."""
    from conrod.cli.reproduction import reproduction
    from conrod.cli.runner import available_cores
    from conrod.report.forces.page import check_force_files, index_of
    from conrod.report.forces.writer import force_report_batch
    from conrod.studies.execution.local import LocalProcesses
    from conrod.studies.forces.results import forces_text
    from conrod.studies.forces.study import ForcePlan
    from conrod.studies.frame.files import file_to_write, folder_to_write, naming, single, write_together
    from conrod.studies.frame.resolve_arguments import (
        make_plan,
        parse_tolerance,
        select_engines,
        select_presets,
        select_scenes,
    )

    if figures is not None:
        raise InvalidInput("--figures does not go with --quantity: its report has one figure")
    chosen = select_scenes(scenes, assignments)
    asked = _quantities(quantity, chosen)
    engines = select_engines(engine)
    presets = select_presets(engines, preset)
    turns = DEFAULT_REVOLUTIONS if revolutions is None else revolutions
    allowed = None if tolerance is None else parse_tolerance(tolerance, asked)
    plan = ForcePlan(replace(make_plan(chosen, steps_per_rev, turns, None), tolerance=allowed), asked)
    folder = None if out is None else folder_to_write(out, "--out")
    file = None if document is None else file_to_write(document, "--json")
    if folder:
        check_force_files(folder, chosen, file)
    options = {
        "--quantity": quantity,
        "--engine": engine,
        "--preset": preset,
        "--steps-per-rev": steps_per_rev,
        "--revolutions": None if turns == DEFAULT_REVOLUTIONS else turns,
        "--tolerance": tolerance,
    }
    with LocalProcesses(available_cores() if jobs is None else jobs) as executor:
        studies = run_forces(chosen, engines, presets, plan, executor)
    with naming("standard output"):
        print_force_verdicts(studies)
    batches = [single(file, forces_text(studies))] if file else []
    if folder:
        command = reproduction("validate", scenes, options, assignments, folder)
        batches.append(force_report_batch(studies, folder, command))
    write_together(batches)
    if folder:
        click.echo(f"report: {folder / index_of([study.name for study in studies])}")
    if not all(study.passed for study in studies):
        sys.exit(exit_status.FAILED)


def _quantities(text: str, scenes: Mapping[str, Scene]) -> tuple[str, ...]:
    """The groups of quantities that were asked for, in their usual order.

    Raises:
        InvalidInput: an unknown one, one named twice, or contact where no scene has any.
    """
    from conrod.studies.forces.exact import GROUPS

    given = [name.strip() for name in text.split(",")]
    for name in given:
        if name not in GROUPS:
            raise unknown_choice("quantity", name, GROUPS)
        if given.count(name) > 1:
            raise InvalidInput(f"--quantity {text}: {name} is named twice")
    if given == ["contact"] and not any(scene.kinematics.mechanism.cam_contacts for scene in scenes.values()):
        raise InvalidInput(f"--quantity contact: no joint of {', '.join(scenes)} acts by contact")
    return tuple(name for name in GROUPS if name in given)
