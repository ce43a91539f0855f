"""`conrod validate`."""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import click

from conrod.cli import options
from conrod.cli import options as exit_status
from conrod.cli.model_options import ModelOptions, of_a_model
from conrod.cli.options import MotionOptions, RunOptions, TableOptions, check_unused, of_a_motion, of_a_table
from conrod.errors import InvalidInput

DEFAULT_REVOLUTIONS = 2
# On the pages of so many machines: where it is, and how far off.
FEW_FIGURES = "mechanism,error"
FIGURES_HELP = f"Of the report: mechanism, motion, error, order [all; of the catalogue {FEW_FIGURES}]."
MECHANISMS = ".toml"
MODELS = (".xml", ".mjcf", ".mjb")
TABLES = (".csv", ".tsv", ".tab", ".txt", ".dat", ".parquet", ".npz")


@click.command()
@click.argument("subjects", nargs=-1, metavar="[SCENE | FILE]...")
@click.option("--scene", metavar="SCENE", help="What a FILE is to be: the machine it is judged against.")
@click.option("--engine", metavar="ENGINE", help="One engine only; `conrod show` lists them.")
@click.option("--preset", metavar="PRESET", help="One preset only, e.g. stock.")
@click.option("--steps-per-rev", type=int, metavar="N", help="Time steps a revolution [1000; for contact 62832].")
@click.option("--revolutions", type=int, metavar="K", help=f"Turns of the crank [{DEFAULT_REVOLUTIONS}].")
@options.assignments
@options.of_runs
@click.option("--tolerance", metavar="Q=T,...", help="Judge every preset by these, e.g. position=1e-4,velocity=1e-3.")
@of_a_motion
@of_a_model
@of_a_table
@click.option("--out", metavar="DIR", help="Write the report there.")
@click.option("--json", "document", metavar="FILE", help="Write the results as JSON.")
@click.option("--figures", metavar="NAME,...", help=FIGURES_HELP)
@click.option("--quantity", metavar="NAME,...", help="Forces in place of motion: torque, reactions, contact.")
def validate(
    subjects: tuple[str, ...],
    scene: str | None,
    motion: MotionOptions,
    model: ModelOptions,
    table: TableOptions,
    how: RunOptions,
    quantity: str | None,
    **asked: Any,
) -> None:
    """Compare engines with the exact motion: the SCENEs named, or all that have a closed form, in both engines.

    A SCENE is one that `conrod show` lists, or a mechanism file of one's own (.toml); the word `catalogue` stands for
    all machines of the catalogue. Results are kept in the ledger: the same command goes on where it stopped, and asked
    again it runs nothing. A FILE is judged instead, against the machine
    that --scene names: a MuJoCo model (.xml, .mjb), or the trajectory of any tool as a table (.csv, .parquet, .npz).

    Exit status 0: all judged results are within tolerance; 1: something is not; 2: bad usage.
    """
    files = [name for name in subjects if name.lower().endswith(MODELS + TABLES)]
    if not files:
        _check_endings(subjects, scene)
        for bundle in (model, table):
            check_unused(bundle, "a scene: it is for a file")
        if scene is not None:
            raise InvalidInput(f"--scene {scene} is for a file; a scene is named as it is: conrod validate {scene}")
        _validate_machines(subjects, quantity, motion, how, asked)
        return
    if len(subjects) > 1:
        others = [name for name in subjects if name != files[0]]
        said = f"without {others[0]}" if others else "but it is named twice"
        raise InvalidInput(f"{files[0]}: a file is judged on its own, {said}")
    if scene is None:
        raise InvalidInput(f"{files[0]}: say with --scene what machine it is; `conrod show` lists them")
    if quantity is not None:
        raise InvalidInput("--quantity does not go with a file: it is for scenes")
    check_unused(motion, "a file: it is for scenes")
    check_unused(how, "a file: it is for scenes")
    if asked.pop("figures") is not None:
        raise InvalidInput("--figures does not go with a file: it is for scenes")
    if files[0].lower().endswith(MODELS):
        from conrod.cli.validate_model import validate_model

        check_unused(table, "a model: it is for a table")
        validate_model(files[0], scene, model, **asked)
    else:
        from conrod.cli.validate_table import validate_table

        check_unused(model, "a table: it is for a model")
        validate_table(files[0], scene, table, **asked)


def _check_endings(subjects: Sequence[str], scene: str | None) -> None:
    """Refuse a file of no kind that can be judged, which is no scene either."""
    for name in subjects:
        if name.lower().endswith(MECHANISMS):
            continue
        if Path(name).is_file() or (scene is not None and Path(name).suffix):
            raise InvalidInput(
                f"{name}: a file is known by its ending, one of {', '.join(MODELS + TABLES)}; save a sheet as CSV"
            )


def _validate_machines(
    scenes: tuple[str, ...], quantity: str | None, motion: MotionOptions, how: RunOptions, asked: Mapping[str, Any]
) -> None:
    """Scenes: their motion at constant crank speed, the forces in it, or their motion without a drive."""
    if quantity is not None and motion.motion is not None:
        raise InvalidInput(f"--quantity {quantity} does not go with --motion: forces are told at constant crank speed")
    if motion.motion is not None:
        from conrod.cli.validate_motion import validate_motion

        validate_motion(scenes, motion, how, **asked)
        return
    check_unused(motion, "a crank at constant speed: it is for --motion free and --motion torque")
    if quantity is not None:
        from conrod.cli.validate_forces import validate_forces

        validate_forces(scenes, quantity, how, **asked)
        return
    validate_scenes(scenes, how, **asked)


def validate_scenes(
    scenes: tuple[str, ...],
    how: RunOptions,
    engine: str | None,
    preset: str | None,
    steps_per_rev: int | None,
    revolutions: int | None,
    assignments: tuple[str, ...],
    tolerance: str | None,
    out: str | None,
    document: str | None,
    figures: str | None,
) -> None:
    """Scenes in engines."""
    from conrod.cli.console import print_verdicts
    from conrod.cli.outputs import outputs
    from conrod.cli.reproduction import reproduction
    from conrod.cli.runner import Runner
    from conrod.report.charts.styles import figures_of
    from conrod.report.validation.report import KIND, without_motion
    from conrod.scenes.catalogue import CATALOGUE
    from conrod.studies.frame.files import naming
    from conrod.studies.frame.resolve_arguments import make_plan, select_engines, select_presets, select_scenes
    from conrod.studies.validation.study import validation

    chosen = select_scenes(scenes, assignments)
    engines = select_engines(engine)
    presets = select_presets(engines, preset)
    turns = DEFAULT_REVOLUTIONS if revolutions is None else revolutions
    plan = make_plan(chosen, steps_per_rev, turns, tolerance)
    files = outputs(KIND, chosen, out, document)
    drawn = FEW_FIGURES if figures is None and CATALOGUE in scenes else figures
    shown = figures_of(drawn)
    asked = {
        "--engine": engine,
        "--preset": preset,
        "--steps-per-rev": steps_per_rev,
        "--revolutions": None if turns == DEFAULT_REVOLUTIONS else turns,
        "--tolerance": tolerance,
        "--figures": drawn,
    }
    with Runner.of(how, files.file) as runner:
        studies = runner.pursue(validation(chosen, engines, presets, plan))
        with naming("standard output"):
            print_verdicts(studies)
        found = {study.name: study if "motion" in shown else without_motion(study) for study in studies}
        command = reproduction("validate", scenes, asked, assignments, files.folder) if files.folder else None
        with runner.options.processes() as executor:
            # One page is drawn here and now; several by all processes.
            files.write(found, command, {"figures": shown}, executor.map if len(studies) > 1 else map)
    if not all(study.passed for study in studies):
        sys.exit(exit_status.FAILED)
