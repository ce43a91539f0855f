"""A trajectory against the exact motion: errors as docs/design.md names them, at the angle actually reached.

Compares with any ruler that offers `motion(angle, speed, acceleration)`; it knows neither scenes nor engines.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from conrod.mechanism import Mechanism
from conrod.motion import Array, Motion
from conrod.outcome import joint_gaps
from conrod.trajectory import Outcome, PointTracks, Track, Trajectory

QUANTITIES = ("position", "velocity", "acceleration", "total")


class Ruler(Protocol):
    """An exact reference: a scene."""

    @property
    def lengths(self) -> Mapping[str, float]:
        """Normalising length of each observed point [m]."""
        ...

    def motion(self, angle: ArrayLike, speed: ArrayLike, acceleration: ArrayLike = 0.0) -> Motion:
        """Exact motion at given crank angles, rates and angular accelerations."""
        ...

    def mechanism(self) -> Mechanism:
        """The mechanism whose joints' gaps are measured."""
        ...


@dataclass(frozen=True)
class Size:
    """A quantity over the sampled run: largest, root mean square and last value."""

    max: float
    rms: float
    final: float


@dataclass(frozen=True)
class ErrorSeries:
    """Normalised error of one quantity of one point at every sample."""

    angle: Array  # (T,) [rad], crank angle of the sample
    error: Array  # (T,), Euclidean norm, normalised

    @property
    def size(self) -> Size:
        """Max, rms and final value."""
        return size_of(self.error)


@dataclass(frozen=True)
class PointErrors:
    """Errors of one observed point, normalised by L, omega L, omega^2 L and L."""

    position: ErrorSeries
    velocity: ErrorSeries
    acceleration: ErrorSeries
    total: ErrorSeries


@dataclass(frozen=True)
class Peak:
    """Largest exact magnitude of a point's velocity and acceleration over the run [m/s, m/s^2]."""

    velocity: float
    acceleration: float


@dataclass(frozen=True)
class Closure:
    """Largest gap left open in any joint, its rate and its acceleration; normalised by L, omega L, omega^2 L."""

    position: float
    velocity: float
    acceleration: float


@dataclass(frozen=True)
class Comparison:
    """What a trajectory differs from the exact motion by."""

    points: Mapping[str, PointErrors]
    peaks: Mapping[str, Peak]
    closure: Closure
    phase_max: float  # [rad]
    phase_final: float  # [rad]
    drive_speed: float  # largest |rate / omega - 1|
    drive_acceleration: float  # largest |angular acceleration| / omega^2

    def worst(self, quantity: str, measure: str = "max") -> float:
        """The largest error of a quantity over all observed points; measure is max, rms or final."""
        return max(float(getattr(getattr(e, quantity).size, measure)) for e in self.points.values())


def size_of(values: Array) -> Size:
    """Max, rms and final value of a non-negative series."""
    return Size(float(values.max()), float(np.sqrt(np.mean(values**2))), float(values[-1]))


def compare(trajectory: Trajectory, ruler: Ruler) -> Comparison:
    """Errors of a trajectory against the exact motion.

    Raises:
        ValueError: the run did not complete; an outcome other than completed has no errors.
    """
    if trajectory.outcome is not Outcome.COMPLETED or trajectory.bodies is None:
        raise ValueError(f"a run that ended as {trajectory.outcome.slug!r} has no errors: {trajectory.reason}")
    speed = abs(trajectory.speed)
    points = {name: _point_errors(name, tracks, ruler, trajectory) for name, tracks in trajectory.points.items()}
    peaks = {name: _peak(name, tracks, ruler) for name, tracks in trajectory.points.items()}
    position, velocity = trajectory.bodies.position.instants, trajectory.bodies.velocity.instants
    phase = np.abs(position.angle - trajectory.speed * position.times)
    return Comparison(
        points=points,
        peaks=peaks,
        closure=_closure(trajectory, ruler, max(ruler.lengths.values())),
        phase_max=float(phase.max()),
        phase_final=float(phase[-1]),
        drive_speed=float(np.abs(velocity.rate / trajectory.speed - 1.0).max()),
        drive_acceleration=float(np.abs(trajectory.bodies.acceleration.instants.acceleration).max()) / speed**2,
    )


def _point_errors(name: str, tracks: PointTracks, ruler: Ruler, trajectory: Trajectory) -> PointErrors:
    length, speed = ruler.lengths[name], abs(trajectory.speed)
    nominal = ruler.motion(trajectory.speed * tracks.position.instants.times, trajectory.speed).point(name).position
    return PointErrors(
        position=_error(name, "position", tracks.position, ruler, length),
        velocity=_error(name, "velocity", tracks.velocity, ruler, length * speed),
        acceleration=_error(name, "acceleration", tracks.acceleration, ruler, length * speed**2),
        total=ErrorSeries(
            tracks.position.instants.angle, np.linalg.norm(tracks.position.values - nominal, axis=1) / length
        ),
    )


def signed_error(track: Track, ruler: Ruler, name: str, quantity: str) -> Array:
    """Measured minus exact (T, 2) [m, m/s or m/s^2], at the angle, rate and angular acceleration reached."""
    at = track.instants
    exact: Array = getattr(ruler.motion(at.angle, at.rate, at.acceleration).point(name), quantity)
    return track.values - exact


def _error(name: str, quantity: str, track: Track, ruler: Ruler, norm: float) -> ErrorSeries:
    error = signed_error(track, ruler, name, quantity)
    return ErrorSeries(track.instants.angle, np.linalg.norm(error, axis=1) / norm)


def _peak(name: str, tracks: PointTracks, ruler: Ruler) -> Peak:
    at = tracks.acceleration.instants
    exact = ruler.motion(at.angle, at.rate).point(name)
    return Peak(
        float(np.linalg.norm(exact.velocity, axis=1).max()), float(np.linalg.norm(exact.acceleration, axis=1).max())
    )


def _closure(trajectory: Trajectory, ruler: Ruler, length: float) -> Closure:
    bodies, speed, mechanism = trajectory.bodies, abs(trajectory.speed), ruler.mechanism()
    assert bodies is not None
    position, velocity, acceleration = bodies.position, bodies.velocity, bodies.acceleration
    return Closure(
        _largest_gap(mechanism, [position.poses]) / length,
        _largest_gap(mechanism, [velocity.poses, velocity.rates]) / (length * speed),
        _largest_gap(mechanism, [acceleration.poses, acceleration.rates, acceleration.accelerations])
        / (length * speed**2),
    )


def _largest_gap(mechanism: Mechanism, derivatives: list[Array]) -> float:
    return max(float(np.abs(gap).max()) for gap in joint_gaps(mechanism, derivatives).values())
