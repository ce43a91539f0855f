"""`conrod sweep`: all settings of a grid; `conrod recommend`: the cheapest one within tolerances."""

from __future__ import annotations

import sys
from dataclasses import dataclass
from typing import TYPE_CHECKING

import click

from conrod.cli import FAILED, completion, options, say
from conrod.cli.options import StudyOptions, number_or_text, option
from conrod.errors import InvalidInput

if TYPE_CHECKING:
    from conrod.engines.capabilities import ModelFile

PYTHON_FILE = ".py"


@dataclass(frozen=True)
class SweepOptions(StudyOptions):
    """Request to `conrod sweep`, as typed."""

    assignments: tuple[str, ...] = option("--set", help=options.FAMILY_HELP)
    grid: str = option(
        "--grid", default="default", show_default=True, metavar="GRID", help="coarse, default or presets."
    )


@options.verb(SweepOptions)
@click.argument("scenes", nargs=-1, required=True, metavar="SCENE...", shell_complete=completion.scenes)
def sweep(scenes: tuple[str, ...], asked: SweepOptions) -> None:
    """Measure the trade of speed for accuracy: error and cost of every setting of a grid.

    The grid `presets` has engines beside each other: every preset of each, at more steps.

    Finished runs are kept in the ledger and never run again: an interrupted sweep goes on where it stopped.
    """
    from conrod.cli.outputs import check_outputs, exit_with_verdict, runs_with_progress
    from conrod.engines.variants import grid_named
    from conrod.execution.resolve_arguments import select_scenes
    from conrod.studies.sweep.api import sweep
    from conrod.studies.sweep.report import SWEEP_REPORT

    chosen = select_scenes(scenes, asked.assignments)
    grid_named(asked.grid)
    files = check_outputs(SWEEP_REPORT, chosen, asked)
    with runs_with_progress(asked) as runs:
        found = sweep(chosen, grid=asked.grid, engines=asked.engine, runs=runs)
    files.print_and_write(found, "sweep", scenes, machines=chosen)
    exit_with_verdict(found)


@dataclass(frozen=True)
class RecommendOptions(StudyOptions):
    """Request to `conrod recommend`, as typed; None or empty where nothing was given."""

    position: str | None = option("--position", metavar="E", help="Largest error of position, over L, or e.g. 0.01mm.")
    velocity: str | None = option("--velocity", metavar="E", help="Largest error of velocity, over ω L, or e.g. 1mm/s.")
    acceleration: str | None = option(
        "--acceleration", metavar="E", help="Largest error of acceleration, over ω² L, or e.g. 0.1m/s^2."
    )
    model: str | None = option(
        "--model", metavar="FILE", help="Write the model with the settings: MJCF, or FILE.py of pymunk."
    )


@options.verb(RecommendOptions)
@click.argument("scene", shell_complete=completion.scenes)
def recommend(scene: str, asked: RecommendOptions) -> None:
    """The cheapest setting of each engine within all given tolerances, ready to paste.

    Sweeps that ship with conrod say which settings to try; each is run on the machine itself, some dozens of runs.
    The answer is confirmed on other runs: with the numbers as they are pasted, another start angle, five revolutions,
    speeds 10 % off; of an input that makes one pass, that pass backwards, and those speeds.

    Exit status 0: at least one engine has such a setting; 1: none has, or cannot be trusted; 2: bad usage.
    """
    from conrod.cli.outputs import check_outputs, runs_with_progress
    from conrod.engines.capabilities import MissingCapability, ModelFile, capability
    from conrod.execution.files import files_to_write
    from conrod.execution.resolve_arguments import choose_engines, select_scene
    from conrod.execution.writing import single_file, write_together
    from conrod.studies.sweep.api import cheapest_settings, findings_of
    from conrod.studies.sweep.recommend import Recommendation, check_tolerances
    from conrod.studies.sweep.recommendation_report import RECOMMENDATION_REPORT

    name, chosen = select_scene(scene, asked.assignments)
    engines = choose_engines(asked.engine)
    wanted = files_to_write({"--model": asked.model}, {"the ledger": asked.ledger_file})
    files = check_outputs(RECOMMENDATION_REPORT, [name], asked, wanted)
    capabilities = {one.name: capability(one, ModelFile) for one in engines}
    writers = {name: made for name, made in capabilities.items() if not isinstance(made, MissingCapability)}
    if asked.model and not writers:
        raise InvalidInput(f"--model: {', '.join(capabilities)} has no file of a model")
    if asked.model:
        writers = writers_of_ending(asked.model, writers)
    tolerance = {name: number_or_text(getattr(asked, name)) for name in ("position", "velocity", "acceleration")}
    check_tolerances(tolerance)
    with runs_with_progress(asked) as runs:
        answers = cheapest_settings((name, chosen), tolerance, engines=engines, runs=runs)
    found = findings_of((name, chosen), tolerance, answers)
    files.print_and_write(found, "recommend", (scene,), machines={name: chosen})
    qualified = [one.rounded_settings for one in answers if isinstance(one, Recommendation)]
    trusted = not found.study.distrust
    settings = next((one for one in qualified if trusted and one.engine in writers), None)
    for path in wanted.values():
        if settings is None:
            why = "nothing qualifies" if trusted else "its figures cannot be trusted"
            say(f"conrod: no model is written: {why}", err=True)
            sys.exit(FAILED)
        write_together([single_file(path, writers[settings.engine].model(name, chosen, settings))])
        say(f"model: {path}")
    if not found.passed:
        sys.exit(FAILED)


def writers_of_ending(file: str, writers: dict[str, ModelFile]) -> dict[str, ModelFile]:
    """Select the engines, by name, whose model files end as a given file does: in `.py` or not.

    Raises:
        InvalidInput: no engine has model files with this ending.
    """
    from conrod.engines import engine_style

    is_python = file.lower().endswith(PYTHON_FILE)
    found = {
        name: one for name, one in writers.items() if (engine_style(name).model_ending == PYTHON_FILE) == is_python
    }
    if not found:
        endings = " and ".join(f"{name}'s in {engine_style(name).model_ending}" for name in writers)
        raise InvalidInput(f"--model {file}: files of models end otherwise, {endings}")
    return found
