"""`conrod limits`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import click

from conrod.cli import options

if TYPE_CHECKING:
    from conrod.studies.limits.results import LimitStudy

# All scenes and axes may need two thirds of it, should no two neighbours on any map end alike.
MOST_RUNS = 300_000
# The mark keeps the lines as they are: names of axes are not to be broken at their hyphens.
EPILOG = """\b
Axes: steps, speed, mass-ratio, nearness, stabilisation, regularisation,
iterations, run-length, length-unit, rounding, start-pose, declaration;
of a cam: float, flank-radius, nose-radius.
Pairs: steps-x-mass-ratio, steps-x-nearness, steps-x-stabilisation.
Besides: mass-ratio-at-iterations, determinism; of a cam: flight.
docs/limits.md says what each one does."""
WIDE = 170  # where there is no terminal to fit


@click.command(epilog=EPILOG)
@click.argument("scenes", nargs=-1, metavar="[SCENE]...")
@click.option(
    "--axis", "axes", multiple=True, metavar="AXIS", help="One axis or pair of axes only; may be given again [all]."
)
@click.option("--range", "span", metavar="FROM..TO", help="Other ends for the one axis, in its unit, e.g. 200..2.")
@options.engine
@click.option("--preset", metavar="PRESET", help="One preset only.")
@options.assignments
@click.option("--revolutions", type=float, metavar="N", help="Length of the runs of run-length [1000].")
@click.option(
    "--most-runs", type=int, default=MOST_RUNS, show_default=True, metavar="N", help="Refuse what may need more."
)
@options.of_runs
@click.option("--out", metavar="DIR", help="Write the report there.")
@click.option("--json", "document", metavar="FILE", help="Write the results as JSON.")
def limits(
    scenes: tuple[str, ...],
    axes: tuple[str, ...],
    span: str | None,
    engine: str | None,
    preset: str | None,
    assignments: tuple[str, ...],
    revolutions: float | None,
    most_runs: int,
    how: options.RunOptions,
    out: str | None,
    document: str | None,
) -> None:
    """Find where each engine stops being trustworthy, how it fails there, and whether one would notice.

    Each axis is walked from its safe end to its failing one, and its boundaries are found to 2 %. Finished runs are
    kept in the ledger: an interrupted study goes on where it stopped.
    """
    from conrod.cli.limits_request import request_of
    from conrod.cli.outputs import outputs, reproduction
    from conrod.cli.runner import Runner
    from conrod.mechanism.units import check_count
    from conrod.report.limits.report import KIND, report_batches
    from conrod.studies.frame.files import naming, write_together
    from conrod.studies.frame.resolve_arguments import select_engines, select_presets, select_scenes
    from conrod.studies.limits.plan import check_asked, check_memory, check_runs, plan_limits, pursue_plans

    chosen, engines = select_scenes(scenes, assignments), select_engines(engine)
    select_presets(engines, preset)
    asked = request_of(axes, span, revolutions)
    files = outputs(KIND, chosen, out, document, {"the ledger": how.ledger_file})
    check_count("--most-runs", most_runs, 1, 10**9)
    plans = [plan_limits(name, scene, engines, preset, asked) for name, scene in chosen.items()]
    check_asked(plans)
    check_runs(plans, most_runs)
    check_memory(how.memory)
    with Runner.of(how) as runner, runner.answering() as run:
        studies = pursue_plans(plans, run)
    with naming("standard output"):
        print_limits(studies)
    # Limits of a run are given too: they decide how some end.
    given = {"--axis": axes, "--range": span, "--engine": engine, "--preset": preset, "--revolutions": revolutions}
    given |= {"--cell-timeout": how.cell_timeout, "--cell-memory": how.cell_memory}
    given |= {"--most-runs": None if most_runs == MOST_RUNS else most_runs}
    command = reproduction("limits", scenes, given, assignments, files.folder)
    write_together(report_batches(studies, files.folder, files.file, command))
    if files.folder:
        click.echo(f"report: {files.folder / 'README.md'}")


def print_limits(studies: Sequence[LimitStudy]) -> None:
    """Print, for each scene and axis, how far each engine and preset can be relied on, and how it fails beyond."""
    from conrod.report.limits.tables import BEYOND, by_axis, limits_table, listed_lines, refusals
    from conrod.report.terminal import console, print_lines, print_table

    out = console(WIDE)
    for study in studies:
        table = limits_table(study)
        if table:
            print_table(out, table, folding=(BEYOND,))
        refused = [f"{axis}: {line}" for axis, walks in by_axis(study.walks).items() for line in refusals(walks)]
        print_lines(out, [*listed_lines(study), *refused])
