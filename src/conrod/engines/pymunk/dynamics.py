"""Dynamic mode: pymunk steps, conrod records. Nothing is written after the start but the crank's own angle."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from conrod.engines.centres import body_states
from conrod.engines.engine import PIECE, Machine
from conrod.engines.pymunk.built import VERSION, Build
from conrod.engines.pymunk.loads import pushes_of
from conrod.engines.pymunk.points import Staggered, point_tracks, staggered
from conrod.engines.pymunk.settings import PymunkSettings
from conrod.engines.pymunk.space import build
from conrod.engines.pymunk.stepping import advance, state
from conrod.engines.recording import Recorded, pieces
from conrod.exact.motion import Array
from conrod.mechanism.mechanism import Mechanism
from conrod.runs.trajectory import BodyStates, BodyTracks, Piece

KEPT = 3  # samples before a stretch of a run from which its velocities, accelerations and their instants follow


def run(
    machine: Machine, settings: PymunkSettings, revolutions: float, start_angle: float = 0.0, steps: int = PIECE
) -> Iterator[Piece]:
    """A run at constant crank speed in pieces of so many steps; the first one has the start beside its steps."""
    made = started(machine, settings, start_angle)
    driver, pushes = made.mechanism.driver, pushes_of(made, settings)
    known: tuple[Array, Array] = state(made)

    def record(_: int, times: Array) -> Recorded:
        nonlocal known
        # The engine sums speed x step; counted steps keep the crank where it belongs. At every step, because the drift
        # of a whole turn, put right at once, would be seen in the acceleration.
        turns = driver.start + driver.sense * machine.speed * times
        centres, rates = advance(made, settings, turns, known, (pushes.give, times) if pushes else None)
        at = staggered(made.mechanism, settings.timestep, times, centres, rates)
        known = centres[-KEPT:], rates[-KEPT:]
        at_all = made.mechanism, at, centres, rates
        return Recorded(body_tracks(*at_all), point_tracks(*at_all))

    return pieces(machine, settings, VERSION, revolutions, start_angle, steps, record, KEPT)


def started(machine: Machine, settings: PymunkSettings, start_angle: float) -> Build:
    """The machine's space in the exact state of a crank angle [rad]."""
    made = build(machine, settings)
    poses, slopes = machine.kinematics.derivatives(np.array([start_angle]), 1)
    made.place(poses[0], slopes[0] * machine.speed)
    return made


def body_tracks(mechanism: Mechanism, at: Staggered, centres: Array, rates: Array) -> BodyTracks:
    """States of all links at the instants that positions, velocities and accelerations belong to."""
    here = body_states(mechanism, centres, rates)
    middle = body_states(mechanism, centres[1:] + at.ahead * rates[1:], rates[1:])
    between = body_states(mechanism, centres[3:] + at.back * rates[2:-1], 0.5 * (rates[3:] + rates[2:-1]))
    rest = np.zeros_like
    return BodyTracks(
        BodyStates(at.position, *here, rest(here[0])),
        BodyStates(at.velocity, *middle, rest(middle[0])),
        BodyStates(at.acceleration, *between, np.diff(middle[1], axis=0)[1:] / at.step),
    )
