"""Dynamic mode: pymunk steps, conrod records. Nothing is written after the start but the crank's own angle and loads.

The instants that samples belong to are those of `Staggered`. A velocity given at t = 0 and stepped with as it is would
be early by half a step, for good, where nothing but the start prescribes it: order 1. So in free motion bodies are put
back by half a step, x_0 - h v_0 / 2, and the first step has half the length: it ends in the given poses, with the
velocities of t = h / 2. Reported rates are means of those before and after. Contact is corrected by velocities of its
own, and its velocities belong to t_n as they are.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from conrod.engines.engine import PIECE_STEPS, Machine
from conrod.engines.numerics import frames_from_centres
from conrod.engines.pymunk import PymunkSettings
from conrod.engines.pymunk.gears import gears_refusal
from conrod.engines.pymunk.loads import Pushes, pushes_of
from conrod.engines.pymunk.space import VERSION, Build, build, build_free
from conrod.engines.pymunk.stepping import advance, state
from conrod.engines.run import RecordedStretch, record_pieces
from conrod.engines.tracks import FreeRun, Pace
from conrod.errors import InvalidInput
from conrod.exact.motion import Array, cache_blocks, rotate_planar
from conrod.mechanism.mechanism import Mechanism
from conrod.runs.trajectory import BodyStates, BodyTracks, Instants, Piece, PointTracks, Track


@dataclass(frozen=True)
class Staggered:
    """Instants of the T samples of a run.

    A step moves positions first, x_(n+1) = x_n + h v_n, and then makes v_(n+1) fit the joints there. So v_n is the
    difference of two positions and belongs to the middle of the step that follows it, t_n + h / 2; v_0, given at
    t = 0, is left out. (A contact is corrected by velocities of its own, apart from v_n, which then fits the instant
    t_n itself.) Acceleration is the difference of two velocities and belongs to the instant between. It
    begins at the third step: positions run behind the exact ones by a lag that is complete only after the second step.

    Attributes:
        position: (T,), of all samples.
        velocity: (T - 1,), of those from the second on.
        acceleration: (T - 3,), of those from the fourth on, each with the one before.
        step: h [s].
        ahead: from a sample to the instant of its velocity [s].
        back: from a sample to the instant of the acceleration [s].
    """

    position: Instants
    velocity: Instants
    acceleration: Instants
    step: float
    ahead: float
    back: float


def staggered(mechanism: Mechanism, h: float, times: Array, centres: Array, rates: Array) -> Staggered:
    """Instants of samples at times (T,) [s] with a step h [s], and where the crank was by the engine's own account.

    Args:
        centres: centres of gravity with turns (T, 3 n) [m, m, rad].
        rates: theirs, each at the instant that velocities belong to.
    """
    ahead = 0.0 if mechanism.cam_contacts else 0.5 * h
    back = ahead - 0.5 * h
    driver, crank = mechanism.driver, 3 * mechanism.body_index[mechanism.crank] + 2
    turn, spin = centres[:, crank].copy(), rates[:, crank].copy()

    def at(times: Array, turn: Array, spin: Array, gain: Array | None = None) -> Instants:
        rest = np.zeros_like(spin) if gain is None else driver.sense * gain
        return Instants(times, driver.sense * (turn - driver.start), driver.sense * spin, rest)

    return Staggered(
        position=at(times, turn, spin),
        velocity=at(times[1:] + ahead, turn[1:] + ahead * spin[1:], spin[1:]),
        acceleration=at(
            times[3:] + back,
            turn[3:] + back * spin[2:-1],
            0.5 * (spin[3:] + spin[2:-1]),
            (spin[3:] - spin[2:-1]) / h,
        ),
        step=h,
        ahead=ahead,
        back=back,
    )


CHUNK = 4096


def point_tracks(mechanism: Mechanism, at: Staggered, centres: Array, rates: Array) -> dict[str, PointTracks]:
    """Tracks of all observed points.

    Args:
        at: instants of the T samples.
        centres: centres of gravity with turns (T, 3 n) [m, m, rad].
        rates: theirs, each at the instant that velocities belong to.
    """
    tracks = {}
    for observed in mechanism.observed:
        i, centre = 3 * mechanism.body_index[observed.body], mechanism.body(observed.body).centre_of_gravity
        way = (observed.point[0] - centre[0], observed.point[1] - centre[1])
        positions, velocities = np.empty((2, len(centres), 2))
        for rows in cache_blocks(len(centres), CHUNK):
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


KEPT = 3  # samples before a stretch of a run from which its velocities, accelerations and their instants follow


def run(
    machine: Machine, settings: PymunkSettings, revolutions: float, start_angle: float = 0.0, steps: int = PIECE_STEPS
) -> Iterator[Piece]:
    """A run at constant crank speed in pieces of so many steps; the first one has the start beside its steps."""
    made = started(machine, settings, start_angle)
    pushes, known = pushes_of(made, settings), state(made)

    def record(_: int, times: Array) -> RecordedStretch:
        nonlocal known
        # The engine sums speed x step; counted steps keep the crank where it belongs. At every step, because the drift
        # of a whole turn, put right at once, would be seen in the acceleration.
        begins = times[len(known[0]) - 1 : -1]
        turns = turns_at(machine, begins)
        loading = (pushes.give, begins) if pushes else None
        found = advance(made, settings.timestep, turns, known, loading, settings.rounded_state)
        known = found[0][-KEPT:], found[1][-KEPT:]
        at = staggered(made.mechanism, settings.timestep, times, *found)
        return RecordedStretch(body_tracks(made.mechanism, at, *found), point_tracks(made.mechanism, at, *found))

    return record_pieces(machine, settings, VERSION, revolutions, start_angle, steps, record, KEPT)


def turns_at(machine: Machine, times: Array) -> Array:
    """Turns of the crank body (T,) [rad] at times (T,) [s]."""
    driver = machine.kinematics.mechanism.driver
    return np.asarray(driver.start + driver.sense * machine.speed * times, dtype=float)


def started(machine: Machine, settings: PymunkSettings, start_angle: float) -> Build:
    """The machine's space in the exact state of a crank angle [rad]."""
    made = build(machine, settings)
    poses, slopes = machine.kinematics.derivatives(np.array([start_angle]), 1)
    made.place(poses[0], slopes[0] * machine.speed)
    return made


def body_tracks(mechanism: Mechanism, at: Staggered, centres: Array, rates: Array) -> BodyTracks:
    """States of all links at the instants that positions, velocities and accelerations belong to."""
    here = frames_from_centres(mechanism, centres, rates)
    middle = frames_from_centres(mechanism, centres[1:] + at.ahead * rates[1:], rates[1:])
    between = frames_from_centres(mechanism, centres[3:] + at.back * rates[2:-1], 0.5 * (rates[3:] + rates[2:-1]))
    rest = np.zeros_like
    return BodyTracks(
        BodyStates(at.position, *here, rest(here[0])),
        BodyStates(at.velocity, *middle, rest(middle[0])),
        BodyStates(at.acceleration, *between, np.diff(middle[1], axis=0)[1:] / at.step),
    )


# -- free and torque-driven motion -------------------------------------------------------------------------------------


def free_run(
    mechanism: Mechanism, preset: str, timestep: float, steps: int, poses: Array, rates: Array, pace: Pace,
    every: int = 1,
) -> FreeRun:  # fmt: skip
    """So many steps from exact poses and rates (3 n,), sampled at every so-many-th; no rule here asks for the pace.

    Raises:
        InvalidInput: there is no such preset, or pymunk cannot have a joint of the mechanism; says why.
    """
    settings = PymunkSettings.free(mechanism, preset, timestep)
    if reason := gears_refusal(mechanism):
        raise InvalidInput(f"{mechanism.name}: {reason}")
    made = build_free(mechanism, settings, poses)
    made.place(poses, rates)
    h, in_step = settings.timestep, not mechanism.cam_contacts
    pushes = Pushes(made, h, 0.5 * h if in_step else 0.0) if mechanism.loads else None
    if in_step:
        _half_step(made, h, pushes)
    known = state(made)
    places, speeds = ([values] for values in known)
    length = max(1, PIECE_STEPS // every) * every
    for done in range(0, steps, length):
        begins = np.asarray(h * np.arange(done, min(done + length, steps)), dtype=float)
        centres, rates_at = advance(made, h, begins, known, (pushes.give, begins) if pushes else None)
        known = centres[-1:], rates_at[-1:]
        # A sample is due after step k, counted from 1, where it divides.
        places.append(centres[every::every])
        means = 0.5 * (rates_at[:-1] + rates_at[1:]) if in_step else rates_at[1:]
        speeds.append(means[every - 1 :: every])
    with np.errstate(all="ignore"):
        reported_poses, reported_rates = frames_from_centres(mechanism, np.vstack(places), np.vstack(speeds))
        reported_poses[0], reported_rates[0] = poses, rates
    times = np.asarray(h * (every * np.arange(len(reported_poses))), dtype=float)
    return FreeRun.from_states(mechanism, times, (reported_poses, reported_rates))


def _half_step(made: Build, h: float, pushes: Pushes | None) -> None:
    """Bring the velocities to h / 2, with the bodies where they are."""
    if pushes is None:
        for body, force in made.pushed:
            body.force = force
    else:
        pushes.as_they_are(0.0)
    for body in made.bodies:
        body.position -= 0.5 * h * body.velocity
        body.angle -= 0.5 * h * body.angular_velocity
    made.space.step(0.5 * h)
