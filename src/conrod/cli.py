"""The command line. Loads what a command needs when it runs, so that `--help` is immediate."""

from __future__ import annotations

import os
import sys
from importlib.metadata import version
from pathlib import Path

import click

from conrod.errors import InvalidInput

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
@click.option("--svg", "drawing", type=Path, metavar="FILE", help="Draw the scene to an SVG file.")
def show(scene: str | None, assignments: tuple[str, ...], drawing: Path | None) -> None:
    """What there is, one line each; or all about one SCENE."""
    from conrod.console import show_catalogue, show_scene
    from conrod.files import check_writable_file
    from conrod.selection import select_scenes

    if scene is None:
        if drawing or assignments:
            raise InvalidInput("--svg and --set need a SCENE; `conrod show` lists them")
        show_catalogue()
        return
    if drawing:
        check_writable_file(drawing)
    chosen = select_scenes([scene], assignments)[scene]
    show_scene(scene, chosen)
    if drawing:
        from conrod.report.drawing import draw_mechanism

        draw_mechanism(chosen, drawing)
        click.echo(f"drawing: {drawing}")


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
@click.option("--out", "folder", type=Path, metavar="DIR", help="Write the report there.")
@click.option("--json", "document", type=Path, metavar="FILE", help="Write the results as JSON.")
def validate(
    scenes: tuple[str, ...],
    engine: str | None,
    preset: str | None,
    steps_per_rev: int | None,
    revolutions: int,
    assignments: tuple[str, ...],
    tolerance: str | None,
    folder: Path | None,
    document: Path | None,
) -> None:
    """Compare engines with the exact motion: all SCENEs and both engines, or those named.

    Exit status 0: all judged results are within tolerance; 1: something is not; 2: bad usage.
    """
    from conrod.console import print_verdicts, run_with_progress
    from conrod.files import check_writable_file, check_writable_folder, write_whole
    from conrod.selection import make_plan, select_engines, select_presets, select_scenes

    chosen = select_scenes(scenes, assignments)
    engines = select_engines(engine)
    presets = select_presets(engines, preset)
    plan = make_plan(chosen, steps_per_rev, revolutions, tolerance)
    if folder:
        check_writable_folder(folder)
    if document:
        check_writable_file(document)
    studies = run_with_progress(chosen, engines, presets, plan)
    print_verdicts(studies)
    if document:
        import json

        from conrod.studies.serialise import results_document

        write_whole(document, json.dumps(results_document(studies), indent=1, allow_nan=False) + "\n")
    if folder:
        from conrod.report.writer import write_report

        write_report(
            studies, folder, _command(folder, engine, preset, steps_per_rev, revolutions, assignments, tolerance)
        )
        click.echo(f"report: {folder / 'README.md'}")
    if not all(study.passed for study in studies):
        sys.exit(EXIT_FAILED)


@cli.command()
@click.argument("scene")
@click.option("--format", "kind", required=True, metavar="mjcf|csv|npz", help="The model, or the exact trajectory.")
@click.option("-o", "--output", type=Path, metavar="FILE", help="File to write [standard output].")
@assignments
@click.option("--steps-per-rev", type=int, metavar="N", help="Steps of the model, or samples, a revolution.")
@click.option("--revolutions", type=int, default=1, show_default=True, metavar="K", help="Turns of the trajectory.")
def export(
    scene: str,
    kind: str,
    output: Path | None,
    assignments: tuple[str, ...],
    steps_per_rev: int | None,
    revolutions: int,
) -> None:
    """Write the MJCF model of SCENE, or its exact trajectory as a table with units."""
    from conrod.console import exported
    from conrod.files import check_writable_file, write_whole
    from conrod.selection import make_plan, select_scenes

    chosen = select_scenes([scene], assignments)
    make_plan(chosen, steps_per_rev, revolutions, None)
    if output:
        check_writable_file(output)
    content = exported(scene, chosen[scene], kind, steps_per_rev, revolutions)
    if output:
        write_whole(output, content)
    elif isinstance(content, bytes):
        raise InvalidInput(f"--format {kind} is not text: give a file with -o")
    else:
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
        # Whoever read the output has seen enough. Python would complain again when it closes the stream.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    except OSError as error:
        _fail(f"{error.strerror or error}: {error.filename}" if error.filename else str(error))
    except (KeyboardInterrupt, click.Abort):
        click.echo("conrod: interrupted; nothing was written", err=True)
        sys.exit(EXIT_INTERRUPTED)


def _fail(message: str) -> None:
    click.echo(f"conrod: {' '.join(message.split())}", err=True)
    sys.exit(EXIT_USAGE)
