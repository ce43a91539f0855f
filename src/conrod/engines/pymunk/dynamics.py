"""Dynamic mode: pymunk steps, conrod records. Nothing is written after the start but the crank's own angle."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from conrod.engines.centres import body_states
from conrod.engines.engine import PIECE, Machine
from conrod.engines.massless_rod import ModelForm
from conrod.engines.pymunk.built import VERSION, Build
from conrod.engines.pymunk.loads import pushes_of
from conrod.engines.pymunk.points import Staggered, point_tracks, staggered
from conrod.engines.pymunk.settings import PymunkSettings
from conrod.engines.pymunk.space import build
from conrod.engines.pymunk.stepping import advance, state
from conrod.engines.recording import Recorded, pieces
from conrod.exact.kinematics import Kinematics
from conrod.exact.motion import Array
from conrod.runs.trajectory import BodyStates, BodyTracks, Piece, PointTracks, Track

KEPT = 3  # samples before a stretch of a run from which its velocities, accelerations and their instants follow


def run(
    machine: Machine, settings: PymunkSettings, revolutions: float, start_angle: float = 0.0, steps: int = PIECE
) -> Iterator[Piece]:
    """A run at constant crank speed in pieces of so many steps; the first one has the start beside its steps."""
    made, kinematics = started(machine, settings, start_angle), machine.kinematics
    driver, pushes = made.mechanism.driver, pushes_of(made, settings)
    known: tuple[Array, Array] = state(made)
    before: BodyTracks | None = None

    def record(_: int, times: Array) -> Recorded:
        nonlocal known, before
        # The engine sums speed x step; counted steps keep the crank where it belongs. At every step, because the drift
        # of a whole turn, put right at once, would be seen in the acceleration.
        turns = driver.start + driver.sense * machine.speed * times
        centres, rates = advance(made, settings, turns, known, (pushes.give, times) if pushes else None)
        at = staggered(made.mechanism, settings.timestep, times, centres, rates)
        bodies = body_tracks(made.form, at, centres, rates, before)
        points = point_tracks(made.mechanism, at, centres, rates) | unseen_points(kinematics, made.form, at, bodies)
        known, before = (centres[-KEPT:], rates[-KEPT:]), bodies
        return Recorded(bodies, points)

    return pieces(machine, settings, VERSION, revolutions, start_angle, steps, record, KEPT)


def started(machine: Machine, settings: PymunkSettings, start_angle: float) -> Build:
    """The machine's space in the exact state of a crank angle [rad]."""
    made = build(machine, settings)
    poses, slopes = machine.kinematics.derivatives(np.array([start_angle]), 1)
    made.place(poses[0], slopes[0] * machine.speed)
    return made


def body_tracks(
    form: ModelForm, at: Staggered, centres: Array, rates: Array, before: BodyTracks | None = None
) -> BodyTracks:
    """States of all links at the instants that positions, velocities and accelerations belong to.

    Args:
        before: those of the stretch before, the last samples of which begin this one.
    """
    after = (None, None, None) if before is None else _followed(before)
    here = _states(form, centres, rates, after[0])
    middle = _states(form, centres[1:] + at.ahead * rates[1:], rates[1:], after[1])
    between = _states(form, centres[3:] + at.back * rates[2:-1], 0.5 * (rates[3:] + rates[2:-1]), after[2])
    rest = np.zeros_like
    return BodyTracks(
        BodyStates(at.position, *here, rest(here[0])),
        BodyStates(at.velocity, *middle, rest(middle[0])),
        BodyStates(at.acceleration, *between, np.diff(middle[1], axis=0)[1:] / at.step),
    )


def _followed(before: BodyTracks) -> list[Array | None]:
    """Poses that the next stretch begins with, or after: it has three of these positions, two velocities."""
    starts = ((before.position, KEPT), (before.velocity, KEPT - 1), (before.acceleration, 1))
    return [states.poses[-back] if len(states.poses) >= back else None for states, back in starts]


def unseen_points(kinematics: Kinematics, form: ModelForm, at: Staggered, bodies: BodyTracks) -> dict[str, PointTracks]:
    """Tracks of the points observed on links that the engine does not have."""
    unseen = [point.name for point in form.whole.observed if point not in form.mechanism.observed]
    if not unseen:
        return {}
    places, rates = (kinematics.point_derivatives([s.poses, s.rates]) for s in (bodies.position, bodies.velocity))
    return {
        name: PointTracks(
            Track(at.position, places[name][0]),
            Track(at.velocity, rates[name][1]),
            Track(at.acceleration, np.diff(rates[name][1], axis=0)[1:] / at.step),
        )
        for name in unseen
    }


def _states(form: ModelForm, centres: Array, rates: Array, after: Array | None) -> tuple[Array, Array]:
    """Poses and rates of the frames of all links from those of the engine's centres of gravity."""
    poses, speeds = form.completed(body_states(form.mechanism, centres, rates), after)
    return poses, speeds
