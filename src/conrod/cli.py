"""The command line. Loads what a command needs when it runs, so that `--help` is immediate."""

from __future__ import annotations

import os
import sys
from collections.abc import Mapping, Sequence
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING

import click

from conrod.errors import InvalidInput

if TYPE_CHECKING:
    from conrod.files import Batch
    from conrod.scenes import Scene
    from conrod.studies.results import SceneStudy

DEFAULT_REVOLUTIONS = 2
EXIT_FAILED, EXIT_USAGE, EXIT_INTERRUPTED = 1, 2, 130
CONTEXT = {"help_option_names": ["-h", "--help"], "max_content_width": 110}

assignments = click.option(
    "--set", "assignments", multiple=True, metavar="NAME=VALUE", help="Override a parameter, e.g. --set crank=80mm."
)


@click.group(context_settings=CONTEXT)
@click.version_option(version("conrod"), prog_name="conrod")
def cli() -> None:
    """Physics engines, cross-validated against mechanisms whose motion is known exactly."""


@cli.command()
@click.argument("scene", required=False)
@assignments
@click.option("--svg", "drawing", metavar="FILE", help="Draw the scene to an SVG file.")
def show(scene: str | None, assignments: tuple[str, ...], drawing: str | None) -> None:
    """What there is, one line each; or all about one SCENE."""
    from conrod.console import show_catalogue, show_scene
    from conrod.selection import select_scenes

    if scene is None:
        if drawing is not None or assignments:
            raise InvalidInput("--svg and --set need a SCENE; `conrod show` lists them")
        show_catalogue()
        return
    file = None if drawing is None else _drawing_file(drawing)
    chosen = select_scenes([scene], assignments)[scene]
    show_scene(scene, chosen)
    if file:
        from conrod.report.drawing import draw_mechanism

        draw_mechanism(chosen, file)
        click.echo(f"drawing: {file}")


def _drawing_file(text: str) -> Path:
    from conrod.files import file_to_write

    if text.strip() and not text.lower().endswith(".svg"):
        raise InvalidInput(f"--svg {text}: the drawing is SVG: give a name that ends in .svg")
    return file_to_write(text, "--svg")


@cli.command()
@click.argument("scenes", nargs=-1, metavar="[SCENE]...")
@click.option("--engine", metavar="ENGINE", help="One engine only: mujoco or pymunk.")
@click.option("--preset", metavar="PRESET", help="One preset only: stock, tuned or hardened.")
@click.option("--steps-per-rev", type=int, metavar="N", help="Time steps a revolution [1000; for contact 62832].")
@click.option(
    "--revolutions", type=int, default=DEFAULT_REVOLUTIONS, show_default=True, metavar="K", help="Turns of the crank."
)
@assignments
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

        command = _command(folder, engine, preset, steps_per_rev, revolutions, assignments, tolerance)
        batches.append(report_batch(studies, folder, command))
    write_together(batches)
    if folder:
        click.echo(f"report: {folder / 'README.md'}")
    if not all(study.passed for study in studies):
        sys.exit(EXIT_FAILED)


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


@cli.command()
@click.argument("scene")
@click.option("--format", "kind", required=True, metavar="mjcf|csv|npz", help="The model, or the exact trajectory.")
@click.option("-o", "--output", metavar="FILE", help="File to write [standard output].")
@assignments
@click.option("--steps-per-rev", type=int, metavar="N", help="Steps of the model, or samples, a revolution.")
@click.option("--revolutions", type=int, metavar="K", help="Turns of the trajectory [1].")
def export(
    scene: str,
    kind: str,
    output: str | None,
    assignments: tuple[str, ...],
    steps_per_rev: int | None,
    revolutions: int | None,
) -> None:
    """Write the MJCF model of SCENE, or its exact trajectory as a table with units."""
    from conrod.console import CSV_SAMPLES, exported
    from conrod.files import file_to_write, naming, write_whole
    from conrod.selection import check_model, check_table, select_scenes

    chosen = select_scenes([scene], assignments)
    turns = 1 if revolutions is None else revolutions
    if kind == "mjcf":
        check_model(steps_per_rev, revolutions)
    else:
        check_table(scene, CSV_SAMPLES if steps_per_rev is None else steps_per_rev, turns)
    file = None if output is None else file_to_write(output, "-o")
    content = exported(scene, chosen[scene], kind, steps_per_rev, turns)
    if file:
        write_whole(file, content)
    elif isinstance(content, bytes):
        raise InvalidInput(f"--format {kind} is not text: give a file with -o")
    else:
        with naming("standard output"):
            click.echo(content, nl=False)


def _command(
    folder: Path,
    engine: str | None,
    preset: str | None,
    steps_per_rev: int | None,
    revolutions: int,
    assignments: tuple[str, ...],
    tolerance: str | None,
) -> str:
    """The command that makes a page again; {scene} stands for its scene."""
    import shlex

    options = {
        "--engine": engine,
        "--preset": preset,
        "--steps-per-rev": steps_per_rev,
        "--revolutions": None if revolutions == DEFAULT_REVOLUTIONS else revolutions,
        "--tolerance": tolerance,
    }
    words = ["conrod", "validate", "{scene}"]
    for name, value in options.items():
        words += [] if value is None else [name, shlex.quote(str(value))]
    for assignment in assignments:
        words += ["--set", shlex.quote(assignment)]
    return " ".join([*words, "--out", shlex.quote(str(folder))])


def main() -> None:
    """Run the command line; a user's error is one line and exit status 2."""
    try:
        cli.main(standalone_mode=False)
    except click.exceptions.NoArgsIsHelpError as error:
        click.echo(error.format_message())
    except click.ClickException as error:
        _fail(error.format_message())
    except InvalidInput as error:
        _fail(str(error))
    except BrokenPipeError:
        # Whoever read the output has seen enough.
        _drop_output()
    except MemoryError:
        _fail("out of memory: fewer --steps-per-rev or --revolutions")
    except OSError as error:
        _drop_output()
        _fail(f"{error.strerror or error}: {error.filename}" if error.filename else str(error))
    except (KeyboardInterrupt, click.Abort):
        click.echo("conrod: interrupted", err=True)
        sys.exit(EXIT_INTERRUPTED)


def _drop_output() -> None:
    """Forget what standard output cannot take: Python would complain again when it closes the stream."""
    try:
        sys.stdout.flush()
    except OSError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _fail(message: str) -> None:
    click.echo(f"conrod: {' '.join(message.split())}", err=True)
    sys.exit(EXIT_USAGE)
