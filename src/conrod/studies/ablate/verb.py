"""`conrod ablate`."""

from __future__ import annotations

from dataclasses import dataclass

import click

from conrod.cli import completion, options
from conrod.cli.options import StudyOptions, option

ROUNDS = 200


@dataclass(frozen=True)
class AblateOptions(StudyOptions):
    """Request to `conrod ablate`, as typed; None or empty where nothing was given."""

    steps_per_rev: int | None = option(
        "--steps-per-rev", type=int, metavar="N", help="Time steps in one turn of the crank [1000, contact 62832]."
    )
    rounds: int = option(
        "--rounds", type=int, default=ROUNDS, show_default=True, metavar="N", help="How often each cost is taken."
    )


@options.verb(AblateOptions)
@click.argument("scenes", nargs=-1, required=True, metavar="SCENE...", shell_complete=completion.scenes)
def ablate(scenes: tuple[str, ...], asked: AblateOptions) -> None:
    """Measure which ingredients a model requires: the cost of each, and its effect on the motion.

    Ingredients are added to the minimal model one by one and all together, and taken from the full one.
    Finished runs are kept in the ledger: an interrupted study goes on where it stopped.
    """
    from conrod.cli.outputs import check_outputs, exit_with_verdict, runs_with_progress
    from conrod.execution.resolve_arguments import select_scenes
    from conrod.studies.ablate.api import ablate
    from conrod.studies.ablate.report import ABLATE_REPORT

    chosen = select_scenes(scenes, asked.assignments)
    files = check_outputs(ABLATE_REPORT, chosen, asked)
    with runs_with_progress(asked) as runs:
        found = ablate(chosen, steps_per_rev=asked.steps_per_rev, rounds=asked.rounds, engines=asked.engine, runs=runs)
    files.print_and_write(found, "ablate", scenes, machines=chosen)
    exit_with_verdict(found)
