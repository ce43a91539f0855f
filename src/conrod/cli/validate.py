"""`conrod validate`."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import click

from conrod.cli import options
from conrod.cli.options import HeadedCommand, Request, check_unused, of_a_model, of_a_motion, of_a_table
from conrod.errors import InvalidInput

FIGURES = "Figures of the report: mechanism, motion, error, order [all; of the catalogue mechanism,error]."
MECHANISMS = ".toml"
MODELS = (".xml", ".mjcf", ".mjb")
TABLES = (".csv", ".tsv", ".tab", ".txt", ".dat", ".parquet", ".npz")


@click.command(cls=HeadedCommand)
@click.argument("subjects", nargs=-1, metavar="[SCENE | FILE]...")
@click.option("--scene", metavar="SCENE", help="What a FILE is to be: the machine it is judged against.")
@click.option("--engine", metavar="ENGINE", help="One engine only; `conrod show` lists them.")
@click.option("--preset", metavar="PRESET", help="One preset only, e.g. stock.")
@click.option("--steps-per-rev", type=int, metavar="N", help="Time steps a revolution [1000; for contact 62832].")
@click.option("--revolutions", type=int, metavar="K", help="Turns of the crank [2].")
@options.assignments
@options.of_runs
@click.option("--tolerance", metavar="Q=T,...", help="Judge every preset by these, e.g. position=1e-4,velocity=1e-3.")
@of_a_motion
@of_a_model
@of_a_table
@click.option("--out", metavar="DIR", help="Write the report there.")
@click.option("--json", "document", metavar="FILE", help="Write the results as JSON.")
@click.option("--figures", metavar="NAME,...", help=FIGURES)
@click.option("--quantity", metavar="NAME,...", help="Forces in place of motion: torque, reactions, contact.")
def validate(**typed: Any) -> None:
    """Compare engines with the exact motion: the SCENEs named, or all that have a closed form, in both engines.

    A SCENE is one that `conrod show` lists, or a mechanism file of one's own (.toml); the word `catalogue` stands for
    all machines of the catalogue. Results are kept in the ledger: the same command goes on where it stopped, and asked
    again it runs nothing.

    A FILE is judged instead, against the machine that --scene names: a MuJoCo model (.xml, .mjb), or the trajectory of
    any tool as a table (.csv, .parquet, .npz).

    Exit status 0: all judged results are within tolerance; 1: something is not; 2: bad usage.
    """
    asked = Request(**typed)
    files = [name for name in asked.subjects if name.lower().endswith(MODELS + TABLES)]
    if files:
        _validate_file(files[0], asked)
        return
    _check_endings(asked.subjects, asked.scene)
    for bundle in (asked.model, asked.table):
        check_unused(bundle, "a scene: it is for a file")
    if asked.scene is not None:
        name = asked.scene
        raise InvalidInput(f"--scene {name} is for a file; a scene is named as it is: conrod validate {name}")
    if asked.motion.motion is None:
        check_unused(asked.motion, "a crank at constant speed: it is for --motion free and --motion torque")
    elif asked.quantity is not None:
        raise InvalidInput(
            f"--quantity {asked.quantity} does not go with --motion: forces are compared at constant crank speed"
        )
    from conrod.cli.validate_scenes import validate_scenes

    validate_scenes(asked)


def _validate_file(file: str, asked: Request) -> None:
    """Judge a user's own model or table.

    Raises:
        InvalidInput: also where options were given that are not for it.
    """
    if len(asked.subjects) > 1:
        others = [name for name in asked.subjects if name != file]
        said = f"without {others[0]}" if others else "but it is named twice"
        raise InvalidInput(f"{file}: a file is judged on its own, {said}")
    if asked.scene is None:
        raise InvalidInput(f"{file}: say with --scene what machine it is; `conrod show` lists them")
    for bundle in (asked.motion, asked.how):
        check_unused(bundle, "a file: it is for scenes")
    for name in ("quantity", "figures"):
        if getattr(asked, name) is not None:
            raise InvalidInput(f"--{name} does not go with a file: it is for scenes")
    if file.lower().endswith(MODELS):
        from conrod.cli.validate_model import validate_model

        check_unused(asked.table, "a model: it is for a table")
        validate_model(file, asked.scene, asked)
    else:
        from conrod.cli.validate_table import validate_table

        check_unused(asked.model, "a table: it is for a model")
        validate_table(file, asked.scene, asked)


def _check_endings(subjects: Sequence[str], scene: str | None) -> None:
    """Refuse a file of no kind that can be judged, which is no scene either."""
    for name in subjects:
        if name.lower().endswith(MECHANISMS):
            continue
        if Path(name).is_file() or (scene is not None and Path(name).suffix):
            raise InvalidInput(
                f"{name}: a file is known by its ending, one of {', '.join(MODELS + TABLES)}; save a sheet as CSV"
            )
