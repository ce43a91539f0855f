"""Dynamic mode: pymunk steps, conrod records. Nothing is written after the start but the crank's own angle."""

from __future__ import annotations

import numpy as np
import pymunk

from conrod.engines.engine import Machine
from conrod.engines.left_out_rod import ModelForm
from conrod.engines.pymunk.instants import Staggered, staggered
from conrod.engines.pymunk.points import point_tracks
from conrod.engines.pymunk.settings import PymunkSettings
from conrod.engines.pymunk.space import build
from conrod.engines.pymunk.stepping import advance
from conrod.joint_equations import pose_jets
from conrod.mechanism import Mechanism
from conrod.motion import Array
from conrod.outcome import judge
from conrod.trajectory import BodyStates, BodyTracks, PointTracks, Track, Trajectory


def run(machine: Machine, settings: PymunkSettings, revolutions: float, start_angle: float) -> Trajectory:
    """One run at constant crank speed, sampled at every step."""
    made = build(machine, settings)
    poses, slopes = machine.kinematics.derivatives(np.array([start_angle]), 1)
    made.place(poses[0], slopes[0] * machine.speed)
    steps = round(settings.steps_per_revolution * revolutions)
    times = np.asarray(start_angle / machine.speed + settings.timestep * np.arange(steps + 1), dtype=float)
    # The engine sums speed x step; counted steps keep the crank where it belongs. At every step, because the drift of a
    # whole turn, put right at once, would be seen in the acceleration.
    driver = made.mechanism.driver
    centres, rates = advance(made, settings, driver.start + driver.sense * machine.speed * times)
    at = staggered(made.mechanism, settings.timestep, times, centres, rates)
    bodies = body_tracks(made.form, at, centres, rates)
    points = point_tracks(made.mechanism, at, centres, rates) | unseen_points(made.form, at, bodies)
    verdict = judge(machine.kinematics, bodies, machine.speed)
    return Trajectory(
        engine="pymunk",
        engine_version=pymunk.version,
        settings=settings,
        speed=machine.speed,
        revolutions=revolutions,
        outcome=verdict.outcome,
        reason=verdict.reason,
        points=points,
        bodies=bodies,
    )


def body_tracks(form: ModelForm, at: Staggered, centres: Array, rates: Array) -> BodyTracks:
    """States of all links at the instants that positions, velocities and accelerations belong to."""
    here = _states(form, centres, rates)
    middle = _states(form, centres[1:] + at.ahead * rates[1:], rates[1:])
    between = _states(form, centres[3:] + at.back * rates[2:-1], 0.5 * (rates[3:] + rates[2:-1]))
    rest = np.zeros_like
    return BodyTracks(
        BodyStates(at.position, *here, rest(here[0])),
        BodyStates(at.velocity, *middle, rest(middle[0])),
        BodyStates(at.acceleration, *between, np.diff(middle[1], axis=0)[1:] / at.step),
    )


def unseen_points(form: ModelForm, at: Staggered, bodies: BodyTracks) -> dict[str, PointTracks]:
    """Tracks of the points observed on links that the engine does not have."""
    unseen = [point for point in form.whole.observed if point not in form.mechanism.observed]
    if not unseen:
        return {}
    positions, _ = observed_points(form.whole, bodies.position.poses, bodies.position.rates)
    _, velocities = observed_points(form.whole, bodies.velocity.poses, bodies.velocity.rates)
    return {
        point.name: PointTracks(
            Track(at.position, positions[point.name]),
            Track(at.velocity, velocities[point.name]),
            Track(at.acceleration, np.diff(velocities[point.name], axis=0)[1:] / at.step),
        )
        for point in unseen
    }


def _states(form: ModelForm, centres: Array, rates: Array) -> tuple[Array, Array]:
    """Poses and rates of the frames of all links from those of the engine's centres of gravity."""
    poses, speeds = form.completed(body_states(form.mechanism, centres, rates))
    return poses, speeds


def body_states(mechanism: Mechanism, centres: Array, rates: Array) -> tuple[Array, Array]:
    """Poses and rates of the body frames from those of the centres of gravity."""
    poses, speeds = centres.copy(), rates.copy()
    for i, body in enumerate(mechanism.bodies):
        cx, cy = body.centre_of_gravity
        if cx == cy == 0.0:
            continue
        c, s, spin = np.cos(centres[:, 3 * i + 2]), np.sin(centres[:, 3 * i + 2]), rates[:, 3 * i + 2]
        rx, ry = c * cx - s * cy, s * cx + c * cy
        poses[:, 3 * i] -= rx
        poses[:, 3 * i + 1] -= ry
        speeds[:, 3 * i] += spin * ry
        speeds[:, 3 * i + 1] -= spin * rx
    return poses, speeds


def observed_points(mechanism: Mechanism, poses: Array, rates: Array) -> tuple[dict[str, Array], dict[str, Array]]:
    """Position and velocity of the observed points, (T, 2) each."""
    bodies = pose_jets(mechanism, [poses, rates])
    positions, velocities = {}, {}
    for observed in mechanism.observed:
        x, y = bodies[observed.body].point(observed.point)
        positions[observed.name] = np.column_stack([x.coefficients[0], y.coefficients[0]])
        velocities[observed.name] = np.column_stack([x.coefficients[1], y.coefficients[1]])
    return positions, velocities
