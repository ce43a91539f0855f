"""The exact motion that engines are held against, the step that they are run with, and the times that bound it."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from conrod.engines.tracks import Pace
from conrod.errors import InvalidInput
from conrod.exact.dynamics import coordinate_jet
from conrod.exact.dynamics.forward import ForwardDynamics, FreeMotion
from conrod.exact.dynamics.inverse import joint_forces_of_motion
from conrod.exact.dynamics.reduced_dynamics import ReducedDynamics
from conrod.exact.joint_equations import pose_jets
from conrod.exact.kinematics import Kinematics
from conrod.exact.motion import Array
from conrod.mechanism.loads import Friction, LoadLaw, StrokePulse, TimePulse
from conrod.mechanism.mechanism import Mechanism
from conrod.scenes import Scene
from conrod.studies.free_motion.plan import SECONDS, TURNS, Grid, MotionPlan, chosen, fastest_turn, instants

# Of the largest push of a contact, what rounding may make of one that is none.
NO_PULL = 1e-9
PROBE = 1.0  # [s] of a motion, by which its cost is estimated
# Loops that may be singular at once. Hardened MuJoCo keeps 3e-8 to 7e-7 of the length in chains of 2 to 14 four-bars,
# and 7e-6 to 0.05 in longer ones, where its solver's rounding decides (docs/free-motion.md, "Long chains").
MOST_CROSSING = 10
STANDING = 1e-6  # of the fastest turning body
COURSES_KEPT = 4  # by a process that runs one engine and preset after the other


@dataclass(frozen=True)
class ExactCourse:
    """A scene's exact motion from its start, and what is to be run against it.

    Attributes:
        mechanism: with the loads that act.
        grid: instants of `motion`, and the engines' step.
        lengths: L of each observed point [m].
        pace: of the motion.
        unresolved: reason why nothing is judged unless a tolerance is given; empty where the step is short enough.
    """

    mechanism: Mechanism
    grid: Grid
    motion: FreeMotion
    lengths: Mapping[str, float]
    pace: Pace
    unresolved: str = ""


@lru_cache(COURSES_KEPT)
def exact_course(name: str, scene: Scene, plan: MotionPlan) -> ExactCourse:
    """The exact motion of a scene; kept for the next that asks.

    Args:
        plan: without tolerances.

    Raises:
        InvalidInput: the start contradicts the joints or is a rest that nothing ends, a force is not finite, what moves
            has no inertia, the follower would fly, or there would be too many steps.
    """
    mechanism = plan.mechanism(scene.kinematics.mechanism, name)
    grid = instants(plan, duration(name, scene, plan))
    dynamics = ForwardDynamics(mechanism)
    motion = dynamics.motion(grid.times, rates=scene.start_rates)
    _check_contact(name, mechanism, motion)
    pace = _pace(mechanism, motion)
    if fastest_turn(mechanism, motion) == math.inf:
        raise InvalidInput(f"{name}: it stays at rest: there is no motion to compare; start it in motion")
    steps = chosen(plan, grid, mechanism, pace)
    unresolved = _unresolved(mechanism, motion, dynamics.reduced, steps.step)
    return ExactCourse(mechanism, steps, motion, scene.lengths, pace, unresolved)


@lru_cache(COURSES_KEPT)
def duration(name: str, scene: Scene, plan: MotionPlan) -> float:
    """Duration asked for [s]; else ten seconds, but no more than fifty of the fastest turns of the first second."""
    if plan.seconds is not None:
        return plan.seconds
    mechanism = plan.mechanism(scene.kinematics.mechanism, name)
    times = instants(replace(plan, step=None), PROBE).times
    return min(
        SECONDS, TURNS * _pace(mechanism, ForwardDynamics(mechanism).motion(times, rates=scene.start_rates)).revolution
    )


def _pace(mechanism: Mechanism, motion: FreeMotion) -> Pace:
    """Pace of a motion; a pulse of a load is held to be a turn, too."""
    return Pace(min(fastest_turn(mechanism, motion), shortest_pulse(mechanism, motion)), bool(motion.crossings))


def _unresolved(mechanism: Mechanism, motion: FreeMotion, reduced: ReducedDynamics, step: float) -> str:
    """The reason why no law of errors comes of the motion alone: a step [s] too long, or rounding that grows."""
    loops = len(mechanism.joints) - len(mechanism.bodies)
    if motion.crossings and loops > MOST_CROSSING:
        return (
            f"where branches cross, {loops} loops are singular at once, and what an engine rounds grows there: with "
            f"more than {MOST_CROSSING} errors are measured, and judged by --tolerance alone"
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
    if not motion.crossings:
        return False
    turning = 3 * mechanism.body_index[mechanism.crank] + 2
    crossings = reduced.crossings(float(motion.along.min()), float(motion.along.max()))
    tangents = np.abs([reduced.poses_with_derivatives(along)[1] for along in crossings])[:, 2::3]
    return bool((tangents[:, turning // 3] < STANDING * tangents.max(axis=1)).any())


def _check_contact(name: str, mechanism: Mechanism, motion: FreeMotion) -> None:
    """Refuse a motion in which a cam would have to pull: the exact motion does not know flight."""
    if not mechanism.cam_contacts:
        return
    forces = joint_forces_of_motion(
        Kinematics(mechanism), motion.poses, motion.rates, motion.accelerations, motion.times
    )
    for joint in mechanism.cam_contacts:
        push = forces.components[joint.name]["contact"]
        pulls = push < -NO_PULL * np.abs(push).max()
        if pulls.any():
            raise InvalidInput(
                f"{name}: the follower leaves the cam at t = {motion.times[int(np.argmax(pulls))]:.4g} s, and the "
                "exact motion keeps it there: start it slower, or press it on by a spring or a force"
            )


def places(mechanism: Mechanism, poses: Array) -> dict[str, Array]:
    """Positions (T, 2) [m] of the observed points in poses (T, 3 n)."""
    bodies = pose_jets(mechanism, [poses])
    return {
        point.name: np.column_stack([np.asarray(jet.coefficients[0]) for jet in bodies[point.body].point(point.point)])
        for point in mechanism.observed
    }


def shortest_pulse(mechanism: Mechanism, motion: FreeMotion) -> float:
    """Duration of the shortest pulse of a load [s], at the highest speed at which it acts; inf where none does."""
    times = [math.inf]
    for _, law, (value, rate, _) in _along(mechanism, motion):
        if isinstance(law, TimePulse) and law.start < motion.times[-1]:
            times.append(law.stop - law.start)
        if isinstance(law, StrokePulse):
            acts = (law.start < value) & (value < law.stop) & (rate * law.sense > 0.0)
            speed = float(np.abs(rate[acts]).max(initial=0.0))
            times.append((law.stop - law.start) / speed if speed > 0.0 else math.inf)
    return min(times)


def quickest_reversal(mechanism: Mechanism, motion: FreeMotion) -> tuple[str, float]:
    """Name of the friction whose sign changes in the shortest time, and that time [s]; inf where none changes.

    Friction comes up below its creep, which a rate passes in the creep over its acceleration.
    """
    found = [("", math.inf)]
    for name, law, (_, rate, acceleration) in _along(mechanism, motion):
        if isinstance(law, Friction):
            turns = np.flatnonzero(rate[:-1] * rate[1:] < 0.0)
            steepest = float(np.abs(acceleration[np.concatenate([turns, turns + 1])]).max(initial=0.0))
            found.append((name, law.creep / steepest if steepest > 0.0 else math.inf))
    return min(found, key=lambda one: one[1])


def _along(mechanism: Mechanism, motion: FreeMotion) -> Iterator[tuple[str, LoadLaw, tuple[Array, Array, Array]]]:
    """Name and law of each load, and its coordinate with its first and second derivative by time, each (T,)."""
    bodies = pose_jets(mechanism, [motion.poses, motion.rates, 0.5 * motion.accelerations])
    for load in mechanism.loads:
        value, rate, half = (np.asarray(c) for c in coordinate_jet(load.along, bodies).coefficients)
        yield load.name, load.law, (value, rate, 2.0 * half)
