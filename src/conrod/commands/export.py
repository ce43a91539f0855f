"""`conrod export`."""

from __future__ import annotations

import click

from conrod.commands import options
from conrod.errors import InvalidInput


@click.command()
@click.argument("scene")
@click.option("--format", "kind", required=True, metavar="mjcf|csv|npz", help="The model, or the exact trajectory.")
@click.option("-o", "--output", metavar="FILE", help="File to write [standard output].")
@options.assignments
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
