"""`conrod recommend`."""

from __future__ import annotations

import sys

import click

from conrod.commands import exit_status, options


@click.command()
@click.argument("scene")
@click.option("--position", type=float, metavar="E", help="Largest error of position, over the travel L.")
@click.option("--velocity", type=float, metavar="E", help="Largest error of velocity, over omega L.")
@click.option("--acceleration", type=float, metavar="E", help="Largest error of acceleration, over omega^2 L.")
@options.engine
@options.grid
@options.assignments
@options.runs
@options.retime
def recommend(
    scene: str,
    position: float | None,
    velocity: float | None,
    acceleration: float | None,
    engine: str | None,
    grid: str,
    assignments: tuple[str, ...],
    ledger: str | None,
    fresh: bool,
    jobs: int | None,
    cluster: str | None,
    cell_timeout: float | None,
    cell_memory: str | None,
    retime: bool,
) -> None:
    """The cheapest setting of each engine within all given tolerances, ready to paste.

    Runs that the grid needs and the ledger lacks are made first. What is printed was confirmed on runs that the grid
    does not contain: another start angle, five revolutions, speeds 10 % off; of an input that makes one pass, that
    pass backwards, and those speeds.

    Exit status 0: at least one engine has such a setting; 1: none has; 2: bad usage.
    """
    from conrod.commands.runner import Options, Runner
    from conrod.engines.rule import grid_named
    from conrod.files import naming
    from conrod.recommend_console import print_recommendations
    from conrod.selection import select_engines, select_scene
    from conrod.studies.choice import check_tolerances, recommend_for
    from conrod.studies.recommendation import Recommendation
    from conrod.studies.sweep import plan_sweep

    allowed = check_tolerances({"position": position, "velocity": velocity, "acceleration": acceleration})
    name, chosen = select_scene(scene, assignments)
    plan = plan_sweep(name, chosen, select_engines(engine), grid_named(grid))
    with Runner.of(Options(ledger, fresh, jobs, cluster, cell_timeout, cell_memory, retime)) as runner:
        found = recommend_for(plan, allowed, runner)
    with naming("standard output"):
        print_recommendations(found, allowed)
    if not any(isinstance(answer, Recommendation) for answer in found):
        sys.exit(exit_status.FAILED)
