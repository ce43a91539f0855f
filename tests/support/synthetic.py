"""Trajectories made from the exact motion, in the shape that engines deliver, to plant defects in."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache
from typing import Any, TypeVar

import numpy as np

from conrod import Outcome, Trajectory
from conrod.comparison.trajectory import BodyStates, BodyTracks, PointTracks, Track
from conrod.exact.kinematics import Kinematics
from conrod.exact.motion import QUANTITIES, Array, Instants, Motion, motion_in_time
from conrod.execution.run import RunResult
from conrod.mechanism.mechanism import Joint, Revolute
from conrod.scenes import Saw, Scene, ShearPress

AnyResult = TypeVar("AnyResult", bound=RunResult)

STEPS = 500
# Where in a step the samples of positions, velocities and accelerations lie, in steps: as MuJoCo gives all three, and
# with velocities that belong to the middle of a step, as pymunk's.
TOGETHER, STAGGERED = (0.0, 0.0, 0.0), (0.0, 0.5, 0.0)


def instants(speed: float, revolutions: float, stamp: float = 0.0, drive: float = 0.0) -> Instants:
    """Instants at counted steps; `drive` is the relative excess of the rate over the nominal one."""
    step = 2.0 * math.pi / abs(speed) / STEPS
    times = step * (np.arange(round(STEPS * revolutions) + 1) + stamp)
    rate = speed * (1.0 + drive)
    return Instants(times, rate * times, np.full_like(times, rate), np.zeros_like(times))


def synthetic_trajectory(
    scene: Scene,
    kinematics: Kinematics | None = None,
    *,
    stamps: tuple[float, float, float] = TOGETHER,
    drive: float = 0.0,
) -> Trajectory:
    """Two turns of a scene that follow a solver exactly: the scene's, or one with a planted defect."""
    samples = [_sample(kinematics or scene.kinematics, scene.speed, stamp, drive) for stamp in stamps]

    def tracks(point: str) -> PointTracks:
        at = zip(("position", "velocity", "acceleration"), samples, strict=True)
        return PointTracks(*(Track(own.instants, getattr(motion.point(point), name)) for name, (own, motion) in at))

    return Trajectory(
        engine="synthetic",
        engine_version="0",
        settings=None,
        speed=scene.speed,
        revolutions=2.0,
        outcome=Outcome.COMPLETED,
        reason="",
        points={point: tracks(point) for point in scene.lengths},
        bodies=BodyTracks(*(states for states, _ in samples)),
    )


@cache
def _sample(solver: Kinematics, speed: float, stamp: float, drive: float) -> tuple[BodyStates, Motion]:
    """Exact states of the bodies and motion of the points, from one and the same solution."""
    at = instants(speed, 2.0, stamp, drive)
    derivatives = solver.derivatives(at.angle)
    points = {
        name: ([d[:, 0] for d in planar], [d[:, 1] for d in planar])
        for name, planar in solver.point_derivatives(derivatives).items()
    }
    return body_states(solver, at), motion_in_time(lambda _: points, at.angle, at.rate, 0.0, len(at.angle))


def body_states(solver: Kinematics, at: Instants) -> BodyStates:
    """Exact states of the bodies at constant speed."""
    poses, slopes, bends = solver.derivatives(at.angle, 2)
    return BodyStates(at, poses, slopes * at.rate[:, None], bends * at.rate[:, None] ** 2)


def completed_result(error: float, kind: type[AnyResult] = RunResult, **more: Any) -> AnyResult:  # type: ignore[assignment]
    """A result of a run with an error in every quantity."""
    sizes = dict.fromkeys(("max", "rms", "final"), error)
    return kind("completed", errors={"C": dict.fromkeys(QUANTITIES, sizes)}, **more)


def with_values(trajectory: Trajectory, quantity: str, change: Any) -> Trajectory:
    """The trajectory with `change(values)` in place of the values of a quantity, for every point."""
    points = {}
    for name, tracks in trajectory.points.items():
        track = getattr(tracks, quantity)
        points[name] = replace(tracks, **{quantity: replace(track, values=change(track.values))})
    return replace(trajectory, points=points)


# -- planted defects of the mechanism --------------------------------------------------------------------------------

# Solvers of the defective mechanisms are shared between tests: to walk one around its turn takes most of a test's time.


@cache
def longer_rod(scene: Scene, factor: float = 1.0001) -> Kinematics:
    """The generic solver of the scene with the slider pin farther out on the rod, by 0.01% if nothing is said."""

    def longer(joint: Joint) -> Joint:
        if isinstance(joint, Revolute) and joint.name == "slider-pin":
            return replace(joint, point_a=(joint.point_a[0] * factor, joint.point_a[1]))
        return joint

    mechanism = scene.mechanism()
    return Kinematics(replace(mechanism, joints=tuple(map(longer, mechanism.joints))))


@cache
def turned_crank(scene: Scene) -> Kinematics:
    """The generic solver of the scene with its crank (its cam) turned on its shaft by 0.01 degrees."""
    mechanism = scene.mechanism()
    driver = replace(mechanism.driver, start=mechanism.driver.start + math.radians(0.01))
    return Kinematics(replace(mechanism, driver=driver))


@cache
def other_branch(scene: ShearPress | Saw) -> Kinematics:
    """The generic solver on another assembly branch: the slider on the far side of the shaft."""
    mechanism = scene.mechanism()
    if isinstance(scene, ShearPress):
        poses = {"rod": (0.0, scene.crank, -math.pi / 2), "slider": (0.0, scene.crank - scene.rod, 0.0)}
    else:
        reach = math.sqrt(scene.rod**2 - scene.offset**2)
        pin_x = scene.shaft[0] + scene.crank
        poses = {"rod": (pin_x, -scene.offset, math.atan2(scene.offset, reach)), "slider": (pin_x + reach, 0.0, 0.0)}
    return Kinematics(replace(mechanism, poses=mechanism.poses | poses))


def rod_reach(scene: ShearPress | Saw, angle: Array) -> Array:
    """The rod's extent along the slide [m]: sqrt(l^2 - u^2)."""
    across = scene.crank * np.sin(angle) - (0.0 if isinstance(scene, ShearPress) else scene.offset)
    return np.asarray(np.sqrt(scene.rod**2 - across**2))
