"""What `conrod limits` prints.

`conrod limits`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click
from rich.table import Table

from conrod.cli import options
from conrod.report.limits.words import BOUNDARIES, beyond, readable, up_to
from conrod.report.terminal import console
from conrod.studies.limits.results import LimitStudy, Walk

WIDE = 170  # where there is no terminal to fit
CAPTION = "undetected: finite numbers, no warning, wrong motion"


def print_limits(studies: Sequence[LimitStudy]) -> None:
    """For each scene and axis, up to where each engine and preset can be relied on, and how it fails beyond."""
    out = console(WIDE)
    for study in studies:
        table = Table(title=f"{study.name}: up to where", title_justify="left", caption=CAPTION, caption_justify="left")
        for heading in ("axis", "engine", "preset", *BOUNDARIES.values(), "beyond that"):
            table.add_column(heading)
        for walk in map(readable, study.walks):
            if walk.boundaries:
                table.add_row(walk.axis, walk.engine, walk.preset, *_boundaries(walk), beyond(walk))
        if table.row_count:
            out.print(table)
        for text in _listed(study):
            out.print(text, markup=False, soft_wrap=True)
        for refused in dict.fromkeys((w.axis, w.engine, w.refusal) for w in study.walks if w.refusal):
            out.print(f"{refused[0]}, {refused[1]}: not walked, {refused[2]}", markup=False, soft_wrap=True)


def _boundaries(walk: Walk) -> list[str]:
    return [up_to(walk, criterion) for criterion in BOUNDARIES]


def _listed(study: LimitStudy) -> list[str]:
    """A line for each walk over a list of values: how many ended well, and which did not."""
    lines = []
    for walk in study.walks:
        if walk.probes and not walk.boundaries:
            bad = [f"{probe.text} {probe.outcome}" for probe in walk.probes if probe.level not in ("safe", "rough")]
            held = f"{len(walk.probes) - len(bad)} of {len(walk.probes)} within 10 %"
            lines.append(f"{walk.axis}, {walk.engine} {walk.preset}: {held}" + (f"; {', '.join(bad)}" if bad else ""))
    return lines


if TYPE_CHECKING:
    from conrod.cli.runner import Options
    from conrod.report.reproduction import Reproduction
    from conrod.scenes import Scene
    from conrod.studies.frame.files import Batch
    from conrod.studies.limits.plan import LimitPlan
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
@options.runs
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
    ledger: str | None,
    fresh: bool,
    jobs: int | None,
    cluster: str | None,
    cell_timeout: float | None,
    cell_memory: str | None,
    out: str | None,
    document: str | None,
) -> None:
    """Find where each engine stops being trustworthy, how it fails there, and whether one would notice.

    Each axis is walked from safe end to failing end, and its boundaries are found to 2 %. Finished runs are kept in the
    ledger: an interrupted study goes on where it stopped.
    """
    from conrod.cli.limits_request import request_of
    from conrod.cli.reproduction import reproduction
    from conrod.cli.runner import Options
    from conrod.mechanism.units import check_count
    from conrod.studies.frame.files import check_apart
    from conrod.studies.frame.resolve_arguments import select_engines, select_presets, select_scenes
    from conrod.studies.limits.plan import check_asked, check_memory, check_runs, plan_limits

    chosen, engines = select_scenes(scenes, assignments), select_engines(engine)
    select_presets(engines, preset)
    asked = request_of(axes, span, revolutions)
    folder, file = _outputs(out, document, chosen)
    check_count("--most-runs", most_runs, 1, 10**9)
    how = Options(ledger, fresh, jobs, cluster, cell_timeout, cell_memory)
    check_apart({"the ledger": how.ledger_file, **({"--json": file} if file else {})})
    plans = [plan_limits(name, scene, engines, preset, asked) for name, scene in chosen.items()]
    check_asked(plans)
    check_runs(plans, most_runs)
    check_memory(how.memory)
    studies = _found(plans, how)
    given = {"--axis": axes, "--range": span, "--engine": engine, "--preset": preset, "--revolutions": revolutions}
    # Limits of a run are told too: they decide how some end.
    given |= {"--cell-timeout": cell_timeout, "--cell-memory": cell_memory}
    given |= {"--most-runs": None if most_runs == MOST_RUNS else most_runs}
    _print_and_write(
        studies, folder, file, None if folder is None else reproduction("limits", scenes, given, assignments, folder)
    )


def _outputs(out: str | None, document: str | None, scenes: Mapping[str, Scene]) -> tuple[Path | None, Path | None]:
    """The report's folder and the JSON file, refused before any work where something would be lost by them."""
    from conrod.report.limits.document import check_limits_apart, check_limits_folder
    from conrod.studies.frame.files import file_to_write, folder_to_write

    folder = None if out is None else folder_to_write(out, "--out")
    file = None if document is None else file_to_write(document, "--json")
    if folder:
        check_limits_folder(folder, scenes)
        if file:
            check_limits_apart(file, folder, scenes)
    return folder, file


def _found(plans: Sequence[LimitPlan], how: Options) -> list[LimitStudy]:
    from conrod.cli.runner import Runner
    from conrod.studies.limits.plan import pursue_plans

    with Runner.of(how) as runner, runner.answering() as run:
        return pursue_plans(plans, run)


def _print_and_write(
    studies: Sequence[LimitStudy], folder: Path | None, file: Path | None, command: Reproduction | None
) -> None:
    from conrod.studies.frame.files import naming, write_together

    with naming("standard output"):
        print_limits(studies)
    batches = [_results_file(studies, file)] if file else []
    if folder and command:
        from conrod.report.limits.writer import limits_report_batch

        batches.append(limits_report_batch(studies, folder, command))
    write_together(batches)
    if folder:
        click.echo(f"report: {folder / 'README.md'}")


def _results_file(studies: Sequence[LimitStudy], file: Path) -> Batch:
    import json
    from importlib.metadata import version

    from conrod.runs.plain import plain
    from conrod.studies.frame.files import single
    from conrod.studies.validation.serialise import environment

    document = {
        "conrod": version("conrod"),
        "environment": environment(),
        "limits": [plain(study) for study in studies],
    }
    return single(file, json.dumps(document, indent=1, allow_nan=False) + "\n")
