"""`conrod export`."""

from __future__ import annotations

import click

from conrod.cli import completion, options, say
from conrod.errors import InvalidInput, unknown_choice

FORMATS = ("mjcf", "pymunk", "csv", "npz", "pack", "fmu")
PACK_REVOLUTIONS = 2  # the figure that counts is taken over two turns


@options.verb()
@click.argument("scene", shell_complete=completion.scenes)
@click.option(
    "--format",
    "kind",
    metavar="FORMAT",
    help="mjcf, pymunk: a model; csv, npz: the trajectory; pack: a task for others; fmu: an FMU 3.0.",
)
@click.option("-o", "--output", metavar="FILE", help="File to write [standard output]; of a pack a folder or a .zip.")
@options.assignments
@click.option("--preset", **options.SHARED["--preset"])
@click.option("--engine", "engines", **options.SHARED["--engine"])
@click.option("--free", is_flag=True, help="A model without a drive: its crank moves freely, with its own mass.")
@click.option("--motor", is_flag=True, help="With --free: a motor on the crank, which is yours to set.")
@click.option("--steps-per-rev", type=int, metavar="N", help="Steps of the model, or samples, a revolution.")
@click.option("--revolutions", type=int, metavar="K", help="Turns of the trajectory [1; of a pack 2].")
def export(
    scene: str,
    kind: str | None,
    output: str | None,
    assignments: tuple[str, ...],
    preset: str | None,
    engines: tuple[str, ...],
    free: bool,
    motor: bool,
    steps_per_rev: int | None,
    revolutions: int | None,
) -> None:
    """Write SCENE as a model, or its motion.

    The model is a MuJoCo file (MJCF), or a Python module that builds it in pymunk and steps it. The exact motion is a
    table with units, a pack for others to solve, or an FMU; with --engine the table has what that did beside it.
    """
    from conrod.errors import name_file_in_os_errors
    from conrod.execution.files import file_to_write
    from conrod.execution.resolve_arguments import mechanism_file_bytes, select_scene
    from conrod.execution.writing import single_file, write_together
    from conrod.models.export.api import check_model_options, export, samples_of
    from conrod.scenes import Scene
    from conrod.scenes.space import MACHINES

    if kind is None:
        raise InvalidInput(f"say with --format what to write: one of {', '.join(FORMATS)}")
    if kind not in FORMATS:
        raise unknown_choice("format", kind, FORMATS)
    if len(engines) > 1:
        raise InvalidInput(f"--engine {' '.join(engines)}: the run of one engine is sampled: name it once")
    engine = engines[0] if engines else None
    if kind == "pack":
        check_model_options(kind, preset, free, motor, engine)
        from conrod.models.export.pack import pack_batch, pack_files, pack_to_write

        name, chosen = select_scene(scene, assignments)
        table, place = samples_of(name, steps_per_rev, revolutions, PACK_REVOLUTIONS), pack_to_write(output)
        write_together([pack_batch(pack_files(name, chosen, *table, mechanism_file_bytes(scene)), place)])
        say(f"pack: {place}")
        return
    file = None if output is None else file_to_write(output, "-o")
    if kind in ("fmu", "npz") and file is None:
        raise InvalidInput(f"--format {kind} is not text: give a file with -o")
    of: str | tuple[str, Scene] = scene
    if not (kind == "mjcf" and scene in MACHINES):
        of = select_scene(scene, assignments)
    elif assignments:
        raise InvalidInput(f"{scene} is a machine in space: its model is written as it is, without options")
    content = export(
        of,
        kind,
        steps_per_rev=steps_per_rev,
        revolutions=revolutions,
        preset=preset,
        engine=engine,
        free=free,
        motor=motor,
    )
    if file is not None:
        write_together([single_file(file, content)])
        return
    with name_file_in_os_errors("standard output"):
        say(str(content), nl=False)
