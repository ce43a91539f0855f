"""Steady motion: scenes in engines at constant crank speed, judged by their exact motion."""

from __future__ import annotations

from collections.abc import Generator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from conrod.engines import Engine
from conrod.errors import InvalidInput
from conrod.execution.resolve_arguments import (
    MAX_KEPT_SAMPLES,
    MAX_STREAMED_SAMPLES,
    Engines,
    Scenes,
    choose_engines,
    engine_names_given,
    make_plan,
    scenes_by_name,
    select_presets,
)
from conrod.execution.result import Plan
from conrod.execution.runner import Runner, Runs
from conrod.mechanism.units import check_number
from conrod.report.findings import Findings, text_of_call
from conrod.scenes import Scene
from conrod.studies.validation.report import VALIDATION_REPORT
from conrod.studies.validation.results import SceneStudy
from conrod.studies.validation.study import validation_study

if TYPE_CHECKING:
    from conrod.execution.baseline_check import BaselineCheck

REVOLUTIONS = 2
MIN_COST_RATIO, MAX_COST_RATIO = 1.0, 1000.0  # of the baseline's cost


def validate(
    scenes: Scenes = (),
    *,
    engines: Engines = None,
    preset: str | None = None,
    steps_per_rev: int | None = None,
    revolutions: int = REVOLUTIONS,
    tolerance: Mapping[str, float | str] | None = None,
    qualify: bool = False,
    baseline: str | Path | None = None,
    accept: bool = False,
    cost_ratio: float | None = None,
    runs: Runs | None = None,
) -> Findings[SceneStudy]:
    """Compare engines with the exact motion of scenes whose crank turns at constant speed.

    Args:
        scenes: names, mechanism files or scenes; the four with a closed form where none is given.
        engines: names of engines, or "all" for the installed ones; the default engines where none is given.
        preset: preset of settings; all of them where none is given.
        steps_per_rev: time steps in one revolution of the crank; 1000, or 62832 for a cam in contact.
        revolutions: revolutions of the crank.
        tolerance: largest error by quantity, such as {"position": 1e-4}, in place of what the engine's law allows.
        qualify: plant known defects in each judged run, and say which of them the verdict notices.
        baseline: file of an earlier validation to compare with; written where there is none.
        accept: write the baseline again.
        cost_ratio: keep the cost of each run in the baseline, and allow so many times the earlier one; 0 to report the
            ratio alone, None for no costs.
        runs: how runs are made, and where their results are kept.

    Raises:
        InvalidInput: an argument cannot be used; says what can.
    """
    runs = runs or Runs()
    chosen, chosen_engines = scenes_by_name(scenes), choose_engines(engines)
    presets = select_presets(chosen_engines, preset)
    # A run in which defects are planted is recorded whole.
    max_samples = MAX_KEPT_SAMPLES if qualify else MAX_STREAMED_SAMPLES
    plan = make_plan(chosen, steps_per_rev, revolutions, tolerance, max_samples)
    options = {"engine": engine_names_given(engines), "preset": preset, "steps-per-rev": steps_per_rev}
    options |= {"revolutions": None if revolutions == REVOLUTIONS else revolutions}
    baseline_check: BaselineCheck | None = None
    if cost_ratio is not None:
        if baseline is None:
            raise InvalidInput("--cost-ratio: it is for a baseline, name its file with --baseline")
        check_number("--cost-ratio", cost_ratio or MIN_COST_RATIO, MIN_COST_RATIO, MAX_COST_RATIO)
    if baseline or accept:
        from conrod.execution.baseline_check import BaselineCheck, scene_lines
        from conrod.execution.run_cost import scene_costs

        baseline_check = BaselineCheck.prepare(baseline, chosen, options, accept=accept)
    # What is compared is run: no earlier result answers for it.
    runs = replace(runs, fresh=True) if baseline_check else runs

    def validate_groups(groups: Sequence[Mapping[str, Scene]], qualify: bool) -> list[Sequence[SceneStudy]]:
        with Runner.open(runs) as runner:
            return runner.pursue([_study_scenes(scenes, chosen_engines, presets, plan, qualify) for scenes in groups])

    (found,) = validate_groups([chosen], qualify)
    # A baseline measures its rounding bands by further runs, of the scenes at speeds that differ in the last bits.
    compared = None
    if baseline_check:
        timed = {} if cost_ratio is None else scene_costs(found, chosen, plan)
        again = partial(validate_groups, qualify=False)
        compared = baseline_check.compare(found, again, scene_lines, costs=timed, cost_ratio=cost_ratio or None)
    call = text_of_call(
        "validate",
        list(chosen),
        engines=engine_names_given(engines),
        preset=preset,
        steps_per_rev=steps_per_rev,
        revolutions=options["revolutions"],
        tolerance=tolerance,
        qualify=qualify,
    )
    return Findings(VALIDATION_REPORT, {study.name: study for study in found}, call, baseline=compared)


def _study_scenes(
    scenes: Mapping[str, Scene],
    engines: Sequence[Engine[Any]],
    presets: Mapping[str, tuple[str, ...]],
    plan: Plan,
    qualify: bool,
) -> Generator[Any, Any, Sequence[SceneStudy]]:
    """Study that validates scenes and, if asked, plants defects in their judged runs."""
    found = yield from validation_study(scenes, engines, presets, plan)
    if not qualify:
        return found
    from conrod.studies.detection.qualification import qualification_study

    return (yield from qualification_study(found, scenes, engines, plan))
