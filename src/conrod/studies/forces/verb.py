"""`conrod forces`: torque and reactions at constant crank speed."""

from __future__ import annotations

from dataclasses import dataclass

import click

from conrod.cli import completion, options
from conrod.cli.options import JudgedOptions, RunOptions, names_in, option, tolerance_in


@dataclass(frozen=True)
class ForcesOptions(JudgedOptions, RunOptions):
    """Request to `conrod forces`, as typed; None or empty where nothing was given."""

    quantity: str | None = option("--quantity", metavar="NAME,...", help="Of torque, reactions, contact [all].")
    engine: tuple[str, ...] = option("--engine")
    preset: str | None = option("--preset")
    steps_per_rev: int | None = option("--steps-per-rev", type=int, metavar="N", help="Steps a turn [1000; cam 62832].")
    revolutions: int | None = option("--revolutions", type=int, metavar="K", help="Turns of the crank [2].")
    assignments: tuple[str, ...] = option("--set", help=options.FAMILY_HELP)


@options.verb(ForcesOptions)
@click.argument("scenes", nargs=-1, metavar="[SCENE]...", shell_complete=completion.scenes)
def forces(scenes: tuple[str, ...], asked: ForcesOptions) -> None:
    """Compare the forces that engines report with the exact ones of SCENEs.

    Torque of the crank, reactions of joints and contact forces, at constant crank speed.
    Exit status 0: all that was judged is within tolerance; 1: something is not.
    """
    from conrod.cli.outputs import check_outputs, exit_with_verdict, runs_with_progress
    from conrod.execution.resolve_arguments import select_scenes
    from conrod.studies.forces.api import REVOLUTIONS, check_quantities, forces
    from conrod.studies.forces.report import FORCES_REPORT

    chosen = select_scenes(scenes, asked.assignments)
    quantities = check_quantities(names_in(asked.quantity), chosen)
    files = check_outputs(FORCES_REPORT, chosen, asked)
    with runs_with_progress(asked) as runs:
        found = forces(
            chosen,
            quantities=names_in(asked.quantity),
            engines=asked.engine,
            preset=asked.preset,
            steps_per_rev=asked.steps_per_rev,
            revolutions=REVOLUTIONS if asked.revolutions is None else asked.revolutions,
            tolerance=tolerance_in(asked.tolerance, quantities),
            baseline=asked.baseline,
            accept=asked.accept,
            runs=runs,
        )
    files.print_and_write(found, "forces", scenes, machines=chosen)
    exit_with_verdict(found)
