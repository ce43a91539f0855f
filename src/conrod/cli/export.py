"""`conrod export`."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from conrod.cli import options
from conrod.errors import InvalidInput

if TYPE_CHECKING:
    from conrod.scenes import Scene

# The figure that counts is taken over two turns.
PACK_REVOLUTIONS = 2


@click.command()
@click.argument("scene")
@click.option(
    "--format",
    "kind",
    required=True,
    metavar="mjcf|csv|npz|pack",
    help="The model, the exact trajectory, or all that another tool needs to solve the scene and be judged.",
)
@click.option("-o", "--output", metavar="FILE", help="File to write [standard output]; of a pack a folder or a .zip.")
@options.assignments
@click.option("--steps-per-rev", type=int, metavar="N", help="Steps of the model, or samples, a revolution.")
@click.option("--revolutions", type=int, metavar="K", help="Turns of the trajectory [1; of a pack 2].")
def export(
    scene: str,
    kind: str,
    output: str | None,
    assignments: tuple[str, ...],
    steps_per_rev: int | None,
    revolutions: int | None,
) -> None:
    """Write the MJCF model of SCENE, its exact trajectory as a table with units, or a pack for other tools to solve."""
    from conrod.cli.console import CSV_SAMPLES, exported
    from conrod.studies.frame.files import file_to_write, naming, write_whole
    from conrod.studies.frame.resolve_arguments import check_model, check_table, machine_text, select_scene

    name, chosen = select_scene(scene, assignments)
    if kind == "pack":
        _export_pack(name, chosen, machine_text(scene), output, steps_per_rev, revolutions)
        return
    turns = 1 if revolutions is None else revolutions
    if kind == "mjcf":
        check_model(steps_per_rev, revolutions)
    else:
        check_table(name, CSV_SAMPLES if steps_per_rev is None else steps_per_rev, turns)
    file = None if output is None else file_to_write(output, "-o")
    content = exported(name, chosen, kind, steps_per_rev, turns)
    if file:
        write_whole(file, content)
    elif isinstance(content, bytes):
        raise InvalidInput(f"--format {kind} is not text: give a file with -o")
    else:
        with naming("standard output"):
            click.echo(content, nl=False)


def _export_pack(
    name: str, scene: Scene, machine: bytes | None, output: str | None, samples: int | None, revolutions: int | None
) -> None:
    from conrod.cli.console import CSV_SAMPLES
    from conrod.report.pack.contents import pack_batch, pack_files, pack_to_write
    from conrod.studies.frame.files import write_together
    from conrod.studies.frame.resolve_arguments import check_table

    a_turn = CSV_SAMPLES if samples is None else samples
    turns = PACK_REVOLUTIONS if revolutions is None else revolutions
    check_table(name, a_turn, turns)
    place = pack_to_write(output)
    write_together([pack_batch(pack_files(name, scene, a_turn, turns, machine), place)])
    click.echo(f"pack: {place}")
