"""A machine in space in an engine: its exact start, its runs with growing numbers of steps, and their errors."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cache, partial

import numpy as np

from conrod.comparison.outcome import MAX_JOINT_GAP, MAX_REACH_SIZES
from conrod.comparison.trajectory import Outcome
from conrod.engines import engine_named
from conrod.engines.capabilities import SpatialRuns, failure_of, require_capability
from conrod.engines.plugin_values import EngineFault
from conrod.engines.space import SpatialRun, SpatialStart, exact_start, widest_gaps
from conrod.errors import InvalidInput
from conrod.exact.motion import QUANTITIES, Array
from conrod.scenes.space import MACHINES, SpatialMachine
from conrod.scenes.space.tree import exact_points, machine_laws, spatial_tree
from conrod.studies.space.plan import SpatialCell, motion_scales
from conrod.studies.space.results import SpatialResult, StepRun, observed_orders

MAX_SAMPLES = 2000  # of a run, that are compared with the closed form
TIMED_STEPS, TIMINGS = 200, 3  # steps of a timing at most, half of them to warm up; timings, of which the least counts


@dataclass(frozen=True, eq=False)
class SpatialBench:
    """A machine in space with its exact start and motion: in closed form, or of its own tree where it has none."""

    machine: SpatialMachine | None
    start: SpatialStart

    def exact(self, times: Array) -> Mapping[str, Array]:
        """Exact position, velocity and acceleration (3, T, 3) of each observed point at times (T,) [s]."""
        if self.machine is not None:
            return exact_points(self.machine, times)
        moved = self.start.machine.motion(times, 2).points
        return {name: np.array([one.position, one.velocity, one.acceleration]) for name, one in moved.items()}


@cache
def prepare_bench(name: str) -> SpatialBench:
    """Read a machine, and find its exact state at time 0; its step is yet to be set."""
    machine = MACHINES[name]()
    laws = machine_laws(machine)
    return SpatialBench(machine, exact_start(spatial_tree(machine), laws, exact_points(machine, np.zeros(1))))


def run_cell(cell: SpatialCell) -> SpatialResult:
    """Run a machine in an engine with each number of steps, and compare it; call it in a separate process."""
    empty, runs = cell.empty_result(), list[StepRun]()
    bench = prepare_bench(cell.machine) if cell.model is None else SpatialBench(None, cell.model.start)
    scales = motion_scales(MACHINES[cell.machine]()) if cell.model is None else cell.model.scales
    engine = require_capability(engine_named(cell.engine), SpatialRuns)
    try:
        reason = engine.refusal_in_space(bench.start, cell.preset)
    except EngineFault as fault:
        return replace(empty, outcome=Outcome.CRASHED.slug, reason=str(fault))
    if reason:
        return replace(empty, outcome=Outcome.UNSUPPORTED.slug, reason=reason)
    for steps in cell.steps:
        start = replace(bench.start, step=bench.start.period / steps)
        try:
            runs.append(_timed_run(engine, start, cell, steps, bench, scales))
        except InvalidInput as error:
            runs.append(StepRun(steps, Outcome.UNSUPPORTED.slug, str(error)))
        except EngineFault as fault:
            runs.append(StepRun(steps, Outcome.CRASHED.slug, str(fault)))
    made = replace(empty, runs=tuple(runs), order=observed_orders(tuple(runs)))
    return replace(made, outcome=runs[-1].outcome, reason=runs[-1].reason)


def _timed_run(
    engine: SpatialRuns,
    start: SpatialStart,
    cell: SpatialCell,
    steps: int,
    bench: SpatialBench,
    scales: Mapping[str, float],
) -> StepRun:
    """Run a machine from its exact start, compare it, and time a step if it came to its end."""
    total = steps * cell.revolutions
    run = engine.run_in_space(start, cell.preset, total, max(1, total // MAX_SAMPLES))
    judged = judge_run(steps, run, bench, scales)
    if judged.errors is None:
        return judged
    make = partial(engine.stepper_in_space, start, cell.preset)
    return replace(judged, cost=step_cost(make, min(total, TIMED_STEPS)))


def judge_run(steps: int, run: SpatialRun, bench: SpatialBench, scales: Mapping[str, float]) -> StepRun:
    """Compare a run with the exact motion at the same times."""
    length = scales[QUANTITIES[0]]
    gaps = widest_gaps(bench.start.tree, run)
    gap = max(gaps.values(), default=0.0) / length
    if run.failure:
        return StepRun(steps, Outcome.DIVERGED.slug, run.failure, gap=gap)
    finite = np.all([np.isfinite(one).all(axis=(0, 2)) for one in run.points.values()], axis=0)
    if not finite.all():
        return StepRun(steps, Outcome.DIVERGED.slug, f"not finite from {run.times[np.argmin(finite)]:.6g} s on")
    exact = bench.exact(run.times)
    off = np.array([np.linalg.norm(run.points[name] - exact[name], axis=2).max(axis=1) for name in exact]).max(axis=0)
    errors = {name: float(size) / scales[name] for name, size in zip(QUANTITIES, off, strict=True)}
    if errors["position"] > MAX_REACH_SIZES:
        return StepRun(steps, Outcome.EXPLODED.slug, f"a point is {errors['position']:.3g} L away", gap=gap)
    if gap > MAX_JOINT_GAP:
        name = max(gaps, key=gaps.__getitem__)
        return StepRun(steps, Outcome.OPENED.slug, f"{name} opens by {1e3 * gaps[name]:.3g} mm", gap=gap)
    return StepRun(steps, Outcome.COMPLETED.slug, errors=errors, gap=gap)


def step_cost(make: Callable[[], Callable[[int], None]], steps: int) -> float:
    """CPU time of a step [µs] of a stepper with nothing recorded, the least of some timings of half of the steps.

    The other half warms up: laws of drives are evaluated for many steps at once. NaN where a stepper has failed, as
    some that are asked for many steps at once do: its calls cost nothing then.
    """
    found, half = [], max(1, steps // 2)
    for _ in range(TIMINGS):
        stepper = make()
        stepper(half)
        begun = time.process_time()
        stepper(half)
        found.append(time.process_time() - begun)
        if failure_of(stepper):
            return math.nan
    return 1e6 * min(found) / half
