"""Defects that `conrod validate --qualify` plants, in a recorded run or in its reference.

A run of a right model, compared with a reference that has a longer rod, has the errors of a wrong model compared with
the right reference, and needs no second run.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, Self

import numpy as np

from conrod.comparison.trajectory import (
    ArrayMapper,
    BodyStates,
    BodyTracks,
    Piece,
    PointTracks,
    Track,
    concatenate_pieces,
)
from conrod.engines.engine import Engine
from conrod.errors import InvalidInput
from conrod.exact.kinematics import ExactReference, GenericReference, Kinematics
from conrod.exact.motion import Instants
from conrod.mechanism.mechanism import Mechanism, Point, Revolute
from conrod.scenes import Scene

ASSEMBLY_TRIES = 40  # random starts from which another assembly is searched for
MIN_POINT_DISTANCE = 0.01  # of the machine's size, by which a point of another assembly has to be elsewhere
FREE_FALL_ACCELERATION = (0.0, -9.81)  # [m/s^2]


@dataclass(frozen=True)
class Recording:
    """A recorded run, and the reference that it is compared with."""

    run: Piece
    reference: ExactReference

    @classmethod
    def from_engine(
        cls, engine: Engine[Any], scene: ExactReference, settings: Any, revolutions: float, start_angle: float
    ) -> Self:
        """Run a scene in an engine from a start angle [rad], and record it as one piece."""
        steps = max(round(settings.steps_per_revolution * revolutions), 1)
        return cls(concatenate_pieces(list(engine.run(scene, settings, revolutions, start_angle, steps))), scene)


# Returns a recording with a defect of a size planted.
DefectFunction = Callable[[Recording, float], Recording]
# Yields the names of the places where a recording can have a defect, each with the function that plants it there.
DefectPlaces = Callable[[Recording], Iterator[tuple[str, DefectFunction]]]


@dataclass(frozen=True)
class Defect:
    """A kind of defect, with the places where it can be planted.

    Attributes:
        unit: unit of its size, in words; empty if it has no size.
        size: size that `--qualify` plants; the smallest noticed size is found by bisection.
        largest: largest size that is tried.
        places: places of the defect in a recording; none if the machine has no such place.
    """

    name: str
    unit: str
    size: float
    largest: float
    places: DefectPlaces


# -- changes of the recorded run ---------------------------------------------------------------------------------------


def place_in_recording(change: Callable[[Recording, float], Piece]) -> DefectPlaces:
    """Return the only place, without a name, of a defect that changes the recorded run."""
    return lambda _: iter([("", lambda given, size: replace(given, run=change(given, size)))])


def change_tracks(run: Piece, quantity: str, change: Callable[[str, Track], Track], which: int | None = None) -> Piece:
    """Return a run with changed samples of a quantity.

    Args:
        change: returns the changed track of an observed point, from the point's name and its track.
        which: index of the only point to change; None for all observed points.
    """
    points = dict(run.trajectory.points)
    for name in list(points)[slice(which, None if which is None else which + 1)]:
        points[name] = replace(points[name], **{quantity: change(name, getattr(points[name], quantity))})
    return replace(run, trajectory=replace(run.trajectory, points=points))


def _stamp_velocities_early(recording: Recording, steps: float) -> Piece:
    """Return the run with velocities stamped a number of steps before their instants."""
    advance = steps * recording.run.trajectory.settings.timestep

    def stamp_early(_: str, track: Track) -> Track:
        at = track.instants
        return replace(track, instants=replace(at, times=at.times - advance, angle=at.angle - advance * at.rate))

    return change_tracks(recording.run, "velocity", stamp_early)


def _leave_gravity_in(recording: Recording, share: float) -> Piece:
    """Return the run with accelerations a - share g, which an accelerometer measures at share 1."""
    return change_tracks(
        recording.run,
        "acceleration",
        lambda _, track: replace(track, values=track.values - share * np.array(FREE_FALL_ACCELERATION)),
    )


def _insert_nan(recording: Recording, _: float) -> Piece:
    """Return the run with NaN for the position in the middle."""

    def insert_nan(_: str, track: Track) -> Track:
        values = track.values.copy()
        values[len(values) // 2] = math.nan
        return replace(track, values=values)

    return change_tracks(recording.run, "position", insert_nan)


def _cut_end(recording: Recording, share: float) -> Piece:
    """Return the run without the last share of its samples, still with its outcome `completed`."""
    run, samples = recording.run, len(recording.run.clock)
    kept = samples - math.ceil(share * samples - 1e-9)
    cut = ArrayMapper(lambda parts: parts[0][: max(2, kept - samples + len(parts[0]))])
    trajectory = run.trajectory
    points = {name: cut(tracks) for name, tracks in trajectory.points.items()}
    bodies = trajectory.bodies and cut(trajectory.bodies)
    return replace(run, clock=run.clock[:kept], trajectory=replace(trajectory, points=points, bodies=bodies))


def other_branch_place(recording: Recording) -> Iterator[tuple[str, DefectFunction]]:
    """Yield the only place of the defect "another branch", if the machine has another branch."""
    other = find_other_assembly(recording.reference)
    if other is None:
        return

    def body_states(at: Instants) -> BodyStates:
        """Exact states by the chain rule: dq/dt = q' omega, d2q/dt2 = q'' omega^2 + q' alpha."""
        poses, first, second = other.derivatives(at.angle, 2)
        omega, alpha = at.rate[:, None], at.acceleration[:, None]
        return BodyStates(at, poses, first * omega, second * omega**2 + first * alpha)

    def flip_branch(now: Recording, _: float) -> Recording:
        """Replace all recorded states by exact states on another branch at the same instants."""
        tracks = next(iter(now.run.trajectory.points.values()))
        states = [body_states(track.instants) for track in (tracks.position, tracks.velocity, tracks.acceleration)]
        derivatives = [other.point_derivatives([at.poses, at.rates, at.accelerations]) for at in states]
        points = {
            name: PointTracks(
                *(
                    Track(at.instants, by_point[name][order])
                    for order, (at, by_point) in enumerate(zip(states, derivatives, strict=True))
                )
            )
            for name in now.run.trajectory.points
        }
        bodies = now.run.trajectory.bodies and BodyTracks(*states)
        trajectory = replace(now.run.trajectory, points=points, bodies=bodies)
        return replace(now, run=replace(now.run, trajectory=trajectory))

    yield "", flip_branch


# -- changes of the machine that the run is compared with -------------------------------------------------------------

# Yields the names of places in a mechanism, each with the function that returns the mechanism changed there by a size.
MechanismChanges = Callable[[Mechanism], Iterator[tuple[str, Callable[[float], Mechanism]]]]


def _places_in_mechanism(changes: MechanismChanges) -> DefectPlaces:
    """Return the places of a defect that changes the mechanism of the reference."""

    def plant(changed: Callable[[float], Mechanism], recording: Recording, size: float) -> Recording:
        return replace(recording, reference=GenericReference(changed(size), recording.reference.speed))

    return lambda given: ((where, partial(plant, one)) for where, one in changes(given.reference.mechanism()))


def _move_joint_point(mechanism: Mechanism, name: str, end: str, at: Any, by: Any, size: float) -> Mechanism:
    """Return the mechanism with a joint's point on one of its bodies moved to at + size by.

    Args:
        name: name of the joint.
        end: "point_a" or "point_b".
        at, by: point and displacement (2,) in the body's frame [m].
    """
    change: Any = {end: tuple((np.asarray(at) + size * np.asarray(by)).tolist())}
    joints = tuple(replace(joint, **change) if joint.name == name else joint for joint in mechanism.joints)
    return replace(mechanism, joints=joints)


def _link_length_changes(mechanism: Mechanism) -> Iterator[tuple[str, Callable[[float], Mechanism]]]:
    """Yield changes, as a share, of the distance from the first pin of a body to each other pin."""
    for body in mechanism.bodies:
        ends = [(j, "point_a" if j.a == body.name else "point_b") for j in mechanism.joints_on(body.name)]
        pins: list[tuple[str, str, Point]] = [
            (joint.name, end, getattr(joint, end)) for joint, end in ends if isinstance(joint, Revolute)
        ]
        for name, end, place in pins[1:]:
            length = np.subtract(place, pins[0][2])
            if length.any():
                yield body.name, partial(_move_joint_point, mechanism, name, end, place, length)


def length_places(recording: Recording) -> Iterator[tuple[str, DefectFunction]]:
    """Yield places of wrong lengths: pins of bodies, and with a cam all parameters in metres."""

    def scale_parameter(name: str, now: Recording, share: float) -> Recording:
        scene: Any = now.reference
        return replace(now, reference=scene.with_parameters(**{name: (1.0 + share) * scene.parameters[name]}))

    yield from _places_in_mechanism(_link_length_changes)(recording)
    scene = recording.reference
    if isinstance(scene, Scene) and scene.mechanism().cam_contacts:
        for name, fact in scene.parameter_facts().items():
            if fact.unit == "m" and scene.parameters[name]:
                yield name, partial(scale_parameter, name)


def mass_places(recording: Recording) -> Iterator[tuple[str, DefectFunction]]:
    """Yield the places of a wrong mass: all bodies."""

    def scale_mass(mechanism: Mechanism, name: str, share: float) -> Mechanism:
        bodies = [replace(b, mass=(1.0 + share) * b.mass) if b.name == name else b for b in mechanism.bodies]
        return replace(mechanism, bodies=tuple(bodies))

    places = _places_in_mechanism(
        lambda machine: ((body.name, partial(scale_mass, machine, body.name)) for body in machine.bodies)
    )
    yield from places(recording)


def find_other_assembly(reference: ExactReference) -> Kinematics | None:
    """Search for an assembly with an observed point elsewhere at all crank angles, or None."""
    healthy, mechanism = reference.kinematics, reference.mechanism()
    random, angles = np.random.default_rng(1), healthy.angles(36)
    shown = healthy.point_derivatives([healthy.poses(angles)])
    places = np.arange(healthy.start.size).reshape(-1, 3)[:, :2].ravel()
    for _ in range(ASSEMBLY_TRIES):
        poses = healthy.start.copy()
        poses[0, 2::3] += random.uniform(-math.pi, math.pi, len(mechanism.bodies))
        # With rotations given, positions follow by least squares; Newton iteration removes the rest.
        residual = healthy.residual([poses], np.zeros(1))[0]
        poses[0, places] -= np.linalg.lstsq(healthy.jacobian(poses)[0][:, places], residual)[0]
        rows = poses.reshape(-1, 3).tolist()
        guess: Any = {body.name: tuple(row) for body, row in zip(mechanism.bodies, rows, strict=True)}
        try:
            other = Kinematics(replace(mechanism, poses=guess))
            # The start alone is compared first: that needs no whole revolution.
            if all(
                _has_distant_point(other.point_derivatives([other.poses(at)]), shown, healthy.size)
                for at in (angles[:1], angles)
            ):
                return other
        except (InvalidInput, np.linalg.LinAlgError):
            continue
    return None


def _has_distant_point(points: Any, shown: Any, size: float) -> bool:
    """True if an observed point is off its healthy position at every crank angle.

    Args:
        points, shown: positions (T, 2) [m] by observed point, as `point_derivatives` returns them, of the other
            assembly and of the healthy one.
        size: size of the machine [m].
    """
    distances = [np.linalg.norm(at[0] - shown[name][0][: len(at[0])], axis=1).min() for name, at in points.items()]
    return bool(max(distances) >= MIN_POINT_DISTANCE * size)


# -- all defects -----------------------------------------------------------------------------------------------------

PERCENT = "%"
MOTION_DEFECTS = (
    Defect("length", PERCENT, 1e-4, 0.1, length_places),
    Defect("velocity stamped early", "steps", 0.5, 10.0, place_in_recording(_stamp_velocities_early)),
    Defect("gravity left in an acceleration", PERCENT, 1.0, 1.0, place_in_recording(_leave_gravity_in)),
    Defect("no number in a sample", "", 1.0, 1.0, place_in_recording(_insert_nan)),
    Defect("other branch", "", 1.0, 1.0, other_branch_place),
    Defect("run cut short", "", 0.1, 0.1, place_in_recording(_cut_end)),
)
MASS_DEFECT = Defect("mass", PERCENT, 0.01, 0.9, mass_places)
