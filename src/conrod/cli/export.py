"""`conrod export`."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from conrod.cli import options, say
from conrod.errors import InvalidInput, unknown_choice

if TYPE_CHECKING:
    from conrod.scenes import Scene

FORMATS = ("mjcf", "csv", "pack", "fmu")
CSV_SAMPLES = 360  # a revolution
PACK_REVOLUTIONS = 2  # the figure that counts is taken over two turns


@options.verb()
@click.argument("scene")
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
    from conrod.scenes.space import MACHINES
    from conrod.studies.frame.files import file_to_write
    from conrod.studies.frame.resolve_arguments import machine_text, select_scene
    from conrod.studies.frame.writing import naming, single, write_together

    if kind is None:
        raise InvalidInput(f"say with --format what to write: one of {', '.join(FORMATS)}")
    if kind not in FORMATS:
        raise unknown_choice("format", kind, FORMATS)
    if kind == "pack":
        from conrod.report.pack import pack_batch, pack_files, pack_to_write

        name, chosen = select_scene(scene, assignments)
        table, place = _table(name, steps_per_rev, revolutions, PACK_REVOLUTIONS), pack_to_write(output)
        write_together([pack_batch(pack_files(name, chosen, *table, machine_text(scene)), place)])
        say(f"pack: {place}")
        return
    file = None if output is None else file_to_write(output, "-o")
    if kind == "fmu" and file is None:
        raise InvalidInput("--format fmu is not text: give a file with -o")
    if kind == "mjcf" and scene in MACHINES:
        if assignments or steps_per_rev is not None or revolutions is not None:
            raise InvalidInput(f"{scene} is a machine in space: its model is written as it is, without options")
        content: str | bytes = MACHINES[scene]().mjcf
    else:
        content = _content(kind, *select_scene(scene, assignments), steps_per_rev, revolutions)
    if file is not None:
        write_together([single(file, content)])
        return
    with naming("standard output"):
        say(str(content), nl=False)


def _content(kind: str, name: str, scene: Scene, steps_per_rev: int | None, revolutions: int | None) -> str | bytes:
    if kind == "csv":
        from conrod.report.pack import as_csv, exact_columns

        return as_csv(exact_columns(scene, *_table(name, steps_per_rev, revolutions, 1)))
    from conrod.mechanism.units import check_count
    from conrod.studies.frame.resolve_arguments import STEPS

    if revolutions is not None or (kind == "fmu" and steps_per_rev is not None):
        option = "--steps-per-rev" if revolutions is None else "--revolutions"
        raise InvalidInput(f"{option} does not go with --format {kind}: whoever runs a model chooses it")
    if kind == "mjcf":
        from conrod.engines.mujoco.standalone import standalone_mjcf

        if steps_per_rev is not None:
            check_count("--steps-per-rev", steps_per_rev, *STEPS)
        return standalone_mjcf(name, scene, steps_per_rev)
    from conrod.report.fmu import fmu

    content, why_no_binary = fmu(name, scene)
    if why_no_binary is not None:
        say(f"{name}: the FMU holds sources alone: {why_no_binary}", err=True)
    return content


def _table(name: str, steps_per_rev: int | None, revolutions: int | None, usual: int) -> tuple[int, int]:
    """Samples a revolution and revolutions of an exact trajectory."""
    from conrod.studies.frame.resolve_arguments import check_table

    samples = CSV_SAMPLES if steps_per_rev is None else steps_per_rev
    turns = usual if revolutions is None else revolutions
    check_table(name, samples, turns)
    return samples, turns
