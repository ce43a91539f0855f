"""Motion without a drive: scenes let go, or driven by the torques of their loads, judged in time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from conrod.execution.baseline import SPEED_FACTORS as STEP_FACTORS
from conrod.execution.baseline_check import BaselineCheck
from conrod.execution.resolve_arguments import (
    Engines,
    Scenes,
    choose_engines,
    engine_names_given,
    scenes_by_name,
    select_presets,
)
from conrod.execution.runner import Runner, Runs
from conrod.execution.tolerances import check_tolerance
from conrod.mechanism.units import check_number
from conrod.report.findings import Findings, text_of_call
from conrod.studies.free_motion.baseline_lines import motion_lines
from conrod.studies.free_motion.plan import MotionPlan, initial_grid
from conrod.studies.free_motion.report import FREE_MOTION_REPORT
from conrod.studies.free_motion.results import FREE_MOTION_QUANTITIES, MotionStudy
from conrod.studies.free_motion.study import motion_study

SHORTEST_RUN, LONGEST_RUN, SHORTEST_STEP = 0.01, 1000.0, 1e-7  # [s]


def free_motion(
    scenes: Scenes = (),
    *,
    torque: bool = False,
    seconds: float | None = None,
    step: float | None = None,
    engines: Engines = None,
    preset: str | None = None,
    tolerance: Mapping[str, float | str] | None = None,
    baseline: str | Path | None = None,
    accept: bool = False,
    runs: Runs | None = None,
) -> Findings[MotionStudy]:
    """Compare the motion of scenes that no drive forces with the solution of their equations of motion.

    Args:
        torque: whether the driver's torques act; without, the machine moves by weight, springs and its start alone.
        seconds: length of the motion [s]; None for the scene's own, 10 s unless its engine breaks off.
        step: time step of the engines [s]; None for 5 ms or less.
        tolerance: largest error by quantity.
        scenes, engines, preset, baseline, accept, runs: as in `validate`.

    Raises:
        InvalidInput: an argument cannot be used, or a scene cannot move; says why.
    """
    chosen, chosen_engines = scenes_by_name(scenes), choose_engines(engines)
    presets = select_presets(chosen_engines, preset)
    longest = LONGEST_RUN if seconds is None else seconds
    check_number("--seconds", longest, SHORTEST_RUN, LONGEST_RUN, "s")
    if step is not None:
        check_number("--step", step, SHORTEST_STEP, longest, "s")
    allowed = None if tolerance is None else check_tolerance(tolerance, FREE_MOTION_QUANTITIES)
    plan = MotionPlan("torque" if torque else "free", seconds, step, allowed)
    if seconds is not None:
        initial_grid(plan, seconds)
    for name, scene in chosen.items():
        plan.keep_acting_loads(scene.kinematics.mechanism, name)
    options: dict[str, Any] = {"motion": plan.motion, "seconds": seconds, "step": step}
    options |= {"engine": engine_names_given(engines), "preset": preset}
    baseline_check = BaselineCheck.prepare(baseline, chosen, options, accept=accept)
    runs = replace(runs or Runs(), fresh=True) if baseline_check else runs or Runs()

    def find(plans: Sequence[MotionPlan]) -> list[list[MotionStudy]]:
        with Runner.open(runs) as runner:
            return runner.pursue([motion_study(chosen, chosen_engines, presets, one) for one in plans])

    (found,) = find([plan])
    compared = None
    if baseline_check:
        # The start may be at rest, and no speed drives the motion: steps are otherwise in the last bits instead.
        plans = [replace(plan, step_factor=factor) for factor in STEP_FACTORS]
        compared = baseline_check.compare(found, lambda _: find(plans), motion_lines)
    call = text_of_call(
        "free_motion",
        list(chosen),
        torque=torque,
        seconds=seconds,
        step=step,
        engines=engine_names_given(engines),
        preset=preset,
        tolerance=tolerance,
    )
    return Findings(FREE_MOTION_REPORT, {study.name: study for study in found}, call, baseline=compared)
