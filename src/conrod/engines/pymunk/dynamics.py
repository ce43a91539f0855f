"""Dynamic mode: step pymunk, and record. After the start, only the crank's own angle and loads are written.

`SampleInstants` states the instants that samples belong to. In free motion nothing but the start prescribes velocities,
and one given at t = 0 and used as it is would stay early by half a step: order 1. So bodies are first moved back by
half a step, x_0 - h v_0 / 2, and the first step has half the length: it ends in the given poses, with the velocities of
t = h / 2. Reported rates are means of those before and after. Contact is corrected by separate velocities, and its
velocities belong to t_n as they are.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from conrod.comparison.trajectory import BodyStates, BodyTracks, Piece, PointTracks, Track
from conrod.engines.engine import PIECE_STEPS, Machine
from conrod.engines.numerics import frames_from_centres, shift_to_frames
from conrod.engines.pymunk import PYMUNK_VERSION, PymunkSettings
from conrod.engines.pymunk.distance_rods import add_rod_states
from conrod.engines.pymunk.gears import gears_refusal
from conrod.engines.pymunk.loads import LoadForces, driven_loads
from conrod.engines.pymunk.model_edits import apply_edits
from conrod.engines.pymunk.space import PymunkSpace, build, build_free
from conrod.engines.pymunk.stepping import advance, read_states
from conrod.engines.run import RecordedPiece, record_pieces
from conrod.engines.tracks import FreeRun, Pace
from conrod.errors import InvalidInput
from conrod.exact.motion import Array, Instants, cache_blocks, rotate_planar
from conrod.mechanism.mechanism import Mechanism


@dataclass(frozen=True)
class SampleInstants:
    """Instants of the T samples of a run, separately for positions, velocities and accelerations.

    A step moves positions first, x_(n+1) = x_n + h v_n, and then makes v_(n+1) fit the joints there. So v_n is the
    difference of two positions and belongs to the middle of the step that follows, t_n + h / 2; v_0, given at t = 0, is
    left out. (A contact is corrected by separate velocities, and v_n then fits the instant t_n itself.) Acceleration is
    the difference of two velocities and belongs to the instant between them. It starts at the third step: positions lag
    behind the exact ones, and the lag is complete only after the second step.

    Attributes:
        position: (T,), of all samples.
        velocity: (T - 1,), of the samples from the second on.
        acceleration: (T - 3,), of the samples from the fourth on, each with the one before.
        step: h [s].
        ahead: time from a sample to the instant of its velocity [s].
        back: time from a sample to the instant of its acceleration [s].
    """

    position: Instants
    velocity: Instants
    acceleration: Instants
    step: float
    ahead: float
    back: float


def sample_instants(mechanism: Mechanism, h: float, times: Array, centres: Array, rates: Array) -> SampleInstants:
    """Instants of samples at times (T,) [s] with step h [s], with the crank motion that the engine reached.

    Args:
        centres: positions and angles of the centres of gravity (T, 3 n) [m, m, rad].
        rates: rates of `centres` (T, 3 n), each at the instant of its velocity.
    """
    ahead = velocity_delay(mechanism, h)
    back = ahead - 0.5 * h
    driver, crank = mechanism.driver, 3 * mechanism.body_index[mechanism.crank] + 2
    phi, rate = centres[:, crank].copy(), rates[:, crank].copy()

    def instants_at(times: Array, phi: Array, rate: Array, acceleration: Array | None = None) -> Instants:
        """Instants at times [s] from the crank body's angle phi [rad], rate and acceleration; (T,) each."""
        second = np.zeros_like(rate) if acceleration is None else driver.sense * acceleration
        return Instants(times, driver.sense * (phi - driver.start), driver.sense * rate, second)

    return SampleInstants(
        position=instants_at(times, phi, rate),
        velocity=instants_at(times[1:] + ahead, phi[1:] + ahead * rate[1:], rate[1:]),
        acceleration=instants_at(
            times[3:] + back,
            phi[3:] + back * rate[2:-1],
            0.5 * (rate[3:] + rate[2:-1]),
            (rate[3:] - rate[2:-1]) / h,
        ),
        step=h,
        ahead=ahead,
        back=back,
    )


def velocity_delay(mechanism: Mechanism, h: float) -> float:
    """Time [s] from a sample to the instant of its velocity, with step h [s]; see `SampleInstants`."""
    return 0.0 if mechanism.cam_contacts else 0.5 * h


CHUNK_SAMPLES = 4096


def point_tracks(mechanism: Mechanism, at: SampleInstants, centres: Array, rates: Array) -> dict[str, PointTracks]:
    """Motion of all observed points.

    Args:
        at: instants of the T samples.
        centres: positions and angles of the centres of gravity (T, 3 n) [m, m, rad].
        rates: rates of `centres` (T, 3 n), each at the instant of its velocity.
    """
    tracks = {}
    for observed in mechanism.observed:
        i, centre = 3 * mechanism.body_index[observed.body], mechanism.body(observed.body).centre_of_gravity
        way = (observed.point[0] - centre[0], observed.point[1] - centre[1])
        positions, velocities = np.empty((2, len(centres), 2))
        for rows in cache_blocks(len(centres), CHUNK_SAMPLES):
            positions[rows], velocities[rows] = centres[rows, i : i + 2], rates[rows, i : i + 2]
            if way != (0.0, 0.0):
                turn, spin = centres[rows, i + 2], rates[rows, i + 2]
                positions[rows] += np.column_stack(rotate_planar(way, turn))
                arm_x, arm_y = rotate_planar(way, turn + at.ahead * spin)
                velocities[rows, 0] -= spin * arm_y
                velocities[rows, 1] += spin * arm_x
        tracks[observed.name] = PointTracks(
            Track(at.position, positions),
            Track(at.velocity, velocities[1:]),
            Track(at.acceleration, np.diff(velocities[2:], axis=0) / at.step),
        )
    return tracks


# -- runs at constant speed --------------------------------------------------------------------------------------------


# Samples before a piece of a run, from which its first velocities, accelerations and their instants follow.
PRECEDING_SAMPLES = 3


def run(
    machine: Machine, settings: PymunkSettings, revolutions: float, start_angle: float = 0.0, steps: int = PIECE_STEPS
) -> Iterator[Piece]:
    """Run a machine at constant crank speed, and yield its pieces of `steps` steps."""
    made = build_at_angle(machine, settings, start_angle)
    pushes, known = driven_loads(made, settings), read_states(made)
    # Rotations of rods without a body, at the first of the known samples.
    turns_of_rods = made.rod_rotations(machine.kinematics.poses(np.array([start_angle]))[0]) if made.rods else []

    def record(_: int, times: Array) -> RecordedPiece:
        """Read the samples at times (T,) [s]; the first of these times may have samples already."""
        nonlocal known, turns_of_rods
        # The engine sums speed x step; angles from the step index do not drift. They are written at every step, because
        # the drift of a revolution, corrected at once, would be seen in the acceleration.
        begins = times[len(known[0]) - 1 : -1]
        turns = crank_angles(machine, begins)
        loading = (pushes.apply_for_step, begins) if pushes else None
        found = advance(made, settings.timestep, turns, known, loading, settings.rounded_state)
        known = found[0][-PRECEDING_SAMPLES:], found[1][-PRECEDING_SAMPLES:]
        if made.rods:
            ahead = velocity_delay(made.mechanism, settings.timestep)
            found = add_rod_states(made.whole, made.mechanism, made.rods, found, ahead, turns_of_rods)
            turns_of_rods = made.rod_rotations(found[0][-PRECEDING_SAMPLES:][0])
        at = sample_instants(made.whole, settings.timestep, times, *found)
        return RecordedPiece(body_tracks(made.whole, at, *found), point_tracks(made.whole, at, *found))

    return record_pieces(machine, settings, PYMUNK_VERSION, revolutions, start_angle, steps, record, PRECEDING_SAMPLES)


def crank_angles(machine: Machine, times: Array) -> Array:
    """Angles of the crank body (T,) [rad] at times (T,) [s]."""
    driver = machine.kinematics.mechanism.driver
    return np.asarray(driver.start + driver.sense * machine.speed * times, dtype=float)


def build_at_angle(machine: Machine, settings: PymunkSettings, start_angle: float) -> PymunkSpace:
    """Build the machine's space in the exact state at a crank angle [rad]."""
    made = build(machine, settings)
    apply_edits(made, settings)
    poses, derivative = machine.kinematics.derivatives(np.array([start_angle]), 1)
    made.set_states(poses[0], derivative[0] * machine.speed)
    return made


def body_tracks(mechanism: Mechanism, at: SampleInstants, centres: Array, rates: Array) -> BodyTracks:
    """States of all bodies at the instants of positions, velocities and accelerations, in one pass over the samples."""
    samples, columns = centres.shape
    here, middle, between = (
        [np.empty((max(samples - first, 0), columns)) for _ in ("poses", "rates")] for first in (0, 1, 3)
    )
    changes = np.empty(between[0].shape)
    for rows in cache_blocks(samples, CHUNK_SAMPLES):
        for first, states in ((0, here), (1, middle), (3, between)):
            own = slice(max(rows.start, first), rows.stop)
            poses, speeds = (values[own.start - first : max(own.stop - first, 0)] for values in states)
            if first == 3:
                before = slice(own.start - 1, max(own.stop, own.start) - 1)
                poses[:], speeds[:] = centres[own] + at.back * rates[before], 0.5 * (rates[own] + rates[before])
            else:
                poses[:], speeds[:] = centres[own] + at.ahead * rates[own] if first else centres[own], rates[own]
            shift_to_frames(mechanism, poses, speeds)
        new = slice(max(rows.start - 3, 0), max(rows.stop - 3, 0))
        changes[new] = (middle[1][new.start + 2 : new.stop + 2] - middle[1][new.start + 1 : new.stop + 1]) / at.step
    return BodyTracks(
        # Zeros that take no memory.
        BodyStates(at.position, here[0], here[1], np.broadcast_to(0.0, here[0].shape)),
        BodyStates(at.velocity, middle[0], middle[1], np.broadcast_to(0.0, middle[0].shape)),
        BodyStates(at.acceleration, between[0], between[1], changes),
    )


# -- free and torque-driven motion -------------------------------------------------------------------------------------


def free_run(
    mechanism: Mechanism, preset: str, timestep: float, steps: int, poses: Array, rates: Array, pace: Pace,
    every: int = 1,
) -> FreeRun:  # fmt: skip
    """Simulate `steps` steps from exact poses and rates (3 n,), sampled at each `every` steps; `pace` is unused.

    Raises:
        InvalidInput: there is no such preset, or pymunk cannot have a joint of the mechanism; says why.
    """
    settings = PymunkSettings.for_free_motion(mechanism, preset, timestep)
    if reason := gears_refusal(mechanism):
        raise InvalidInput(f"{mechanism.name}: {reason}")
    made = build_free(mechanism, settings, poses)
    made.set_states(poses, rates)
    h, in_step = settings.timestep, not mechanism.cam_contacts
    pushes = LoadForces(made, h, 0.5 * h if in_step else 0.0) if mechanism.loads else None
    if in_step:
        _half_step(made, h, pushes)
    known = read_states(made)
    places, speeds = ([values] for values in known)
    length = max(1, PIECE_STEPS // every) * every
    for done in range(0, steps, length):
        begins = np.asarray(h * np.arange(done, min(done + length, steps)), dtype=float)
        centres, rates_at = advance(made, h, begins, known, (pushes.apply_for_step, begins) if pushes else None)
        known = centres[-1:], rates_at[-1:]
        # A sample follows step k, counted from 1, if `every` divides k.
        places.append(centres[every::every])
        means = 0.5 * (rates_at[:-1] + rates_at[1:]) if in_step else rates_at[1:]
        speeds.append(means[every - 1 :: every])
    with np.errstate(all="ignore"):
        reported_poses, reported_rates = frames_from_centres(mechanism, np.vstack(places), np.vstack(speeds))
        reported_poses[0], reported_rates[0] = poses, rates
    times = np.asarray(h * (every * np.arange(len(reported_poses))), dtype=float)
    return FreeRun.from_states(mechanism, times, (reported_poses, reported_rates))


def _half_step(made: PymunkSpace, h: float, pushes: LoadForces | None) -> None:
    """Advance the velocities by half a step h / 2 [s], and keep the bodies in place."""
    if pushes is None:
        for body, force in made.constant_forces:
            body.force = force
    else:
        pushes.apply_now(0.0)
    for body in made.bodies:
        body.position -= 0.5 * h * body.velocity
        body.angle -= 0.5 * h * body.angular_velocity
    made.space.step(0.5 * h)
