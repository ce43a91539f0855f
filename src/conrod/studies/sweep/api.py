"""The trade of speed for accuracy: all settings of a grid, and the cheapest one within tolerances."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial

from conrod.engines.variants import grid_named
from conrod.execution.case import pursue
from conrod.execution.resolve_arguments import (
    Engines,
    OneScene,
    Scenes,
    choose_engines,
    engine_names_given,
    scene_by_name,
    scenes_by_name,
)
from conrod.execution.runner import Runner, Runs
from conrod.execution.timing import time_cases
from conrod.execution.tolerances import scale_tolerance, scene_scales
from conrod.report.findings import Findings, text_of_call
from conrod.scenes import Scene
from conrod.studies.sweep import recommendation_report as recommendation
from conrod.studies.sweep.findings import SweepStudy
from conrod.studies.sweep.prior import shipped_sweeps
from conrod.studies.sweep.recommend import Answer, check_tolerances, recommendation_studies
from conrod.studies.sweep.recommendation_report import Advice, advice_of
from conrod.studies.sweep.report import SWEEP_REPORT
from conrod.studies.sweep.study import plan_sweep, sweep_scene


def sweep(
    scenes: Scenes, *, grid: str = "default", engines: Engines = None, runs: Runs | None = None
) -> Findings[SweepStudy]:
    """Measure error and cost of every setting of a grid.

    Args:
        grid: "coarse", "default", or "presets": every preset of each engine, at more steps.
        scenes, engines, runs: as in `validate`.

    Raises:
        InvalidInput: an argument cannot be used; says what can.
    """
    chosen, chosen_engines = scenes_by_name(scenes), choose_engines(engines)
    swept = grid_named(grid)
    plans = [plan_sweep(name, scene, chosen_engines, swept) for name, scene in chosen.items()]
    with Runner.open(runs or Runs()) as runner:
        studies = runner.pursue([sweep_scene(plan, partial(time_cases, runner)) for plan in plans])
    call = text_of_call("sweep", list(chosen), grid=grid, engines=engine_names_given(engines))
    return Findings(SWEEP_REPORT, {study.name: study for study in studies}, call)


def recommend(
    scene: OneScene,
    tolerance: Mapping[str, float | str | None],
    *,
    engines: Engines = None,
    runs: Runs | None = None,
) -> Findings[Advice]:
    """Find the cheapest settings of each engine within tolerances, confirmed on other runs, ready to paste.

    Args:
        tolerance: largest error of position, velocity and acceleration, normalised, or as text with a unit:
            {"position": 1e-6}, {"position": "0.01mm"}.
        scene, engines, runs: as in `validate`.

    Raises:
        InvalidInput: an argument cannot be used; says what can.
    """
    named = scene_by_name(scene)
    answers = cheapest_settings(named, tolerance, engines=engines, runs=runs)
    return findings_of(named, tolerance, answers, engine_names_given(engines))


def cheapest_settings(
    scene: OneScene, tolerance: Mapping[str, float | str | None], *, engines: Engines = None, runs: Runs | None = None
) -> list[Answer]:
    """The answer of each engine to `recommend`, with its settings as objects; arguments and errors as there."""
    (name, chosen), chosen_engines = scene_by_name(scene), choose_engines(engines)
    allowed = check_tolerances(tolerance)
    plan = plan_sweep(name, chosen, chosen_engines, "default")
    with Runner.open(runs or Runs()) as runner, runner.case_runner() as run:
        return pursue(recommendation_studies(plan, allowed, partial(time_cases, runner), shipped_sweeps()), run)


def findings_of(
    scene: tuple[str, Scene],
    tolerance: Mapping[str, float | str | None],
    answers: Sequence[Answer],
    engines: tuple[str, ...] = (),
) -> Findings[Advice]:
    """Answers of engines as findings that a report shows."""
    asked = check_tolerances(tolerance)
    allowed, _ = scale_tolerance(asked, scene_scales(scene[1]))
    found = advice_of(*scene, allowed, answers)
    given = {name: size for name, size in tolerance.items() if size is not None}
    call = text_of_call("recommend", scene[0], tolerance=given, engines=engines)
    return Findings(recommendation.RECOMMENDATION_REPORT, {scene[0]: found}, call)
