"""What `conrod sweep` prints.

`conrod sweep`.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING

import click
from rich.table import Table

from conrod.cli import options
from conrod.report.terminal import console
from conrod.studies.frame.measurement import QUANTITIES
from conrod.studies.sweep.results import SweepStudy, SweptPoint

if TYPE_CHECKING:
    from conrod.studies.frame.files import Batch
    from conrod.studies.sweep.results import SweepStudy

WIDE = 170  # where there is no terminal to fit
CAPTION = "ratio: a revolution costs as much as so many steps of the engine's fixed reference loop"


def print_fronts(studies: Sequence[SweepStudy]) -> None:
    """For each scene and engine the settings that no other one beats in both cost and position error."""
    out = console(WIDE)
    for study in studies:
        title = f"{study.name}: settings that none beats in both cost and position"
        table = Table(title=title, title_justify="left", caption=CAPTION, caption_justify="left")
        for heading in ("point", "setting", "steps/rev", *QUANTITIES, "ms/rev", "ratio"):
            left = heading in ("point", "setting")
            # A narrow terminal breaks the names of settings, never the figures.
            table.add_column(heading, justify="left" if left else "right", no_wrap=heading != "setting")
        for engine in study.engines:
            for point in study.front("position", engine):
                table.add_row(*_row(point))
        out.print(table)
        out.print(_outcomes(study), markup=False, soft_wrap=True)


def _row(point: SweptPoint) -> list[str]:
    assert point.timing is not None
    name = point.rule if point.preset is None else f"{point.rule} [{point.preset}]".replace("[", "\\[")
    errors = [f"{point.error(quantity):.1e}" for quantity in QUANTITIES]
    cost = [f"{1e3 * point.timing.seconds_per_revolution:.3g}", f"{point.timing.ratio:.3g}"]
    return [point.label, f"{point.engine}: {name}", str(point.steps_per_revolution), *errors, *cost]


def _outcomes(study: SweepStudy) -> str:
    counts = Counter(point.measurement.outcome for point in study.points)
    return f"{len(study.points)} settings and steps: " + ", ".join(f"{n} {slug}" for slug, n in counts.most_common())


@click.command()
@click.argument("scenes", nargs=-1, required=True, metavar="SCENE...")
@options.engine
@options.grid
@options.assignments
@options.runs
@options.retime
@click.option("--out", metavar="DIR", help="Write the report there.")
@click.option("--json", "document", metavar="FILE", help="Write the results as JSON.")
def sweep(
    scenes: tuple[str, ...],
    engine: str | None,
    grid: str,
    assignments: tuple[str, ...],
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
    """Measure the trade of speed for accuracy: error and cost of every setting of a grid.

    Finished runs are kept in the ledger and never run again: an interrupted sweep goes on where it stopped.
    """
    from conrod.cli.reproduction import reproduction
    from conrod.cli.runner import Options, Runner
    from conrod.engines.rule import grid_named
    from conrod.studies.frame.files import check_apart, file_to_write, folder_to_write, naming, write_together
    from conrod.studies.frame.resolve_arguments import select_engines, select_scenes
    from conrod.studies.frame.timing import fingerprint
    from conrod.studies.sweep.plan import cells_to_time, plan_sweep, sweep_study

    chosen = select_scenes(scenes, assignments)
    engines, wanted = select_engines(engine), grid_named(grid)
    folder = None if out is None else folder_to_write(out, "--out")
    file = None if document is None else file_to_write(document, "--json")
    if folder:
        from conrod.report.sweep.document import check_sweep_apart, check_sweep_folder

        check_sweep_folder(folder, chosen)
        if file:
            check_sweep_apart(file, folder, chosen)
    asked_for = Options(ledger, fresh, jobs, cluster, cell_timeout, cell_memory, retime)
    check_apart({"the ledger": asked_for.ledger_file, **({"--json": file} if file else {})})
    plans = [plan_sweep(name, scene, engines, wanted) for name, scene in chosen.items()]
    with Runner.of(asked_for) as runner:
        measurements = runner.run([cell for plan in plans for cell in plan.cells])
        timings = runner.time([cell for plan in plans for cell in cells_to_time(plan, measurements)])
    studies = [sweep_study(plan, measurements, timings, fingerprint()) for plan in plans]
    with naming("standard output"):
        print_fronts(studies)
    batches = [_results_file(studies, file)] if file else []
    if folder:
        from conrod.report.sweep.writer import sweep_report_batch
        from conrod.studies.recommend.transfer import transfers

        asked = {"--engine": engine, "--grid": None if grid == options.DEFAULT_GRID else grid}
        command = reproduction("sweep", scenes, asked, assignments, folder)
        batches.append(sweep_report_batch(studies, folder, command, transfers(studies)))
    write_together(batches)
    if folder:
        click.echo(f"report: {folder / 'README.md'}")


def _results_file(studies: Sequence[SweepStudy], file: Path) -> Batch:
    import json

    from conrod.studies.frame.files import single
    from conrod.studies.validation.serialise import environment

    document = {
        "conrod": version("conrod"),
        "environment": environment(),
        "sweeps": [study.as_dict() for study in studies],
    }
    return single(file, json.dumps(document, indent=1, allow_nan=False) + "\n")
