"""The instants that pymunk's samples belong to, and the motion of points and links at them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from conrod.exact.joint_equations import pose_jets
from conrod.exact.motion import Array, cache_blocks
from conrod.mechanism.mechanism import Mechanism, ObservedPoint
from conrod.runs.trajectory import Instants, PointTracks, Track


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


def staggered(
    mechanism: Mechanism, h: float, times: Array, centres: Array, rates: Array, substep: float | None = None
) -> Staggered:
    """Instants of samples at times (T,) [s] with a step h [s], and where the crank was by the engine's own account.

    Args:
        centres: centres of gravity with turns (T, 3 n) [m, m, rad].
        rates: theirs, each at the instant that velocities belong to.
        substep: length of the engine's own steps [s], where it takes several from sample to sample.
    """
    ahead = 0.0 if mechanism.cam_contacts else 0.5 * (substep or h)
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
    """A point on its body: columns of its centre and of its turn, and the way from the centre [m]."""

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
    for rows in cache_blocks(len(centres), CHUNK):
        positions[rows] = centres[rows, place.centre]
        if place.way != (0.0, 0.0):
            arm_x, arm_y = place.arm(centres[rows, place.turn])
            positions[rows, 0] += arm_x
            positions[rows, 1] += arm_y
    return positions


def _velocities(place: _Place, centres: Array, rates: Array, ahead: float) -> Array:
    velocities = np.empty((len(rates), 2))
    for rows in cache_blocks(len(rates), CHUNK):
        velocities[rows] = rates[rows, place.centre]
        if place.way != (0.0, 0.0):
            spin = rates[rows, place.turn]
            arm_x, arm_y = place.arm(centres[rows, place.turn] + ahead * spin)
            velocities[rows, 0] -= spin * arm_y
            velocities[rows, 1] += spin * arm_x
    return velocities


def _differences(velocities: Array, h: float) -> Array:
    accelerations = np.empty((max(len(velocities) - 1, 0), 2))
    for rows in cache_blocks(len(accelerations), CHUNK):
        here = accelerations[rows]
        np.subtract(velocities[rows.start + 1 : rows.stop + 1], velocities[rows], out=here)
        here /= h
    return accelerations


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
