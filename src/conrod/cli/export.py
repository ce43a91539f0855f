"""`conrod export`."""

from __future__ import annotations

from pathlib import Path

import click

from conrod.cli import options, say
from conrod.errors import InvalidInput

FORMATS = ("mjcf", "csv", "pack", "fmu")
MODELS = ("mjcf", "fmu")
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
    from conrod.errors import unknown_choice
    from conrod.scenes.space import MACHINES
    from conrod.studies.frame.files import file_to_write
    from conrod.studies.frame.resolve_arguments import check_table, machine_text, select_scene
    from conrod.studies.frame.writing import write_together

    if kind == "mjcf" and scene in MACHINES:
        _write(MACHINES[scene]().mjcf, None if output is None else file_to_write(output, "-o"))
        return
    name, chosen = select_scene(scene, assignments)
    if kind is None:
        raise InvalidInput(f"say with --format what to write: one of {', '.join(FORMATS)}")
    if kind in MODELS:
        _check_model(kind, steps_per_rev, revolutions)
    samples = CSV_SAMPLES if steps_per_rev is None else steps_per_rev
    turns = revolutions if revolutions is not None else PACK_REVOLUTIONS if kind == "pack" else 1
    if kind not in MODELS:
        check_table(name, samples, turns)
    if kind == "pack":
        from conrod.report.pack import pack_batch, pack_files, pack_to_write

        place = pack_to_write(output)
        write_together([pack_batch(pack_files(name, chosen, samples, turns, machine_text(scene)), place)])
        say(f"pack: {place}")
        return
    file = None if output is None else file_to_write(output, "-o")
    if kind == "fmu" and file is None:
        raise InvalidInput("--format fmu is not text: give a file with -o")
    content: str | bytes
    if kind == "mjcf":
        from conrod.engines.mujoco.standalone import standalone_mjcf

        content = standalone_mjcf(name, chosen, steps_per_rev)
    elif kind == "fmu":
        from conrod.report.fmu import fmu

        content, why_no_binary = fmu(name, chosen)
        if why_no_binary is not None:
            say(f"{name}: the FMU holds sources alone: {why_no_binary}", err=True)
    elif kind == "csv":
        from conrod.report.pack import as_csv, exact_columns

        content = as_csv(exact_columns(chosen, samples, turns))
    else:
        raise unknown_choice("format", kind, FORMATS)
    _write(content, file)


def _check_model(kind: str, steps_per_rev: int | None, revolutions: int | None) -> None:
    from conrod.mechanism.units import check_count
    from conrod.studies.frame.resolve_arguments import STEPS

    if revolutions is not None or (kind == "fmu" and steps_per_rev is not None):
        option = "--steps-per-rev" if revolutions is None else "--revolutions"
        raise InvalidInput(f"{option} does not go with --format {kind}: whoever runs a model chooses it")
    if steps_per_rev is not None:
        check_count("--steps-per-rev", steps_per_rev, *STEPS)


def _write(content: str | bytes, file: Path | None) -> None:
    """Write to a file, or text to standard output."""
    from conrod.studies.frame.writing import naming, single, write_together

    if file is not None:
        write_together([single(file, content)])
        return
    with naming("standard output"):
        say(str(content), nl=False)
