"""`conrod ablate`."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import click

from conrod.cli import options
from conrod.cli.options import StudyOptions, option

if TYPE_CHECKING:
    from conrod.report.terminal import Part
    from conrod.studies.ablate_findings import AblationStudy
    from conrod.studies.frame.case import Case, Measurement

CAPTION = (
    "cost: with it over without it, the median and the interval that holds it with 95 %; change: of the position, "
    "over the travel L"
)
ROUNDS = 200
LEAST_ROUNDS, MOST_ROUNDS = 2, 100_000


@dataclass(frozen=True)
class Asked(StudyOptions):
    """Request to `conrod ablate`, as typed; None or empty where nothing was given."""

    steps_per_rev: int | None = option(
        "--steps-per-rev", type=int, metavar="N", help="Time steps in one turn of the crank [1000, contact 62832]."
    )
    rounds: int = option(
        "--rounds", type=int, default=ROUNDS, show_default=True, metavar="N", help="How often each cost is taken."
    )


@options.verb(Asked)
@click.argument("scenes", nargs=-1, required=True, metavar="SCENE...")
def ablate(scenes: tuple[str, ...], asked: Asked) -> None:
    """Measure what a model requires and what is optional: each ingredient's cost, and what it does to the motion.

    Ingredients are added to the minimal model one by one and all together, and taken from the full one.
    Finished runs are kept in the ledger: an interrupted study goes on where it stopped.
    """
    from conrod.cli.outputs import outputs
    from conrod.cli.runner import Runner
    from conrod.engines.capabilities import MissingCapability, ModelIngredients, capability
    from conrod.mechanism.units import check_count
    from conrod.report.ablate import KIND
    from conrod.studies.ablate import CostCase, ablate_engine, ablation_study
    from conrod.studies.frame.case import pursue
    from conrod.studies.frame.resolve_arguments import check_table, select_scenes
    from conrod.studies.frame.run import REVOLUTIONS

    chosen, steps = select_scenes(scenes, asked.assignments), asked.steps_per_rev
    able = {one: capability(one, ModelIngredients) for one in options.chosen_engines(asked.engine)}
    unsupported = {one.name: found.reason for one, found in able.items() if isinstance(found, MissingCapability)}
    if steps is not None:
        for name in chosen:
            check_table(name, steps, round(REVOLUTIONS))
    check_count("--rounds", asked.rounds, LEAST_ROUNDS, MOST_ROUNDS)
    files = outputs(KIND, chosen, asked)
    engines = [one for one in able if one.name not in unsupported]
    asked_for = [ablate_engine(*pair, one, steps, asked.rounds) for pair in chosen.items() for one in engines]
    with Runner.of(asked) as runner, runner.answering() as run:

        def answer(cases: Sequence[Case]) -> Mapping[str, Measurement]:
            # Runs of all side by side; timings after them, alone.
            timed = any(isinstance(case, CostCase) for case in cases)
            return runner.run_alone(cases, "costs") if timed else run(cases)

        found = iter(pursue(asked_for, answer))
    studies = [
        ablation_study(name, scene, [next(found) for _ in engines], unsupported) for name, scene in chosen.items()
    ]
    files.answer({study.name: study for study in studies}, ablations(studies), "ablate", scenes)


def ablations(studies: Sequence[AblationStudy]) -> Iterator[Part]:
    """For each scene and engine, what every ingredient costs and changes, and what follows."""
    from conrod.report.ablate import ingredients_table, speed_up
    from conrod.report.numbers import lengths

    for study in studies:
        for found in study.engines:
            if found.ingredients:
                yield ingredients_table(found, f"{study.name}, {found.engine}")
                yield CAPTION + lengths(study.lengths)
            yield speed_up(found).replace("**", "")
        yield from (f"{name} unsupported: {why}" for name, why in study.unsupported.items())
