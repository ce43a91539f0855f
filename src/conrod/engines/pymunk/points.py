"""Motion of the observed points, straight from the centres of gravity: what a run must record costs least this way."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from conrod.chunks import chunks
from conrod.engines.pymunk.instants import Staggered
from conrod.mechanism import Mechanism, ObservedPoint
from conrod.motion import Array
from conrod.trajectory import PointTracks, Track

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
        place = _place(mechanism, observed)
        velocities = _velocities(place, centres[1:], rates[1:], at.ahead)
        tracks[observed.name] = PointTracks(
            Track(at.position, _positions(place, centres)),
            Track(at.velocity, velocities),
            Track(at.acceleration, _differences(velocities[1:], at.step)),
        )
    return tracks


@dataclass(frozen=True)
class _Place:
    """Where a point is on its body: columns of its centre and of its turn, and the way from the centre [m]."""

    centre: slice
    turn: int
    way: tuple[float, float]

    def arm(self, turn: Array) -> tuple[Array, Array]:
        """The way from the centre, in the document's directions, at turns (T,) [rad]."""
        (x, y), cosine, sine = self.way, np.cos(turn), np.sin(turn)
        return cosine * x - sine * y, sine * x + cosine * y


def _place(mechanism: Mechanism, observed: ObservedPoint) -> _Place:
    i = 3 * mechanism.body_index[observed.body]
    cx, cy = mechanism.body(observed.body).centre_of_gravity
    return _Place(slice(i, i + 2), i + 2, (observed.point[0] - cx, observed.point[1] - cy))


def _positions(place: _Place, centres: Array) -> Array:
    positions = np.empty((len(centres), 2))
    for rows in chunks(len(centres), CHUNK):
        positions[rows] = centres[rows, place.centre]
        if place.way != (0.0, 0.0):
            arm_x, arm_y = place.arm(centres[rows, place.turn])
            positions[rows, 0] += arm_x
            positions[rows, 1] += arm_y
    return positions


def _velocities(place: _Place, centres: Array, rates: Array, ahead: float) -> Array:
    velocities = np.empty((len(rates), 2))
    for rows in chunks(len(rates), CHUNK):
        velocities[rows] = rates[rows, place.centre]
        if place.way != (0.0, 0.0):
            spin = rates[rows, place.turn]
            arm_x, arm_y = place.arm(centres[rows, place.turn] + ahead * spin)
            velocities[rows, 0] -= spin * arm_y
            velocities[rows, 1] += spin * arm_x
    return velocities


def _differences(velocities: Array, h: float) -> Array:
    accelerations = np.empty((max(len(velocities) - 1, 0), 2))
    for rows in chunks(len(accelerations), CHUNK):
        here = accelerations[rows]
        np.subtract(velocities[rows.start + 1 : rows.stop + 1], velocities[rows], out=here)
        here /= h
    return accelerations
