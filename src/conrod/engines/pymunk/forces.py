"""Forces in a machine as pymunk computes them, from the impulses that change the velocities in a step.

Chipmunk moves the bodies first, and then gives impulses p to the joints until the velocities fit the joints at the new
positions. So M (v_n - v_(n-1)) = h Q + J' p holds to rounding, however far the iteration has come, with the joints'
Jacobian J at the positions of sample n. The engine reports only the size of a joint's impulse (`constraint.impulse`);
its components follow from this equation, which has one solution in a determinate mechanism. p / h is the mean force of
the step, and belongs to the instant of the acceleration (v_n - v_(n-1)) / h: t_n for joints, t_n - h / 2 for contact
(see `SampleInstants`).

The driven crank is kinematic: nothing acts on it in the engine, and its equations are those of a crank with its mass
and the same rotation.

Contact pushes and cannot pull. Where the cam's curve falls away, a follower that continues straight uses up the overlap
that it may keep, then is free for a step and is caught by the next one with twice the force, at any step size: the
force of single steps scatters by 5.3 % rms of the peak. A catch makes up for the missing force, so the mean of several
steps is right: 1.4 % for 4, 0.34 % for 16. With contact, all forces are such means. (The arbiter's own `total_impulse`
agrees, except where contact starts again, where it counts the last contact's impulse a second time.)
"""

from __future__ import annotations

import numpy as np

from conrod.comparison.outcome import judge_outcome
from conrod.comparison.trajectory import Outcome
from conrod.engines.capabilities import ExpectedForces
from conrod.engines.engine import Machine
from conrod.engines.numerics import centres_from_frames, frames_from_centres
from conrod.engines.pymunk import ITERATION_ERROR_SHARE, PymunkSettings
from conrod.engines.pymunk.dynamics import SampleInstants, body_tracks, build_at_angle, crank_angles, sample_instants
from conrod.engines.pymunk.error_bound import scheme_states
from conrod.engines.pymunk.loads import driven_loads
from conrod.engines.pymunk.space import refusal, with_crank_centred
from conrod.engines.pymunk.stepping import advance
from conrod.engines.tracks import ForceTracks, unreported_forces
from conrod.exact.dynamics import load_forces
from conrod.exact.dynamics.inverse import component_names
from conrod.exact.motion import Array, Instants, rotate_planar
from conrod.mechanism.mechanism import Mechanism

FIRST_SAMPLE = 3  # index of the first sample whose acceleration is reported
SAMPLES_PER_MEAN = 16  # over which forces are averaged on machines with contact
GEAR_REASON = "pymunk's GearJoint turns two bodies against each other by a pure moment; no force acts where they roll"

EDITED_REASON = "the model is edited: forces are computed of links and joints as the machine has them"


def forces(machine: Machine, settings: PymunkSettings, revolutions: float, start_angle: float = 0.0) -> ForceTracks:
    """Drive torque and reactions of a run at constant crank speed, from the third step on."""
    mechanism = machine.kinematics.mechanism
    reason = refusal(machine, settings) or (EDITED_REASON if settings.dressing else None)
    if reason:
        return unreported_forces(mechanism, reason)
    made = build_at_angle(machine, settings, start_angle)
    steps, h = round(settings.steps_per_revolution * revolutions), settings.timestep
    times = np.asarray(start_angle / machine.speed + h * np.arange(steps + 1), dtype=float)
    begins, pushes, given = times[:-1], driven_loads(made, settings), np.zeros((steps + 1, 3 * len(made.bodies)))
    turns = crank_angles(machine, begins)
    if pushes is None:
        centres, rates = advance(made, h, turns, rounded=settings.rounded_state)
    else:
        pushed: list[list[float]] = []
        loading = (lambda t: pushed.append(pushes.apply_for_step(t)), begins)
        centres, rates = advance(made, h, turns, loading=loading, rounded=settings.rounded_state)
        given[1:] = pushed
    with np.errstate(all="ignore"):
        at = sample_instants(made.mechanism, h, times, centres, rates)
        verdict = judge_outcome(machine.kinematics, body_tracks(made.mechanism, at, centres, rates), machine.speed)
    if verdict.outcome is not Outcome.COMPLETED:
        return unreported_forces(mechanism, verdict)
    poses, _ = frames_from_centres(made.mechanism, centres, rates)
    run = centres[FIRST_SAMPLE:], np.diff(rates, axis=0)[FIRST_SAMPLE - 1 :], given[FIRST_SAMPLE:]
    right = _forces_on_bodies(mechanism, settings, at, run)
    return _force_tracks(machine, at.acceleration, poses[FIRST_SAMPLE:], right)


FORCE_LAW = "forces of the scheme's own steps: positions lag by h^2 x''/2, accelerations by 5/12 h^2 x''''"


def expected_forces(
    machine: Machine, settings: PymunkSettings, revolutions: float, start_angle: float = 0.0
) -> ExpectedForces | None:
    """Forces that the scheme's own steps take, at the instants that `forces` reports; None without a law.

    The forces of a step are M (v_n - v_(n-1)) / h - Q at x_n, for states that lag as in `scheme_states`; loads are
    those at x_n and the rate extrapolated to t_n, v_(n-1) + (v_(n-1) - v_(n-2)) / 2.
    """
    mechanism = machine.kinematics.mechanism
    if settings.error_bias > 0.0 or mechanism.cam_contacts or settings.dressing or refusal(machine, settings):
        return None
    centred, h = with_crank_centred(mechanism), settings.timestep
    steps = round(settings.steps_per_revolution * revolutions)
    poses, speeds = scheme_states(machine, h, start_angle, steps)
    centres, rates = centres_from_frames(centred, poses, speeds)
    times = np.asarray(start_angle / machine.speed + h * np.arange(steps + 1), dtype=float)
    at = sample_instants(centred, h, times, centres, rates)
    run = centres[FIRST_SAMPLE:], np.diff(rates, axis=0)[FIRST_SAMPLE - 1 :], np.zeros_like(centres[FIRST_SAMPLE:])
    right = _forces_on_bodies(mechanism, settings, at, run)
    if mechanism.loads:
        ahead = 1.5 * rates[FIRST_SAMPLE - 1 : -1] - 0.5 * rates[FIRST_SAMPLE - 2 : -2]
        right -= load_forces(
            mechanism, *frames_from_centres(centred, centres[FIRST_SAMPLE:], ahead), times[FIRST_SAMPLE:]
        )
    return ExpectedForces(
        _force_tracks(machine, at.acceleration, poses[FIRST_SAMPLE:], right), ITERATION_ERROR_SHARE, FORCE_LAW
    )


def _forces_on_bodies(
    mechanism: Mechanism, settings: PymunkSettings, at: SampleInstants, run: tuple[Array, Array, Array]
) -> Array:
    """Forces of joints and drive on every body, M dv / h - Q, about the origin of its frame (T, 3 n).

    Args:
        run: positions and angles of the centres of gravity, changes of their rates in the step, generalised forces of
            loads; all (T, 3 n).
    """
    centres, gains, given = run
    gravity = mechanism.gravity if settings.gravity else (0.0, 0.0)
    result = np.zeros_like(centres)
    for i, body in enumerate(mechanism.bodies):
        x, y, turn = 3 * i, 3 * i + 1, 3 * i + 2
        arm = rotate_planar(body.centre_of_gravity, centres[:, turn])
        if body.name == mechanism.crank:
            # Its speed is constant, and its centre of gravity moves on a circle about the shaft.
            shaft = rotate_planar(mechanism.driven_joint.point_b, centres[:, turn])
            ax, ay = (-(at.acceleration.rate**2) * (r - s) for r, s in zip(arm, shaft, strict=True))
            spun = np.zeros_like(ax)
        else:
            shaft = arm
            ax, ay, spun = (gains[:, column] / at.step for column in (x, y, turn))
        push = mechanism.constant_force_on(body.name)
        fx, fy = body.mass * (ax - gravity[0]) - push[0], body.mass * (ay - gravity[1]) - push[1]
        # Loads act about the engine's centre of the body, which for the crank is the shaft.
        result[:, x], result[:, y] = fx - given[:, x], fy - given[:, y]
        moment = arm[0] * fy - arm[1] * fx - (shaft[0] * given[:, y] - shaft[1] * given[:, x])
        result[:, turn] = body.inertia * spun + moment - given[:, turn]
    return result


def _force_tracks(machine: Machine, instants: Instants, poses: Array, right: Array) -> ForceTracks:
    """Solve J' f = right for the joints' force components, and arrange them by joint."""
    kinematics = machine.kinematics
    mechanism = kinematics.mechanism
    transposed = np.swapaxes(kinematics.jacobian(poses), 1, 2)
    carried = np.asarray(np.linalg.solve(transposed, right[:, :, None])[:, :, 0], dtype=float)
    if mechanism.cam_contacts:
        carried = block_means(carried)
        instants = Instants(
            *(block_means(v) for v in (instants.times, instants.angle, instants.rate, instants.acceleration))
        )
    unreported = {joint.name: GEAR_REASON for joint in mechanism.joints} if mechanism.meshes else {}
    joints, row = {}, 0
    for joint in mechanism.joints:
        names = component_names(joint)
        if joint.name not in unreported:
            joints[joint.name] = {name: carried[:, row + k] for k, name in enumerate(names)}
        row += len(names)
    return ForceTracks(instants, mechanism.driver.sense * carried[:, row], joints, unreported)


def block_means(values: Array) -> Array:
    """Means of each block of `SAMPLES_PER_MEAN` samples (T, ...); samples after the last whole block are dropped."""
    count = len(values) // SAMPLES_PER_MEAN
    return np.asarray(
        values[: count * SAMPLES_PER_MEAN].reshape(count, SAMPLES_PER_MEAN, *values.shape[1:]).mean(axis=1), dtype=float
    )
