"""`conrod sweep`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import click

from conrod.cli import options
from conrod.cli.options import RunOptions, StudyOptions, option

if TYPE_CHECKING:
    from conrod.studies.sweep.findings import SweepStudy


@dataclass(frozen=True)
class Asked(StudyOptions, RunOptions):
    """Request to `conrod sweep`, as typed."""

    grid: str = option("--grid")


@options.verb()
@click.argument("scenes", nargs=-1, required=True, metavar="SCENE...")
@options.gathered("asked", Asked)
def sweep(scenes: tuple[str, ...], asked: Asked) -> None:
    """Measure the trade of speed for accuracy: error and cost of every setting of a grid.

    The grid `presets` has engines beside each other: every preset of each, at more steps.

    Finished runs are kept in the ledger and never run again: an interrupted sweep goes on where it stopped.
    """
    from conrod.cli.outputs import outputs
    from conrod.cli.runner import Runner
    from conrod.engines.variants import grid_named
    from conrod.report.sweep.report import KIND
    from conrod.studies.frame.case import pursue
    from conrod.studies.frame.resolve_arguments import select_scenes
    from conrod.studies.frame.writing import naming
    from conrod.studies.sweep.study import plan_sweep, sweep_scene

    chosen, engines = select_scenes(scenes, asked.assignments), options.chosen_engines(asked.engine)
    swept = grid_named(asked.grid)
    files = outputs(KIND, chosen, asked)
    plans = [plan_sweep(name, scene, engines, swept) for name, scene in chosen.items()]
    with Runner.of(asked) as runner, runner.answering() as run:
        studies = pursue([sweep_scene(plan, runner.time) for plan in plans], run)
    with naming("standard output"):
        print_fronts(studies)
    files.write({study.name: study for study in studies}, "sweep", scenes, asked)


def print_fronts(studies: Sequence[SweepStudy]) -> None:
    """For each scene and engine the settings that no other one beats in both cost and position error."""
    from conrod.report.sweep.tables import RATIO, end_words, front_table
    from conrod.report.terminal import console, print_lines, print_table

    out = console()
    for study in studies:
        title = f"{study.name}: settings that none beats in both cost and position"
        print_table(out, front_table(study, title))
        unsupported = [f"{name} unsupported: {why}" for name, why in study.unsupported.items()]
        print_lines(out, [RATIO, f"{len(study.points)} settings and steps: {end_words(study)}", *unsupported])
