"""`conrod ablate`."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

from conrod.commands import options

if TYPE_CHECKING:
    from conrod.commands.runner import Options
    from conrod.files import Batch
    from conrod.report.reproduction import Reproduction
    from conrod.studies.ablate.plan import AblationPlan
    from conrod.studies.ablate.results import AblationStudy

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
    from conrod.commands.reproduction import reproduction
    from conrod.commands.runner import Options
    from conrod.files import check_apart, file_to_write, folder_to_write
    from conrod.ranges import check_count
    from conrod.report.ablate.document import check_ablate_apart, check_ablate_folder
    from conrod.selection import check_table, select_engines, select_scenes
    from conrod.studies.ablate.plan import plan_ablation
    from conrod.studies.cell import REVOLUTIONS

    chosen, engines = select_scenes(scenes, assignments), select_engines(engine)
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
    from conrod.commands.runner import Runner
    from conrod.studies.ablate.perform import measure_change, measure_cost
    from conrod.studies.ablate.study import ablation_study, completed_plan

    with Runner.of(how) as runner:
        with runner.answering(measure_change) as run:
            # Which ingredients a dressed model is to have is known when each has been seen alone.
            first = run([cell for of_scene in plans for plan in of_scene for cell in plan.change_cells()])
            whole = [[completed_plan(plan, first) for plan in of_scene] for of_scene in plans]
            runs = run([cell for of_scene in whole for plan in of_scene for cell in plan.change_cells()])
        # After all runs, one at a time: what runs beside a timing is in it.
        timed = [cell for of_scene in whole for plan in of_scene for cell in plan.cost_cells(runs)]
        costs = runner.run_alone(timed, "costs", measure_cost)
    return [ablation_study(of_scene, runs, costs) for of_scene in whole]


def _print_and_write(
    studies: Sequence[AblationStudy], folder: Path | None, file: Path | None, command: Reproduction | None
) -> None:
    from conrod.ablate_console import print_ablation
    from conrod.files import naming, write_together

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

    from conrod.files import single
    from conrod.studies.serialise import environment

    document = {
        "conrod": version("conrod"),
        "environment": environment(),
        "ablations": [study.as_dict() for study in studies],
    }
    return single(file, json.dumps(document, indent=1, allow_nan=False) + "\n")
