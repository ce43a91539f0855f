"""Comparison of a trajectory with the exact motion: errors as docs/design.md names them, at the crank angle reached.

A comparison works with any `ExactReference`; it depends on neither scenes nor engines. `compare` is for users with a
whole trajectory; studies feed each `ComparedPiece` of a run to the recorders of `run_errors`, with the same errors.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from conrod.comparison.outcome import joint_gaps
from conrod.comparison.trajectory import BodyTracks, Outcome, PointTracks, Track, Trajectory
from conrod.errors import InvalidInput, Named, unknown_choice
from conrod.exact.kinematics import ExactReference, Kinematics
from conrod.exact.link_rotations import ROTATIONS, link_rotations, rotating_links, rotation_scales
from conrod.exact.motion import QUANTITIES, Array, Instants, Motion


@dataclass(frozen=True)
class Size:
    """Largest value, root mean square and last value of a quantity over a sampled run."""

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
        """Largest, rms and last error."""
        return size_of(self.error)


@dataclass(frozen=True)
class PointErrors:
    """Errors of one observed point, normalised by L, omega L, omega^2 L and L."""

    position: ErrorSeries
    velocity: ErrorSeries
    acceleration: ErrorSeries
    total: ErrorSeries


@dataclass(frozen=True)
class ClosureErrors:
    """Largest gap in any joint, its rate and its acceleration; normalised by L, omega L, omega^2 L."""

    position: float
    velocity: float
    acceleration: float


@dataclass(frozen=True, repr=False)
class Comparison:
    """Errors of a trajectory against the exact motion."""

    points: Mapping[str, PointErrors]
    closure: ClosureErrors
    phase_max: float  # [rad]
    phase_final: float  # [rad]
    drive_speed: float  # largest |rate / omega - 1|
    drive_acceleration: float  # largest |angular acceleration| / omega^2
    links: Mapping[str, Mapping[str, Size]]  # by driven link and quantity of `ROTATIONS`, as in `link_errors`

    def __repr__(self) -> str:
        """Return the largest errors and the names of the points, without the thousands of samples."""
        sizes = ", ".join(f"{name} {self.worst(name):.2g}" for name in PointErrors.__dataclass_fields__)
        return f"<Comparison of {', '.join(self.points)}: largest {sizes}>"

    def worst(self, quantity: str, measure: str = "max") -> float:
        """The largest error of a quantity over all observed points; measure is max, rms or final.

        Raises:
            InvalidInput: the quantity or measure is unknown; names the choices.
        """
        for kind, given, known in (("quantity", quantity, PointErrors), ("measure", measure, Size)):
            if given not in known.__dataclass_fields__:
                raise unknown_choice(kind, given, known.__dataclass_fields__)
        # Unlike `max`, `np.max` keeps nan.
        return float(np.max([getattr(getattr(e, quantity).size, measure) for e in self.points.values()]))


def size_of(values: Array) -> Size:
    """Largest, rms and last value of a non-negative series (T,)."""
    return Size(float(values.max()), float(np.sqrt(np.mean(values**2))), float(values[-1]))


def compare(trajectory: Trajectory, reference: ExactReference) -> Comparison:
    """Compute the errors of a trajectory against the exact motion.

    Raises:
        ValueError: the run did not complete; an outcome other than completed has no errors.
    """
    if isinstance(reference, str):
        raise InvalidInput(f"compare takes a scene, not its name: SCENES[{reference!r}]")
    if trajectory.outcome is not Outcome.COMPLETED or trajectory.bodies is None:
        raise ValueError(f"a run that ended as {trajectory.outcome.slug!r} has no errors: {trajectory.reason}")
    run = ComparedPiece(trajectory, reference)
    drive = {name: float(values.max()) for name, values in run.drive.items()}
    return Comparison(
        points=Named(run.points, "observed point"),
        closure=ClosureErrors(**{name: float(gaps.max()) for name, gaps in run.closure.items()}),
        phase_max=max(float(one.max()) for one in run.phase),
        phase_final=float(run.phase[0][-1]),
        drive_speed=drive["speed"],
        drive_acceleration=drive["acceleration"],
        links=Named(
            {name: {q: size_of(one) for q, one in errors.items()} for name, errors in run.links.items()}, "link"
        ),
    )


@dataclass(frozen=True)
class ComparedPiece:
    """A run, or a part of it, with its exact motion; errors at every sample are computed once, when they are needed.

    Attributes:
        samples_remaining: samples of the run after the last one of this piece.
    """

    trajectory: Trajectory
    reference: ExactReference
    samples_remaining: int = 0

    @property
    def bodies(self) -> BodyTracks:
        """States of the bodies, which every run that is compared has."""
        assert self.trajectory.bodies is not None
        return self.trajectory.bodies

    @cached_property
    def exact(self) -> ExactMotions:
        """The exact motion at the samples."""
        return ExactMotions(self.reference)

    @cached_property
    def points(self) -> dict[str, PointErrors]:
        """Errors of the observed points, also of a run that did not complete."""
        return track_errors(self.trajectory.points, self.trajectory.speed, self.exact)

    @cached_property
    def links(self) -> dict[str, dict[str, Array]]:
        """Errors (T,) of each driven link's rotation, angular velocity and acceleration, as `link_errors` has them."""
        return link_errors(self.bodies, self.trajectory.speed, self.reference.kinematics)

    @cached_property
    def closure(self) -> dict[str, Array]:
        """Largest joint gap, its rate and its acceleration at their samples (T,), normalised as in `ClosureErrors`."""
        length, speed, bodies = max(self.reference.lengths.values()), abs(self.trajectory.speed), self.bodies
        derivatives = {
            "position": [bodies.position.poses],
            "velocity": [bodies.velocity.poses, bodies.velocity.rates],
            "acceleration": [bodies.acceleration.poses, bodies.acceleration.rates, bodies.acceleration.accelerations],
        }
        mechanism = self.reference.mechanism()
        return {
            name: np.abs(list(joint_gaps(mechanism, some).values())).max(axis=0) / (length * speed**k)
            for k, (name, some) in enumerate(derivatives.items())
        }

    @cached_property
    def phase(self) -> list[Array]:
        """Deviation of the crank angle from speed x time [rad] at all instants; body positions come first."""
        held: list[BodyTracks | PointTracks] = [self.bodies, *self.trajectory.points.values()]
        found = [part.instants for tracks in held for part in (tracks.position, tracks.velocity, tracks.acceleration)]
        every = {id(instants): instants for instants in found}.values()  # most are one object
        return [np.abs(instants.angle - self.trajectory.speed * instants.times) for instants in every]

    @property
    def drive(self) -> dict[str, Array]:
        """Relative speed error |rate / omega - 1| and |angular acceleration| / omega^2 at their samples (T,)."""
        rate, acceleration = self.bodies.velocity.instants.rate, self.bodies.acceleration.instants.acceleration
        speed = self.trajectory.speed
        return {"speed": np.abs(rate / speed - 1.0), "acceleration": np.abs(acceleration) / speed**2}


def track_errors(points: Mapping[str, PointTracks], speed: float, exact: ExactMotions) -> dict[str, PointErrors]:
    """Errors of points from tracks of any origin; the nominal speed is in rad/s."""
    return {name: _point_errors(name, tracks, exact, speed) for name, tracks in points.items()}


def link_errors(bodies: BodyTracks, speed: float, kinematics: Kinematics) -> dict[str, dict[str, Array]]:
    """Errors (T,) of the driven links by name of link and quantity, at the crank angle, rate and acceleration reached.

    A rotation is over its range R in a revolution, an angular velocity over omega R and an angular acceleration over
    omega^2 R, with the nominal speed omega [rad/s]; R is 1 rad for a link that is guided so that it does not rotate.
    Rotations count on over whole turns, so that a slipped turn is an error of 2 pi / R. The crank is no driven link:
    its rotation is the angle that all are compared at.
    """
    index, scales = kinematics.mechanism.body_index, rotation_scales(kinematics)
    measured = (bodies.position.poses, bodies.velocity.rates, bodies.acceleration.accelerations)
    known: dict[int, tuple[Array, ...]] = {}  # exact rotations by identity of instants, which quantities may share
    found: dict[str, dict[str, Array]] = {name: {} for name in scales}
    for order in (2, 1, 0) if scales else ():
        quantity, at = ROTATIONS[order], getattr(bodies, QUANTITIES[order]).instants
        if id(at) not in known:
            known[id(at)] = _exact_rotations(kinematics, at, order)
        off = np.abs(measured[order][:, 2::3] - known[id(at)][order])
        for name, scale in scales.items():
            found[name][quantity] = off[:, index[name]] / (scale * abs(speed) ** order)
    return {name: {quantity: errors[quantity] for quantity in ROTATIONS} for name, errors in found.items()}


def _exact_rotations(kinematics: Kinematics, at: Instants, order: int) -> tuple[Array, ...]:
    """Rotations of all links and their derivatives in time up to an order, (T, n) or (1, n) each."""
    if not rotating_links(kinematics):  # as in a cam with a sliding follower, whose exact poses take longest
        still = kinematics.start[:, 2::3]
        return (still, *[np.zeros_like(still)] * order)
    return link_rotations(kinematics, at.angle, at.rate, at.acceleration, order=order)


class ExactMotions:
    """Exact motions of all points at given instants, computed once for all tracks that share them."""

    def __init__(self, reference: ExactReference) -> None:
        self.lengths = reference.lengths
        self._reference = reference
        self._known: dict[tuple[int, str], tuple[Instants, Motion]] = {}  # by identity of instants, kept for it

    def error(self, track: Track, name: str, quantity: str) -> Array:
        """Measured minus exact values (T, 2) [m, m/s or m/s^2], at the angle, rate and acceleration reached."""
        exact: Array = getattr(self.at_reached_angle(track.instants).point(name), quantity)
        return track.values - exact

    def at_reached_angle(self, instants: Instants) -> Motion:
        """The motion at the angle, rate and acceleration that the crank actually had."""
        return self._cached_motion("at", instants, instants.angle, instants.rate, instants.acceleration)

    def at_nominal_angle(self, instants: Instants, speed: float) -> Motion:
        """The motion at the nominal crank angle, speed x time."""
        return self._cached_motion("nominal", instants, speed * instants.times, speed)

    def _cached_motion(self, which: str, instants: Instants, *at: Any) -> Motion:
        """The reference's motion for these instants, computed at the first call."""
        key = id(instants), which
        if key not in self._known:
            self._known[key] = instants, self._reference.motion(*at)
        return self._known[key][1]


def _point_errors(name: str, tracks: PointTracks, exact: ExactMotions, speed: float) -> PointErrors:
    """Errors of one observed point."""
    length = exact.lengths[name]

    def series(track: Track, off: Array, norm: float) -> ErrorSeries:
        return ErrorSeries(track.instants.angle, np.linalg.norm(off, axis=1) / norm)

    def error(quantity: str, norm: float) -> ErrorSeries:
        """Error of a quantity at the crank angle reached, over `norm`."""
        track: Track = getattr(tracks, quantity)
        return series(track, exact.error(track, name, quantity), norm)

    position = tracks.position
    late = position.values - exact.at_nominal_angle(position.instants, speed).point(name).position
    return PointErrors(
        position=error("position", length),
        velocity=error("velocity", length * abs(speed)),
        acceleration=error("acceleration", length * abs(speed) ** 2),
        total=series(position, late, length),
    )
