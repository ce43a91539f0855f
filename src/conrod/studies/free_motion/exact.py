"""Exact free motion of a scene, and the step size for engines that its time scales demand."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import lru_cache

import numpy as np

from conrod.engines.tracks import Pace
from conrod.errors import InvalidInput
from conrod.exact.dynamics import coordinate_jet
from conrod.exact.dynamics.contact import check_contact
from conrod.exact.dynamics.forward import ForwardDynamics, FreeMotion
from conrod.exact.dynamics.reduced_dynamics import ReducedDynamics
from conrod.exact.joint_equations import pose_jets
from conrod.exact.motion import Array
from conrod.mechanism.loads import Friction, LoadLaw, StrokePulse, TimePulse
from conrod.mechanism.mechanism import Mechanism
from conrod.scenes import Scene
from conrod.studies.free_motion.plan import (
    MAX_SECONDS,
    MAX_TURNS,
    MotionPlan,
    TimeGrid,
    fastest_turn_period,
    initial_grid,
    refine_grid,
    refinement_steps,
)

PROBE_SECONDS = 1.0  # [s], of the motion from whose fastest turn the duration is derived
# Number of loops that may be singular at once. Errors of hardened MuJoCo are 3e-8 to 7e-7 of the length in chains of 2
# to 14 four-bars, and 7e-6 to 0.05 in longer ones, where its solver's rounding decides (docs/free-motion.md, "Long
# chains").
MAX_CROSSING_LOOPS = 10
STANDING_RATE_RATIO = 1e-6  # of the fastest body's rate: a crank below it stands
CACHED_COURSES = 4  # in a process, which runs several engines and presets with one exact motion


@dataclass(frozen=True)
class ExactCourse:
    """The exact motion of a scene, with all that a run in an engine needs to follow it.

    Attributes:
        mechanism: the mechanism with the loads that act.
        grid: instants of `motion`, and step size of the engines.
        motion: the exact motion.
        lengths: travel L of each observed point [m].
        pace: fastest time scale of the motion.
        refinement: divisors of the grid's step size along the refinement path.
        unresolved: reason why no preset is judged unless a tolerance is given; empty if presets are judged.
    """

    mechanism: Mechanism
    grid: TimeGrid
    motion: FreeMotion
    lengths: Mapping[str, float]
    pace: Pace
    refinement: tuple[Fraction, ...]
    unresolved: str = ""


@lru_cache(CACHED_COURSES)
def exact_course(name: str, scene: Scene, plan: MotionPlan) -> ExactCourse:
    """Compute the exact motion of a scene and its time grid; results are cached.

    Args:
        plan: a plan without tolerances, so that plans which differ in them alone share a result.

    Raises:
        InvalidInput: the start contradicts the joints or is a rest that no load ends, a force is not finite, moving
            bodies have no inertia, the follower would leave the cam, or there would be too many steps.
    """
    grid = initial_grid(plan, run_duration(name, scene, plan))
    grid = replace(grid, step=grid.step * plan.step_factor)
    dynamics = _forward_dynamics(name, scene, plan.motion)
    mechanism = dynamics.mechanism
    motion = dynamics.motion(grid.times, rates=scene.start_rates)
    check_contact(name, mechanism, motion)
    pace = _motion_pace(mechanism, motion)
    if fastest_turn_period(mechanism, motion) == math.inf:
        raise InvalidInput(f"{name}: it stays at rest: there is no motion to compare; start it in motion")
    grid = refine_grid(plan, grid, mechanism, pace)
    unresolved = _unresolved_reason(mechanism, motion, dynamics.reduced, grid.step)
    refinement = refinement_steps(plan, mechanism, pace)
    return ExactCourse(mechanism, grid, motion, scene.lengths, pace, refinement, unresolved)


@lru_cache(CACHED_COURSES)
def _forward_dynamics(name: str, scene: Scene, motion: str) -> ForwardDynamics:
    """Return the dynamics of a scene with the loads that act, and with the configurations that are known so far."""
    return ForwardDynamics(MotionPlan(motion).keep_acting_loads(scene.kinematics.mechanism, name))


@lru_cache(CACHED_COURSES)
def run_duration(name: str, scene: Scene, plan: MotionPlan) -> float:
    """Return the plan's duration [s]; by rule 10 s, or 50 fastest turns if that is less."""
    if plan.seconds is not None:
        return plan.seconds
    dynamics = _forward_dynamics(name, scene, plan.motion)
    times = initial_grid(replace(plan, step=None), PROBE_SECONDS).times
    motion = dynamics.motion(times, rates=scene.start_rates)
    return min(MAX_SECONDS, MAX_TURNS * _motion_pace(dynamics.mechanism, motion).revolution)


def _motion_pace(mechanism: Mechanism, motion: FreeMotion) -> Pace:
    """Return the pace of a motion; a pulse of a load counts as a turn."""
    return Pace(
        min(fastest_turn_period(mechanism, motion), shortest_pulse_duration(mechanism, motion)), bool(motion.crossings)
    )


def _unresolved_reason(mechanism: Mechanism, motion: FreeMotion, reduced: ReducedDynamics, step: float) -> str:
    """Return why errors with a step size [s] cannot be judged by rule; empty if they can.

    Either rounding grows, where many loops or a standing crank are singular at a crossing, or a step is longer than the
    time in which friction changes its sign.
    """
    loops = len(mechanism.joints) - len(mechanism.bodies)
    if motion.crossings and loops > MAX_CROSSING_LOOPS:
        return (
            f"where branches cross, {loops} loops are singular at once, and what an engine rounds grows there: with "
            f"more than {MAX_CROSSING_LOOPS} errors are measured, and judged by --tolerance alone"
        )
    if _crank_stands_at_a_crossing(mechanism, motion, reduced):
        return (
            "the crank stands in a dead centre just where branches cross: closures are singular more than once there, "
            "and what an engine rounds grows; errors are measured, and judged by --tolerance alone"
        )
    name, time = quickest_reversal(mechanism, motion)
    if step <= time:
        return ""
    digit = 10.0 ** math.floor(math.log10(time))
    enough = 1e3 * digit * math.floor(time / digit)
    return (
        f"the sign of {name} changes within {1e3 * time:.2g} ms, less than a step of {1e3 * step:.4g} ms: errors are "
        f"measured, and judged by --tolerance alone, or with --step {enough:.1g}ms"
    )


def _crank_stands_at_a_crossing(mechanism: Mechanism, motion: FreeMotion, reduced: ReducedDynamics) -> bool:
    """True if the crank is at rest, in a dead centre, in a configuration where branches cross."""
    if not motion.crossings:
        return False
    turning = 3 * mechanism.body_index[mechanism.crank] + 2
    crossings = reduced.crossings(float(motion.along.min()), float(motion.along.max()))
    tangents = np.abs([reduced.poses_with_derivatives(along)[1] for along in crossings])[:, 2::3]
    return bool((tangents[:, turning // 3] < STANDING_RATE_RATIO * tangents.max(axis=1)).any())


def observed_positions(mechanism: Mechanism, poses: Array) -> dict[str, Array]:
    """Return the positions (T, 2) [m] of the observed points in poses (T, 3 n)."""
    bodies = pose_jets(mechanism, [poses])
    return {
        point.name: np.column_stack([np.asarray(jet.coefficients[0]) for jet in bodies[point.body].point(point.point)])
        for point in mechanism.observed
    }


def shortest_pulse_duration(mechanism: Mechanism, motion: FreeMotion) -> float:
    """Return the duration of the shortest load pulse [s]; inf if none acts.

    A pulse over a stretch of a coordinate takes its length over the highest rate at which it acts.
    """
    times = [math.inf]
    for _, law, (value, rate, _) in _load_coordinates(mechanism, motion):
        if isinstance(law, TimePulse) and law.start < motion.times[-1]:
            times.append(law.stop - law.start)
        if isinstance(law, StrokePulse):
            acts = (law.start < value) & (value < law.stop) & (rate * law.sense > 0.0)
            speed = float(np.abs(rate[acts]).max(initial=0.0))
            times.append((law.stop - law.start) / speed if speed > 0.0 else math.inf)
    return min(times)


def quickest_reversal(mechanism: Mechanism, motion: FreeMotion) -> tuple[str, float]:
    """Return the friction whose sign changes fastest, by name, and the time of the change [s].

    Friction changes its sign at rates within its creep rate, which take the time creep / max|acceleration|.

    Returns:
        An empty name and inf if no friction changes its sign.
    """
    found = [("", math.inf)]
    for name, law, (_, rate, acceleration) in _load_coordinates(mechanism, motion):
        if isinstance(law, Friction):
            turns = np.flatnonzero(rate[:-1] * rate[1:] < 0.0)
            steepest = float(np.abs(acceleration[np.concatenate([turns, turns + 1])]).max(initial=0.0))
            found.append((name, law.creep / steepest if steepest > 0.0 else math.inf))
    return min(found, key=lambda one: one[1])


def _load_coordinates(
    mechanism: Mechanism, motion: FreeMotion
) -> Iterator[tuple[str, LoadLaw, tuple[Array, Array, Array]]]:
    """Yield each load's name, law, and coordinate with first and second time derivative (T,)."""
    bodies = pose_jets(mechanism, [motion.poses, motion.rates, 0.5 * motion.accelerations])
    for load in mechanism.loads:
        value, rate, half = (np.asarray(c) for c in coordinate_jet(load.along, bodies).coefficients)
        yield load.name, load.law, (value, rate, 2.0 * half)
