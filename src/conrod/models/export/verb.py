"""`conrod export`."""

from __future__ import annotations

import click

from conrod.cli import completion, options, say
from conrod.errors import InvalidInput, unknown_choice

FORMATS = ("mjcf", "csv", "pack", "fmu")
PACK_REVOLUTIONS = 2  # the figure that counts is taken over two turns


@options.verb()
@click.argument("scene", shell_complete=completion.scenes)
@click.option(
    "--format",
    "kind",
    metavar="mjcf|csv|pack|fmu",
    help="Model, exact trajectory, a pack for others to solve, or an FMU 3.0.",
)
@click.option("-o", "--output", metavar="FILE", help="File to write [standard output]; of a pack a folder or a .zip.")
@options.assignments
@click.option("--steps-per-rev", type=int, metavar="N", help="Steps of the model, or samples, a revolution.")
@click.option("--revolutions", type=int, metavar="K", help="Turns of the trajectory [1; of a pack 2].")
def export(
    scene: str,
    kind: str | None,
    output: str | None,
    assignments: tuple[str, ...],
    steps_per_rev: int | None,
    revolutions: int | None,
) -> None:
    """Write the MJCF model of SCENE, or its exact motion: as a table with units, a pack for others to solve, an FMU."""
    from conrod.execution.files import file_to_write
    from conrod.execution.resolve_arguments import mechanism_file_bytes, select_scene
    from conrod.execution.writing import name_file_in_errors, single_file, write_together
    from conrod.models.export.api import export, samples_of
    from conrod.scenes import Scene
    from conrod.scenes.space import MACHINES

    if kind is None:
        raise InvalidInput(f"say with --format what to write: one of {', '.join(FORMATS)}")
    if kind not in FORMATS:
        raise unknown_choice("format", kind, FORMATS)
    if kind == "pack":
        from conrod.models.export.pack import pack_batch, pack_files, pack_to_write

        name, chosen = select_scene(scene, assignments)
        table, place = samples_of(name, steps_per_rev, revolutions, PACK_REVOLUTIONS), pack_to_write(output)
        write_together([pack_batch(pack_files(name, chosen, *table, mechanism_file_bytes(scene)), place)])
        say(f"pack: {place}")
        return
    file = None if output is None else file_to_write(output, "-o")
    if kind == "fmu" and file is None:
        raise InvalidInput("--format fmu is not text: give a file with -o")
    of: str | tuple[str, Scene] = scene
    if not (kind == "mjcf" and scene in MACHINES):
        of = select_scene(scene, assignments)
    elif assignments:
        raise InvalidInput(f"{scene} is a machine in space: its model is written as it is, without options")
    content = export(of, kind, steps_per_rev=steps_per_rev, revolutions=revolutions)
    if file is not None:
        write_together([single_file(file, content)])
        return
    with name_file_in_errors("standard output"):
        say(str(content), nl=False)
