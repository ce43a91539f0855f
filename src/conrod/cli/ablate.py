"""What `conrod ablate` prints.

`conrod ablate`.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click
from rich.table import Table

from conrod.cli import options
from conrod.report.ablate.words import (
    alone,
    change_of,
    cost_of,
    in_full,
    needs_text,
    speed_up,
    torque_text,
    verdict_text,
)
from conrod.report.terminal import console
from conrod.studies.ablate.results import AblationStudy, EngineAblation, Verdict

if TYPE_CHECKING:
    from conrod.cli.runner import Options
    from conrod.report.reproduction import Reproduction
    from conrod.studies.ablate.plan import AblationPlan
    from conrod.studies.ablate.results import AblationStudy
    from conrod.studies.frame.files import Batch

WIDE = 190  # where there is no terminal to fit
COLOURS = {Verdict.REQUIRED: "cyan", Verdict.FREE: "green", Verdict.COSTLY: "yellow", Verdict.HARMFUL: "red"}
HEADINGS = ("ingredient", "in words", "cost alone", "cost in full", "change", "verdict", "drive torque", "needed by")
CAPTION = (
    "cost: with it over without it, the median and the interval that holds it with 95 %; change: of the position, "
    "over the travel"
)


def print_ablation(studies: Sequence[AblationStudy]) -> None:
    """For each scene and engine, what every ingredient costs and changes, and what follows."""
    out = console(WIDE)
    for study in studies:
        for found in study.engines:
            table = Table(title=f"{study.name}, {found.engine}", title_justify="left")
            table.caption, table.caption_justify = CAPTION, "left"
            for heading in HEADINGS:
                table.add_column(heading)
            for row in _rows(found):
                table.add_row(*row)
            if table.row_count:
                out.print(table)
            out.print(speed_up(found).replace("**", ""), markup=False, soft_wrap=True)


def _rows(found: EngineAblation) -> list[list[str]]:
    colours = {verdict.slug: colour for verdict, colour in COLOURS.items()}
    rows = []
    for one in found.ingredients:
        colour, text = colours.get(one.verdict, "none"), verdict_text(one)
        first = alone(one) or in_full(one)
        rows.append(
            [
                one.name,
                one.title,
                cost_of(alone(one)),
                cost_of(in_full(one)),
                change_of(first),
                f"[{colour}]{text}[/]",
                torque_text(one),
                needs_text(one),
            ]
        )
    return rows


ROUNDS = 200
LEAST_ROUNDS, MOST_ROUNDS = 2, 100_000


@click.command()
@click.argument("scenes", nargs=-1, required=True, metavar="SCENE...")
@options.engine
@options.assignments
@click.option(
    "--steps-per-rev", type=int, metavar="N", help="Time steps in one turn of the crank [1000, contact 62832]."
)
@click.option(
    "--rounds", type=int, default=ROUNDS, show_default=True, metavar="N", help="How often each cost is taken."
)
@options.runs
@options.retime
@click.option("--out", metavar="DIR", help="Write the report there.")
@click.option("--json", "document", metavar="FILE", help="Write the results as JSON.")
def ablate(
    scenes: tuple[str, ...],
    engine: str | None,
    assignments: tuple[str, ...],
    steps_per_rev: int | None,
    rounds: int,
    ledger: str | None,
    fresh: bool,
    jobs: int | None,
    cluster: str | None,
    cell_timeout: float | None,
    cell_memory: str | None,
    retime: bool,
    out: str | None,
    document: str | None,
) -> None:
    """Measure what a model needs and what it merely carries: each ingredient's cost, and what it does to the motion.

    Ingredients are added to the minimal model one by one and all together, and taken from the fully dressed one.
    Finished runs are kept in the ledger: an interrupted study goes on where it stopped.
    """
    from conrod.cli.reproduction import reproduction
    from conrod.cli.runner import Options
    from conrod.engines.capabilities import HasIngredients
    from conrod.mechanism.units import check_count
    from conrod.report.ablate.document import check_ablate_apart, check_ablate_folder
    from conrod.studies.ablate.plan import plan_ablation
    from conrod.studies.frame.files import check_apart, file_to_write, folder_to_write
    from conrod.studies.frame.resolve_arguments import check_table, select_engines, select_scenes
    from conrod.studies.frame.run import REVOLUTIONS

    chosen, engines = select_scenes(scenes, assignments), select_engines(engine, HasIngredients)
    if steps_per_rev is not None:
        for name in chosen:
            check_table(name, steps_per_rev, round(REVOLUTIONS))
    check_count("--rounds", rounds, LEAST_ROUNDS, MOST_ROUNDS)
    folder = None if out is None else folder_to_write(out, "--out")
    file = None if document is None else file_to_write(document, "--json")
    if folder:
        check_ablate_folder(folder, chosen)
        if file:
            check_ablate_apart(file, folder, chosen)
    how = Options(ledger, fresh, jobs, cluster, cell_timeout, cell_memory, retime)
    check_apart({"the ledger": how.ledger_file, **({"--json": file} if file else {})})
    plans = [[plan_ablation(name, scene, e, steps_per_rev, rounds) for e in engines] for name, scene in chosen.items()]
    studies = _studies(plans, how)
    given = {"--engine": engine, "--steps-per-rev": steps_per_rev, "--rounds": None if rounds == ROUNDS else rounds}
    _print_and_write(
        studies, folder, file, None if folder is None else reproduction("ablate", scenes, given, assignments, folder)
    )


def _studies(plans: Sequence[Sequence[AblationPlan]], how: Options) -> list[AblationStudy]:
    from conrod.cli.runner import Runner
    from conrod.studies.ablate.study import ablation_study, completed_plan

    with Runner.of(how) as runner:
        with runner.answering() as run:
            # Which ingredients a dressed model is to have is known when each has been seen alone.
            first = run([cell for of_scene in plans for plan in of_scene for cell in plan.change_cells()])
            whole = [[completed_plan(plan, first) for plan in of_scene] for of_scene in plans]
            runs = run([cell for of_scene in whole for plan in of_scene for cell in plan.change_cells()])
        # After all runs, one at a time: what runs beside a timing is in it.
        timed = [cell for of_scene in whole for plan in of_scene for cell in plan.cost_cells(runs)]
        costs = runner.run_alone(timed, "costs")
    return [ablation_study(of_scene, runs, costs) for of_scene in whole]


def _print_and_write(
    studies: Sequence[AblationStudy], folder: Path | None, file: Path | None, command: Reproduction | None
) -> None:
    from conrod.studies.frame.files import naming, write_together

    with naming("standard output"):
        print_ablation(studies)
    batches = [_results_file(studies, file)] if file else []
    if folder and command:
        from conrod.report.ablate.writer import ablate_report_batch

        batches.append(ablate_report_batch(studies, folder, command))
    write_together(batches)
    if folder:
        click.echo(f"report: {folder / 'README.md'}")


def _results_file(studies: Sequence[AblationStudy], file: Path) -> Batch:
    import json
    from importlib.metadata import version

    from conrod.studies.frame.files import single
    from conrod.studies.validation.serialise import environment

    document = {
        "conrod": version("conrod"),
        "environment": environment(),
        "ablations": [study.as_dict() for study in studies],
    }
    return single(file, json.dumps(document, indent=1, allow_nan=False) + "\n")
