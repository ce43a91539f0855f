"""`conrod validate`."""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

from conrod.commands import exit_status, options

if TYPE_CHECKING:
    from conrod.files import Batch
    from conrod.scenes import Scene
    from conrod.studies.results import SceneStudy

DEFAULT_REVOLUTIONS = 2


@click.command()
@click.argument("scenes", nargs=-1, metavar="[SCENE]...")
@click.option("--engine", metavar="ENGINE", help="One engine only: mujoco or pymunk.")
@click.option("--preset", metavar="PRESET", help="One preset only: stock, tuned or hardened.")
@click.option("--steps-per-rev", type=int, metavar="N", help="Time steps a revolution [1000; for contact 62832].")
@click.option(
    "--revolutions", type=int, default=DEFAULT_REVOLUTIONS, show_default=True, metavar="K", help="Turns of the crank."
)
@options.assignments
@click.option("--tolerance", metavar="Q=T,...", help="Judge every preset by these, e.g. position=1e-4,velocity=1e-3.")
@click.option("--out", metavar="DIR", help="Write the report there.")
@click.option("--json", "document", metavar="FILE", help="Write the results as JSON.")
def validate(
    scenes: tuple[str, ...],
    engine: str | None,
    preset: str | None,
    steps_per_rev: int | None,
    revolutions: int,
    assignments: tuple[str, ...],
    tolerance: str | None,
    out: str | None,
    document: str | None,
) -> None:
    """Compare engines with the exact motion: all SCENEs and both engines, or those named.

    Exit status 0: all judged results are within tolerance; 1: something is not; 2: bad usage.
    """
    from conrod.commands.reproduction import command_line
    from conrod.console import print_verdicts, run_with_progress
    from conrod.files import naming, write_together
    from conrod.selection import make_plan, select_engines, select_presets, select_scenes

    chosen = select_scenes(scenes, assignments)
    engines = select_engines(engine)
    presets = select_presets(engines, preset)
    plan = make_plan(chosen, steps_per_rev, revolutions, tolerance)
    folder, file = _checked_outputs(out, document, chosen)
    studies = run_with_progress(chosen, engines, presets, plan)
    with naming("standard output"):
        print_verdicts(studies)
    # All is rendered before anything is written, and then written together: an interrupt leaves all or nothing.
    batches = [_results_file(studies, file)] if file else []
    if folder:
        from conrod.report.writer import report_batch

        asked = {
            "--engine": engine,
            "--preset": preset,
            "--steps-per-rev": steps_per_rev,
            "--revolutions": None if revolutions == DEFAULT_REVOLUTIONS else revolutions,
            "--tolerance": tolerance,
        }
        command = command_line("validate", asked, assignments, folder)
        batches.append(report_batch(studies, folder, command))
    write_together(batches)
    if folder:
        click.echo(f"report: {folder / 'README.md'}")
    if not all(study.passed for study in studies):
        sys.exit(exit_status.FAILED)


def _checked_outputs(
    out: str | None, document: str | None, scenes: Mapping[str, Scene]
) -> tuple[Path | None, Path | None]:
    """The report's folder and the JSON file, refused before any work where something would be lost by them."""
    from conrod.files import file_to_write, folder_to_write
    from conrod.report.summary import check_apart, check_report_folder
    from conrod.scenes import SCENES

    folder = None if out is None else folder_to_write(out, "--out")
    file = None if document is None else file_to_write(document, "--json")
    if folder:
        check_report_folder(folder, scenes)
        if file:
            check_apart(file, folder, {*SCENES, *scenes})
    return folder, file


def _results_file(studies: Sequence[SceneStudy], file: Path) -> Batch:
    import json

    from conrod.files import single
    from conrod.studies.serialise import results_document

    return single(file, json.dumps(results_document(studies), indent=1, allow_nan=False) + "\n")
