"""`conrod recommend`."""

from __future__ import annotations

import sys

import click

from conrod.cli import options


@options.verb()
@options.scene_argument()
@click.option("--position", type=float, metavar="E", help="Largest error of position, over the travel L.")
@click.option("--velocity", type=float, metavar="E", help="Largest error of velocity, over ω L.")
@click.option("--acceleration", type=float, metavar="E", help="Largest error of acceleration, over ω² L.")
@options.engine
@options.grid
@options.assignments
@options.of_timed_runs
def recommend(
    scene: str,
    position: float | None,
    velocity: float | None,
    acceleration: float | None,
    engine: str | None,
    grid: str,
    assignments: tuple[str, ...],
    how: options.TimedRunOptions,
) -> None:
    """The cheapest setting of each engine within all given tolerances, ready to paste.

    Runs that the grid needs and the ledger lacks are made first. The setting is confirmed on runs that the grid does
    not contain: another start angle, five revolutions, speeds 10 % off; of an input that makes one pass, that pass
    backwards, and those speeds.

    Exit status 0: at least one engine has such a setting; 1: none has; 2: bad usage.
    """
    from conrod.cli.runner import Runner
    from conrod.engines.rule import grid_named
    from conrod.report.recommendation import answer_lines
    from conrod.report.terminal import console, print_lines
    from conrod.studies.frame.case import pursue
    from conrod.studies.frame.files import naming
    from conrod.studies.frame.resolve_arguments import select_engines, select_scene
    from conrod.studies.sweep.recommend import Recommendation, check_tolerances, recommend_for
    from conrod.studies.sweep.study import plan_sweep

    name, chosen = select_scene(scene, assignments)
    allowed = check_tolerances({"position": position, "velocity": velocity, "acceleration": acceleration})
    plan = plan_sweep(name, chosen, select_engines(engine), grid_named(grid))
    with Runner.of(how) as runner, runner.answering() as run:
        (answers,) = pursue([recommend_for(plan, allowed, runner.time)], run)
    with naming("standard output"):
        out = console()
        for answer in answers:
            print_lines(out, answer_lines(answer, allowed))
            pasted = answer.paste.splitlines() if isinstance(answer, Recommendation) else []
            print_lines(out, [*pasted, ""], indent=4, verbatim=True)
    if not any(isinstance(answer, Recommendation) for answer in answers):
        sys.exit(options.FAILED)
