"""`conrod limits`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

from conrod.commands import options

if TYPE_CHECKING:
    from conrod.commands.runner import Options
    from conrod.files import Batch
    from conrod.report.reproduction import Reproduction
    from conrod.scenes import Scene
    from conrod.studies.limits.gallery import Exhibit
    from conrod.studies.limits.plan import LimitPlan
    from conrod.studies.limits.study import LimitStudy

    Found = tuple[Sequence[LimitStudy], Sequence[Exhibit]]

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

    Each axis is walked from harmless to hopeless, and its boundaries are found to 2 %. Finished runs are kept in the
    ledger: an interrupted study goes on where it stopped.
    """
    from conrod.commands.limits_request import request_of
    from conrod.commands.reproduction import reproduction
    from conrod.commands.runner import Options
    from conrod.files import check_apart
    from conrod.ranges import check_count
    from conrod.selection import select_engines, select_presets, select_scenes
    from conrod.studies.limits.memory import check_memory
    from conrod.studies.limits.plan import check_asked, check_runs, plan_limits

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
    found = _found(plans, how, with_gallery=asked.everything and engine is preset is None)
    given = {"--axis": axes, "--range": span, "--engine": engine, "--preset": preset, "--revolutions": revolutions}
    # Limits of a run are told too: they decide how some end.
    given |= {"--cell-timeout": cell_timeout, "--cell-memory": cell_memory}
    given |= {"--most-runs": None if most_runs == MOST_RUNS else most_runs}
    _print_and_write(
        found, folder, file, None if folder is None else reproduction("limits", scenes, given, assignments, folder)
    )


def _outputs(out: str | None, document: str | None, scenes: Mapping[str, Scene]) -> tuple[Path | None, Path | None]:
    """The report's folder and the JSON file, refused before any work where something would be lost by them."""
    from conrod.files import file_to_write, folder_to_write
    from conrod.report.limits.document import check_limits_apart, check_limits_folder

    folder = None if out is None else folder_to_write(out, "--out")
    file = None if document is None else file_to_write(document, "--json")
    if folder:
        check_limits_folder(folder, scenes)
        if file:
            check_limits_apart(file, folder, scenes)
    return folder, file


def _found(plans: Sequence[LimitPlan], how: Options, with_gallery: bool) -> Found:
    from conrod.commands.runner import Runner
    from conrod.studies.limits.gallery import gallery_search
    from conrod.studies.limits.perform import perform
    from conrod.studies.limits.plan import pursue_plans
    from conrod.studies.limits.search import pursue

    with Runner.of(how) as runner, runner.answering(perform) as run:
        return pursue_plans(plans, run), pursue([gallery_search()], run)[0] if with_gallery else ()


def _print_and_write(found: Found, folder: Path | None, file: Path | None, command: Reproduction | None) -> None:
    from conrod.files import naming, write_together
    from conrod.limits_console import print_limits

    studies, gallery = found
    with naming("standard output"):
        print_limits(studies)
    batches = [_results_file(studies, gallery, file)] if file else []
    if folder and command:
        from conrod.report.limits.writer import limits_report_batch

        batches.append(limits_report_batch(studies, gallery, folder, command))
    write_together(batches)
    if folder:
        click.echo(f"report: {folder / 'README.md'}")


def _results_file(studies: Sequence[LimitStudy], gallery: Sequence[Exhibit], file: Path) -> Batch:
    import json
    from importlib.metadata import version

    from conrod.files import single
    from conrod.studies.serialise import environment

    document = {
        "conrod": version("conrod"),
        "environment": environment(),
        "limits": [study.as_dict() for study in studies],
        "gallery": [exhibit.as_dict() for exhibit in gallery],
    }
    return single(file, json.dumps(document, indent=1, allow_nan=False) + "\n")
