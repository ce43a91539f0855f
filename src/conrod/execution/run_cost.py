"""Cost of a run relative to a reference workload that is timed in turns with it, to be kept in a baseline.

The workload is the engine's reference loop, a fixed slider-crank, in the same process: a machine that is slower or busy
slows both, so that the ratio carries from one day to another, and roughly from one machine to another.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from conrod.comparison.trajectory import Settings
from conrod.engines import engine_named
from conrod.engines.capabilities import MissingCapability, TimedStepping, capability
from conrod.engines.engine import Machine
from conrod.execution.baseline import KeptCost
from conrod.execution.baseline_check import line_name
from conrod.execution.local import FailedCall, call_isolated
from conrod.execution.paired_timing import PairedTiming, time_stepper_pair
from conrod.execution.result import Plan, SceneResults
from conrod.scenes import Scene

COST_TIMEOUT = 60.0  # [s] for a timing of some tenths

COST_DIGITS = 3  # of a cost that are kept: further ones are noise


def cost_of_run(machine: Machine, settings: Settings) -> PairedTiming | None:
    """Time a step of a run against a step of the engine's reference loop; None where the engine cannot be timed.

    Nor can a machine that makes one pass: its stepper must not be driven beyond the end.
    """
    made = capability(engine_named(settings.engine), TimedStepping)
    if isinstance(made, MissingCapability) or machine.kinematics.mechanism.driver.span is not None:
        return None
    stepping = made
    return time_stepper_pair(lambda: stepping.stepper(machine, settings), stepping.reference_loop)


def scene_costs(found: Sequence[SceneResults[Any]], scenes: Mapping[str, Scene], plan: Plan) -> dict[str, KeptCost]:
    """Costs of the completed runs of a validation by line name, each timed in a separate process."""
    costs = {}
    for study in found:
        for result in study.results:
            if result.preset is None or not result.completed:
                continue
            scene = scenes[study.name]
            settings = engine_named(result.engine).presets[result.preset](scene, plan.steps(scene))
            timing = call_isolated(cost_of_run, scene, settings, timeout=COST_TIMEOUT)
            if timing is not None and not isinstance(timing, FailedCall):
                name = line_name(study.name, result, several=len(found) > 1)
                costs[name] = KeptCost(
                    *(float(f"{one:.{COST_DIGITS}g}") for one in (timing.ratio, timing.low, timing.high))
                )
    return costs
