"""Trajectories made from the exact motion, in the shape that engines deliver, to plant defects in."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import numpy as np

from conrod import Outcome, Trajectory
from conrod.exact.kinematics import Kinematics
from conrod.exact.motion import Array, Motion, motion_in_time
from conrod.mechanism.mechanism import Mechanism, Pose, Revolute
from conrod.runs.trajectory import BodyStates, BodyTracks, Instants, PointTracks, Track
from conrod.scenes import Saw, Scene, ShearPress

STEPS = 500


@dataclass(frozen=True)
class NoSettings:
    """Settings of no engine."""

    engine: str = "synthetic"
    preset: str = "custom"
    steps_per_revolution: int = STEPS
    timestep: float = 0.0

    def as_dict(self) -> dict[str, Any]:
        return {}


@dataclass(frozen=True)
class Stamps:
    """Where in a step the samples of each quantity lie, in steps."""

    position: float = 0.0
    velocity: float = 0.0
    acceleration: float = 0.0


# MuJoCo gives all three quantities at one instant; pymunk's velocities belong to the middle of a step.
TOGETHER, STAGGERED = Stamps(), Stamps(velocity=0.5)


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
    revolutions: float = 2.0,
    stamps: Stamps = TOGETHER,
    drive: float = 0.0,
    outcome: Outcome = Outcome.COMPLETED,
) -> Trajectory:
    """A run of the scene in which everything follows a solver exactly: its own, or that of a planted defect."""
    solver = kinematics or scene.kinematics
    samples = [_sample(solver, scene.speed, revolutions, stamp, drive) for stamp in vars(stamps).values()]
    return Trajectory(
        engine="synthetic",
        engine_version="0",
        settings=NoSettings(),
        speed=scene.speed,
        revolutions=revolutions,
        outcome=outcome,
        reason="" if outcome is Outcome.COMPLETED else "planted",
        points={
            name: PointTracks(
                *(
                    Track(states.instants, getattr(motion.point(name), quantity))
                    for quantity, (states, motion) in zip(vars(stamps), samples, strict=True)
                )
            )
            for name in scene.lengths
        },
        bodies=BodyTracks(*(states for states, _ in samples)),
    )


@cache
def _sample(
    solver: Kinematics, speed: float, revolutions: float, stamp: float, drive: float
) -> tuple[BodyStates, Motion]:
    """Exact states of the bodies and motion of the points, from one and the same solution."""
    at = instants(speed, revolutions, stamp, drive)
    derivatives = solver.derivatives(at.angle)
    states = _states(at, derivatives)
    points = {
        name: ([d[:, 0] for d in planar], [d[:, 1] for d in planar])
        for name, planar in solver.point_derivatives(derivatives).items()
    }
    return states, motion_in_time(lambda _: points, at.angle, at.rate, 0.0, len(at.angle))


def body_states(solver: Kinematics, at: Instants) -> BodyStates:
    """Exact states of the bodies at constant speed."""
    return _states(at, solver.derivatives(at.angle, 2))


def _states(at: Instants, derivatives: list[Array]) -> BodyStates:
    rate = at.rate[:, None]
    return BodyStates(at, derivatives[0], derivatives[1] * rate, derivatives[2] * rate**2)


def with_values(trajectory: Trajectory, quantity: str, change: Any) -> Trajectory:
    """The trajectory with `change(values)` in place of the values of a quantity, for every point."""
    points = {}
    for name, tracks in trajectory.points.items():
        track = getattr(tracks, quantity)
        points[name] = replace(tracks, **{quantity: replace(track, values=change(track.values))})
    return replace(trajectory, points=points)


# -- planted defects of the mechanism --------------------------------------------------------------------------------


def with_longer_rod(mechanism: Mechanism, factor: float = 1.0001) -> Mechanism:
    """The same mechanism with the slider pin farther out on the rod."""

    def longer(joint: Any) -> Any:
        if isinstance(joint, Revolute) and joint.name == "slider-pin":
            return replace(joint, point_a=(joint.point_a[0] * factor, joint.point_a[1]))
        return joint

    return replace(mechanism, joints=tuple(longer(joint) for joint in mechanism.joints))


def with_turned_crank(mechanism: Mechanism, angle: float = math.radians(0.01)) -> Mechanism:
    """The same mechanism with its crank (its cam) turned on its shaft by an angle [rad]."""
    return replace(mechanism, driver=replace(mechanism.driver, start=mechanism.driver.start + angle))


def on_other_branch(scene: ShearPress | Saw) -> Mechanism:
    """The same mechanism put together the other way: the slider on the far side of the shaft."""
    mechanism = scene.mechanism()
    if isinstance(scene, ShearPress):
        poses: dict[str, Pose] = {
            "rod": (0.0, scene.crank, -math.pi / 2),
            "slider": (0.0, scene.crank - scene.rod, 0.0),
        }
    else:
        reach = math.sqrt(scene.rod**2 - scene.offset**2)
        pin_x = scene.shaft[0] + scene.crank
        poses = {"rod": (pin_x, -scene.offset, math.atan2(scene.offset, reach)), "slider": (pin_x + reach, 0.0, 0.0)}
    return replace(mechanism, poses={**mechanism.poses, **poses})


def rod_reach(scene: ShearPress | Saw, angle: Array) -> Array:
    """The rod's extent along the slide [m]: sqrt(l^2 - u^2)."""
    if isinstance(scene, ShearPress):
        across = scene.crank * np.sin(angle)
    else:
        across = scene.crank * np.sin(angle) - scene.offset
    return np.asarray(np.sqrt(scene.rod**2 - across**2))


# Solvers of the defective mechanisms, shared between tests: to walk one around its turn takes most of a test's time.


@cache
def longer_rod(scene: Scene) -> Kinematics:
    """The generic solver of the scene with its rod 0.01% too long."""
    return Kinematics(with_longer_rod(scene.mechanism()))


@cache
def turned_crank(scene: Scene) -> Kinematics:
    """The generic solver of the scene with its crank or cam turned by 0.01 degrees."""
    return Kinematics(with_turned_crank(scene.mechanism()))


@cache
def other_branch(scene: ShearPress | Saw) -> Kinematics:
    """The generic solver of the scene put together on its other branch."""
    return Kinematics(on_other_branch(scene))
