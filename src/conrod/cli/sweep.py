"""`conrod sweep`: all settings of a grid; `conrod recommend`: the cheapest one within tolerances."""

from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import click

from conrod.cli import FAILED, options, say
from conrod.cli.options import StudyOptions, option
from conrod.errors import InvalidInput

if TYPE_CHECKING:
    from conrod.report.recommendation import Advice
    from conrod.report.terminal import Part
    from conrod.studies.sweep.findings import SweepStudy


@dataclass(frozen=True)
class SweepAsked(StudyOptions):
    """Request to `conrod sweep`, as typed."""

    grid: str = option(
        "--grid", default="default", show_default=True, metavar="GRID", help="coarse, default or presets."
    )


@options.verb(SweepAsked)
@click.argument("scenes", nargs=-1, required=True, metavar="SCENE...")
def sweep(scenes: tuple[str, ...], asked: SweepAsked) -> None:
    """Measure the trade of speed for accuracy: error and cost of every setting of a grid.

    The grid `presets` has engines beside each other: every preset of each, at more steps.

    Finished runs are kept in the ledger and never run again: an interrupted sweep goes on where it stopped.
    """
    from conrod.cli.outputs import outputs
    from conrod.cli.runner import Runner
    from conrod.engines.variants import grid_named
    from conrod.report.sweep import KIND
    from conrod.studies.frame.resolve_arguments import select_scenes
    from conrod.studies.sweep.study import plan_sweep, sweep_scene

    chosen, engines = select_scenes(scenes, asked.assignments), options.chosen_engines(asked.engine)
    swept = grid_named(asked.grid)
    files = outputs(KIND, chosen, asked)
    plans = [plan_sweep(name, scene, engines, swept) for name, scene in chosen.items()]
    with Runner.of(asked) as runner:
        studies = runner.pursue([sweep_scene(plan, runner.time) for plan in plans])
    files.answer({study.name: study for study in studies}, fronts(studies), "sweep", scenes)


def fronts(studies: Sequence[SweepStudy]) -> Iterator[Part]:
    """For each scene and engine the settings that no other one beats in both cost and position error."""
    from conrod.report.sweep_tables import RATIO, end_words, front_table

    for study in studies:
        yield front_table(study, f"{study.name}: settings that none beats in both cost and position")
        yield RATIO
        yield f"{len(study.points)} settings and steps: {end_words(study)}"
        yield from (f"{name} unsupported: {why}" for name, why in study.unsupported.items())


@dataclass(frozen=True)
class RecommendAsked(StudyOptions):
    """Request to `conrod recommend`, as typed; None or empty where nothing was given."""

    position: float | None = option(
        "--position", type=float, metavar="E", help="Largest error of position, over the travel L."
    )
    velocity: float | None = option("--velocity", type=float, metavar="E", help="Largest error of velocity, over ω L.")
    acceleration: float | None = option(
        "--acceleration", type=float, metavar="E", help="Largest error of acceleration, over ω² L."
    )
    model: str | None = option(
        "--model", metavar="FILE", help="Write the model with the settings, of an engine that has files (MJCF)."
    )


@options.verb(RecommendAsked)
@click.argument("scene")
def recommend(scene: str, asked: RecommendAsked) -> None:
    """The cheapest setting of each engine within all given tolerances, ready to paste.

    Sweeps that ship with conrod say which settings to try; each is run on the machine itself, some dozens of runs.
    The answer is confirmed on other runs: with the numbers as they are pasted, another start angle, five revolutions,
    speeds 10 % off; of an input that makes one pass, that pass backwards, and those speeds.

    Exit status 0: at least one engine has such a setting; 1: none has; 2: bad usage.
    """
    from conrod.cli.outputs import outputs
    from conrod.cli.runner import Runner
    from conrod.engines.capabilities import MissingCapability, ModelFile, capability
    from conrod.report.recommendation import KIND, advice_of
    from conrod.studies.frame.case import pursue
    from conrod.studies.frame.files import files_to_write
    from conrod.studies.frame.resolve_arguments import select_scene
    from conrod.studies.frame.writing import single, write_together
    from conrod.studies.sweep.prior import shipped
    from conrod.studies.sweep.recommend import Recommendation, check_tolerances, recommend_for
    from conrod.studies.sweep.study import plan_sweep

    (name, chosen), engines = select_scene(scene, asked.assignments), options.chosen_engines(asked.engine)
    allowed = check_tolerances({name: getattr(asked, name) for name in ("position", "velocity", "acceleration")})
    wanted = files_to_write({"--model": asked.model}, {"the ledger": asked.ledger_file})
    files = outputs(KIND, [name], asked, wanted)
    able = {one.name: capability(one, ModelFile) for one in engines}
    writers = {name: made for name, made in able.items() if not isinstance(made, MissingCapability)}
    if asked.model and not writers:
        raise InvalidInput(f"--model: {', '.join(able)} has no file of a model")
    plan = plan_sweep(name, chosen, engines, "default")
    with Runner.of(asked) as runner, runner.answering() as run:
        answers = pursue(recommend_for(plan, allowed, runner.time, shipped()), run)
    found = advice_of(name, chosen, allowed, answers)
    files.answer({name: found}, answers_found(found), "recommend", (scene,))
    qualified = [one.pasted for one in answers if isinstance(one, Recommendation)]
    settings = next((one for one in qualified if one.engine in writers), None)
    for path in wanted.values():
        if settings is None:
            say("conrod: no model is written: nothing qualifies", err=True)
            sys.exit(FAILED)
        write_together([single(path, writers[settings.engine].model(name, chosen, settings))])
        say(f"model: {path}")
    if not qualified:
        sys.exit(FAILED)


def answers_found(found: Advice) -> Iterator[Part]:
    """The answer of each engine, and what is to be pasted."""
    from conrod.report.table import Verbatim

    for one in found.answers.values():
        yield from one["lines"]
        yield from (Verbatim(f"    {line}") for line in [*one.get("paste", "").splitlines(), ""])
