"""What a model requires and what is optional: the cost of each ingredient, and what it does to the motion."""

from __future__ import annotations

from collections.abc import Sequence

from conrod.engines.capabilities import MissingCapability, ModelIngredients, capability
from conrod.execution.case import Case, Results, pursue
from conrod.execution.resolve_arguments import (
    Engines,
    Scenes,
    check_sample_count,
    choose_engines,
    engine_names_given,
    scenes_by_name,
)
from conrod.execution.run import REVOLUTIONS
from conrod.execution.runner import Runner, Runs
from conrod.mechanism.units import check_count
from conrod.report.findings import Findings, text_of_call
from conrod.studies.ablate.findings import AblationStudy
from conrod.studies.ablate.report import ABLATE_REPORT
from conrod.studies.ablate.study import CostCase, ablate_engine, ablation_study

ROUNDS = 200
MIN_ROUNDS, MAX_ROUNDS = 2, 100_000


def ablate(
    scenes: Scenes,
    *,
    steps_per_rev: int | None = None,
    rounds: int = ROUNDS,
    engines: Engines = None,
    runs: Runs | None = None,
) -> Findings[AblationStudy]:
    """Add the ingredients of a model one by one to the minimal model, and take them from the full one.

    Args:
        rounds: number of times that each cost is measured.
        scenes, steps_per_rev, engines, runs: as in `validate`.

    Raises:
        InvalidInput: an argument cannot be used; says what can.
    """
    chosen = scenes_by_name(scenes)
    capabilities = {one: capability(one, ModelIngredients) for one in choose_engines(engines)}
    unsupported = {
        one.name: found.reason for one, found in capabilities.items() if isinstance(found, MissingCapability)
    }
    if steps_per_rev is not None:
        for name in chosen:
            check_sample_count(name, steps_per_rev, round(REVOLUTIONS))
    check_count("--rounds", rounds, MIN_ROUNDS, MAX_ROUNDS)
    taken = [one for one in capabilities if one.name not in unsupported]
    studies = [ablate_engine(*pair, one, steps_per_rev, rounds) for pair in chosen.items() for one in taken]
    with Runner.open(runs or Runs()) as runner, runner.case_runner() as run:

        def run_or_time(cases: Sequence[Case]) -> Results:
            """Run cases side by side, or alone if they measure costs."""
            # Runs of all side by side; timings after them, alone.
            timed = any(isinstance(case, CostCase) for case in cases)
            return runner.run_alone(cases, "costs") if timed else run(cases)

        found = iter(pursue(studies, run_or_time))
    parts = {
        name: ablation_study(name, scene, [next(found) for _ in taken], unsupported) for name, scene in chosen.items()
    }
    given = engine_names_given(engines)
    call = text_of_call("ablate", list(chosen), steps_per_rev=steps_per_rev, rounds=rounds, engines=given)
    return Findings(ABLATE_REPORT, parts, call)
