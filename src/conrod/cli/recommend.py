"""`conrod recommend`."""

from __future__ import annotations

import sys
from itertools import product

import click

from conrod.cli import options
from conrod.cli.say import say


@options.verb()
@options.scene_argument()
@click.option("--position", type=float, metavar="E", help="Largest error of position, over the travel L.")
@click.option("--velocity", type=float, metavar="E", help="Largest error of velocity, over ω L.")
@click.option("--acceleration", type=float, metavar="E", help="Largest error of acceleration, over ω² L.")
@options.engine
@click.option("--thorough", is_flag=True, help="Run a whole grid: minutes to an hour.")
@options.grid
@options.assignments
@options.of_timed_runs
@click.option("--model", metavar="FILE", help="Write the model with the settings, of an engine that has files (MJCF).")
@options.out
@options.document
def recommend(
    scene: str,
    position: float | None,
    velocity: float | None,
    acceleration: float | None,
    engine: str | None,
    thorough: bool,
    grid: str,
    assignments: tuple[str, ...],
    how: options.TimedRunOptions,
    model: str | None,
    out: str | None,
    document: str | None,
) -> None:
    """The cheapest setting of each engine within all given tolerances, ready to paste.

    Sweeps that ship with conrod say which settings to try; each is run on the machine itself, some dozens of runs.
    With --thorough, or another grid than the default, all of the grid are. Either way the answer is confirmed on other
    runs: with the numbers as they are pasted, another start angle, five revolutions, speeds 10 % off; of an input that
    makes one pass, that pass backwards, and those speeds.

    Exit status 0: at least one engine has such a setting; 1: none has; 2: bad usage.
    """
    from conrod.cli.outputs import outputs, reproduction
    from conrod.cli.runner import Runner
    from conrod.engines.capabilities import Lacking, ModelFile, capability
    from conrod.engines.rule import grid_named
    from conrod.errors import InvalidInput
    from conrod.report.recommendation import KIND, advice_of
    from conrod.report.terminal import console, print_lines
    from conrod.studies.frame.case import pursue
    from conrod.studies.frame.files import files_to_write, naming, single, write_together
    from conrod.studies.frame.resolve_arguments import select_engines, select_scene
    from conrod.studies.sweep.prior import shipped
    from conrod.studies.sweep.recommend import Recommendation, check_tolerances, recommend_for
    from conrod.studies.sweep.study import plan_sweep

    (name, chosen), engines = select_scene(scene, assignments), select_engines(engine)
    allowed = check_tolerances({"position": position, "velocity": velocity, "acceleration": acceleration})
    swept, thorough = grid_named(grid), thorough or grid != options.DEFAULT_GRID
    wanted = files_to_write({"--model": model}, {"the ledger": how.ledger_file})
    files = outputs(KIND, [name], out, document, {"the ledger": how.ledger_file, **wanted})
    writers = {one.name: made for one in engines if not isinstance(made := capability(one, ModelFile), Lacking)}
    if model and not writers:
        raise InvalidInput(f"--model: {', '.join(one.name for one in engines)} has no file of a model")
    plan = plan_sweep(name, chosen, engines, swept)
    prior = None if thorough else shipped()
    with Runner.of(how, files.file) as runner, runner.answering() as run:
        answers = pursue(recommend_for(plan, allowed, runner.time, prior), run)
    found = advice_of(name, chosen, allowed, answers)
    with naming("standard output"):
        for one in found.answers.values():
            print_lines(console(), one["lines"])
            print_lines(console(), [*one.get("paste", "").splitlines(), ""], indent=4, verbatim=True)
    qualified = [one for one in answers if isinstance(one, Recommendation)]
    given = {f"--{quantity}": value for quantity, value in allowed.items()} | {"--engine": engine}
    given |= {"--grid": None if grid == options.DEFAULT_GRID else grid}
    command = "recommend --thorough" if thorough else "recommend"
    files.write({name: found}, reproduction(command, (scene,), given, assignments, files.folder))
    written = [one.pasted for one in qualified if one.pasted.engine in writers][:1]
    for path, settings in product(wanted.values(), written):
        write_together([single(path, writers[settings.engine].model(name, chosen, settings))])
        say(f"model: {path}")
    if wanted and not written:
        say("conrod: no model is written: nothing qualifies", err=True)
    if not qualified or (wanted and not written):
        sys.exit(options.FAILED)
