"""Dynamic mode: pymunk steps, conrod records. Nothing is written after the start but the crank's own angle."""

from __future__ import annotations

import numpy as np
import pymunk

from conrod.engines.engine import Machine
from conrod.engines.pymunk.settings import PymunkSettings
from conrod.engines.pymunk.space import build
from conrod.engines.pymunk.stepping import advance
from conrod.joint_equations import pose_jets
from conrod.mechanism import Mechanism
from conrod.motion import Array
from conrod.outcome import judge
from conrod.trajectory import BodyStates, BodyTracks, Instants, PointTracks, Track, Trajectory


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
    bodies, points = _tracks(made.mechanism, settings.timestep, times, centres, rates)
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


def _tracks(
    mechanism: Mechanism, h: float, times: Array, centres: Array, rates: Array
) -> tuple[BodyTracks, dict[str, PointTracks]]:
    """States at the instants they belong to.

    A step moves positions first, x_(n+1) = x_n + h v_n, and then makes v_(n+1) fit the joints there. So v_n is the
    difference of two positions and belongs to the middle of the step that follows it, t_n + h / 2; v_0, given at
    t = 0, is left out. (A contact is corrected by velocities of its own, apart from v_n, which then fits the instant
    t_n itself.) Acceleration is the difference of two velocities and belongs to the instant between. It
    begins at the third step: positions run behind the exact ones by a lag that is complete only after the second step.
    """
    half = 0.0 if mechanism.cam_contacts else 0.5 * h
    middle = body_states(mechanism, centres[1:] + half * rates[1:], rates[1:])
    middle_crank = _crank(mechanism, times[1:] + half, *middle)
    here = body_states(mechanism, centres, rates)
    here_crank = _crank(mechanism, times, *here)
    accelerations = np.diff(middle[1], axis=0)[1:] / h
    back = half - 0.5 * h
    between = body_states(mechanism, centres[3:] + back * rates[2:-1], 0.5 * (rates[3:] + rates[2:-1]))
    between_crank = _crank(mechanism, times[3:] + back, *between, accelerations)
    rest = np.zeros_like
    bodies = BodyTracks(
        BodyStates(here_crank, *here, rest(here[0])),
        BodyStates(middle_crank, *middle, rest(middle[0])),
        BodyStates(between_crank, *between, accelerations),
    )
    positions, _ = observed_points(mechanism, *here)
    _, velocities = observed_points(mechanism, *middle)
    points = {
        name: PointTracks(
            Track(here_crank, positions[name]),
            Track(middle_crank, velocities[name]),
            Track(between_crank, np.diff(velocities[name], axis=0)[1:] / h),
        )
        for name in positions
    }
    return bodies, points


def body_states(mechanism: Mechanism, centres: Array, rates: Array) -> tuple[Array, Array]:
    """Poses and rates of the body frames from those of the centres of gravity."""
    poses, speeds = centres.copy(), rates.copy()
    for i, body in enumerate(mechanism.bodies):
        cx, cy = body.centre_of_gravity
        c, s, spin = np.cos(centres[:, 3 * i + 2]), np.sin(centres[:, 3 * i + 2]), rates[:, 3 * i + 2]
        rx, ry = c * cx - s * cy, s * cx + c * cy
        poses[:, 3 * i] -= rx
        poses[:, 3 * i + 1] -= ry
        speeds[:, 3 * i] += spin * ry
        speeds[:, 3 * i + 1] -= spin * rx
    return poses, speeds


def _crank(
    mechanism: Mechanism, times: Array, poses: Array, rates: Array, accelerations: Array | None = None
) -> Instants:
    i = 3 * mechanism.body_index[mechanism.crank] + 2
    driver = mechanism.driver
    angle, rate = driver.sense * (poses[:, i] - driver.start), driver.sense * rates[:, i]
    acceleration = np.zeros_like(rate) if accelerations is None else driver.sense * accelerations[:, i]
    return Instants(times, angle, rate, acceleration)


def observed_points(mechanism: Mechanism, poses: Array, rates: Array) -> tuple[dict[str, Array], dict[str, Array]]:
    """Position and velocity of the observed points, (T, 2) each."""
    bodies = pose_jets(mechanism, [poses, rates])
    positions, velocities = {}, {}
    for observed in mechanism.observed:
        x, y = bodies[observed.body].point(observed.point)
        positions[observed.name] = np.column_stack([x.coefficients[0], y.coefficients[0]])
        velocities[observed.name] = np.column_stack([x.coefficients[1], y.coefficients[1]])
    return positions, velocities
