"""Defects that `conrod validate --qualify` plants: in what was recorded, or in the machine that it is compared with.

A run of a right model against a machine with a longer rod is as far off as one of a wrong model against the right
machine, and needs no run of its own.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, Self

import numpy as np

from conrod.engines.engine import Engine
from conrod.errors import InvalidInput
from conrod.exact import ExactReference, GenericReference
from conrod.exact.kinematics import Kinematics
from conrod.mechanism.mechanism import Mechanism, Point, Revolute
from conrod.runs.trajectory import (
    ArrayMapper,
    BodyStates,
    BodyTracks,
    Instants,
    Piece,
    PointTracks,
    Track,
    concatenate_pieces,
)
from conrod.scenes import Scene

ASSEMBLIES, APART = 40, 0.01  # starts from which another assembly is looked for; of the size, how far it is off
FREE_FALL = (0.0, -9.81)  # [m/s^2]


@dataclass(frozen=True)
class Recording:
    """A run as it was recorded, and the machine that it is compared with."""

    run: Piece
    reference: ExactReference

    @classmethod
    def of(cls, engine: Engine[Any], scene: ExactReference, settings: Any, turns: float, start_angle: float) -> Self:
        """The run of an engine, as one piece."""
        steps = max(round(settings.steps_per_revolution * turns), 1)
        return cls(concatenate_pieces(list(engine.run(scene, settings, turns, start_angle, steps))), scene)


Plant = Callable[[Recording, float], Recording]
Plants = Callable[[Recording], Iterator[tuple[str, Plant]]]  # by where they are planted; none where there is no place


@dataclass(frozen=True)
class Defect:
    """One kind of defect.

    Attributes:
        unit: of its size, in words; empty where it has none.
        size: that `--qualify` plants; smaller and larger ones are found by bisection.
        largest: size up to which it is looked for.
        plants: by where they are planted, of a run; none where the machine has no such place.
    """

    name: str
    unit: str
    size: float
    largest: float
    plants: Plants


# -- changes of what was recorded --------------------------------------------------------------------------------------


def on_run(change: Callable[[Recording, float], Piece]) -> Plants:
    """Plants of a change of what was recorded, in one place."""
    return lambda _: iter([("", lambda given, size: replace(given, run=change(given, size)))])


def with_tracks(run: Piece, quantity: str, change: Callable[[str, Track], Track], which: int | None = None) -> Piece:
    """The run with other samples of a quantity, of one observed point or of all."""
    points = dict(run.trajectory.points)
    for name in list(points)[slice(which, None if which is None else which + 1)]:
        points[name] = replace(points[name], **{quantity: change(name, getattr(points[name], quantity))})
    return replace(run, trajectory=replace(run.trajectory, points=points))


def _stamped_early(given: Recording, steps: float) -> Piece:
    """Velocities that are said to be of an instant before their own."""
    by = steps * given.run.trajectory.settings.timestep

    def early(_: str, track: Track) -> Track:
        at = track.instants
        return replace(track, instants=replace(at, times=at.times - by, angle=at.angle - by * at.rate))

    return with_tracks(given.run, "velocity", early)


def _left_gravity(given: Recording, share: float) -> Piece:
    """Accelerations as an accelerometer tells them, without free fall."""
    return with_tracks(
        given.run, "acceleration", lambda _, track: replace(track, values=track.values - share * np.array(FREE_FALL))
    )


def _no_number(given: Recording, _: float) -> Piece:
    """A position in the middle that is no number."""

    def spoilt(_: str, track: Track) -> Track:
        values = track.values.copy()
        values[len(values) // 2] = math.nan
        return replace(track, values=values)

    return with_tracks(given.run, "position", spoilt)


def _cut_short(given: Recording, share: float) -> Piece:
    """Without so much of its end, and said to be whole."""
    run, samples = given.run, len(given.run.clock)
    kept = samples - math.ceil(share * samples - 1e-9)
    cut = ArrayMapper(lambda parts: parts[0][: max(2, kept - samples + len(parts[0]))])
    trajectory = run.trajectory
    points = {name: cut(tracks) for name, tracks in trajectory.points.items()}
    bodies = trajectory.bodies and cut(trajectory.bodies)
    return replace(run, clock=run.clock[:kept], trajectory=replace(trajectory, points=points, bodies=bodies))


def _other_branch(given: Recording) -> Iterator[tuple[str, Plant]]:
    """The run of the machine put together in another way; of a machine that has one."""
    other = another_assembly(given.reference)
    if other is None:
        return

    def states(at: Instants) -> BodyStates:
        poses, slopes, bends = other.derivatives(at.angle, 2)
        rate, turn = at.rate[:, None], at.acceleration[:, None]
        return BodyStates(at, poses, slopes * rate, bends * rate**2 + slopes * turn)

    def flipped(now: Recording, _: float) -> Recording:
        tracks = next(iter(now.run.trajectory.points.values()))
        three = [states(one.instants) for one in (tracks.position, tracks.velocity, tracks.acceleration)]
        told = [other.point_derivatives([one.poses, one.rates, one.accelerations]) for one in three]
        points = {
            name: PointTracks(
                *(Track(at.instants, one[name][k]) for k, (at, one) in enumerate(zip(three, told, strict=True)))
            )
            for name in now.run.trajectory.points
        }
        bodies = now.run.trajectory.bodies and BodyTracks(*three)
        trajectory = replace(now.run.trajectory, points=points, bodies=bodies)
        return replace(now, run=replace(now.run, trajectory=trajectory))

    yield "", flipped


# -- the machine that it is compared with -----------------------------------------------------------------------------


def _machines(places: Callable[[Mechanism], Iterator[tuple[str, Callable[[float], Mechanism]]]]) -> Plants:
    """Plants of changed mechanisms, by the generic solver."""

    def plant(changed: Callable[[float], Mechanism], given: Recording, size: float) -> Recording:
        return replace(given, reference=GenericReference(changed(size), given.reference.speed))

    return lambda given: ((where, partial(plant, one)) for where, one in places(given.reference.mechanism()))


def _with_place(mechanism: Mechanism, name: str, end: str, at: Any, by: Any, size: float) -> Mechanism:
    """The mechanism with the point at one end of a joint moved from a place by so many times a way."""
    change: Any = {end: tuple((np.asarray(at) + size * np.asarray(by)).tolist())}
    joints = tuple(replace(joint, **change) if joint.name == name else joint for joint in mechanism.joints)
    return replace(mechanism, joints=joints)


def _links(mechanism: Mechanism) -> Iterator[tuple[str, Callable[[float], Mechanism]]]:
    """Distances of the pins of each link, the crank too, from its first one."""
    for body in mechanism.bodies:
        ends = [(j, "point_a" if j.a == body.name else "point_b") for j in mechanism.joints_on(body.name)]
        pins: list[tuple[str, str, Point]] = [
            (joint.name, end, getattr(joint, end)) for joint, end in ends if isinstance(joint, Revolute)
        ]
        for name, end, place in pins[1:]:
            way = np.subtract(place, pins[0][2])
            if way.any():
                yield body.name, partial(_with_place, mechanism, name, end, place, way)


def lengths(given: Recording) -> Iterator[tuple[str, Plant]]:
    """Lengths of links, and of a machine with a cam all lengths that the scene names."""

    def scaled(name: str, now: Recording, share: float) -> Recording:
        scene: Any = now.reference
        return replace(now, reference=scene.with_parameters(**{name: (1.0 + share) * scene.parameters[name]}))

    yield from _machines(_links)(given)
    scene = given.reference
    if isinstance(scene, Scene) and scene.mechanism().cam_contacts:
        for name, fact in scene.parameter_facts().items():
            if fact.unit == "m" and scene.parameters[name]:
                yield name, partial(scaled, name)


def masses(given: Recording) -> Iterator[tuple[str, Plant]]:
    """The mass of each body."""

    def changed(mechanism: Mechanism, name: str, share: float) -> Mechanism:
        bodies = [replace(b, mass=(1.0 + share) * b.mass) if b.name == name else b for b in mechanism.bodies]
        return replace(mechanism, bodies=tuple(bodies))

    places = _machines(lambda machine: ((body.name, partial(changed, machine, body.name)) for body in machine.bodies))
    yield from places(given)


def another_assembly(reference: ExactReference) -> Kinematics | None:
    """The machine put together so that an observed point stands elsewhere all along, if that can be; else None."""
    healthy, mechanism = reference.kinematics, reference.mechanism()
    chance, angles = np.random.default_rng(1), healthy.angles(36)
    shown = healthy.point_derivatives([healthy.poses(angles)])
    places = np.arange(healthy.start.size).reshape(-1, 3)[:, :2].ravel()
    for _ in range(ASSEMBLIES):
        poses = healthy.start.copy()
        poses[0, 2::3] += chance.uniform(-math.pi, math.pi, len(mechanism.bodies))
        # With the turns given, places follow from the joints: what does not fit is left to Newton's iteration.
        left = healthy.residual([poses], np.zeros(1))[0]
        poses[0, places] -= np.linalg.lstsq(healthy.jacobian(poses)[0][:, places], left)[0]
        rows = poses.reshape(-1, 3).tolist()
        guess: Any = {body.name: tuple(row) for body, row in zip(mechanism.bodies, rows, strict=True)}
        try:
            other = Kinematics(replace(mechanism, poses=guess))
            # Where it stands at the start is known without its whole turn.
            if all(
                _apart(other.point_derivatives([other.poses(at)]), shown, healthy.size) for at in (angles[:1], angles)
            ):
                return other
        except (InvalidInput, np.linalg.LinAlgError):
            continue
    return None


def _apart(points: Any, shown: Any, size: float) -> bool:
    """True if a point keeps away from where it was shown."""
    apart = [np.linalg.norm(at[0] - shown[name][0][: len(at[0])], axis=1).min() for name, at in points.items()]
    return bool(max(apart) >= APART * size)


# -- all of them -----------------------------------------------------------------------------------------------------

PERCENT = "%"
MOTION = (
    Defect("length", PERCENT, 1e-4, 0.1, lengths),
    Defect("velocity stamped early", "steps", 0.5, 10.0, on_run(_stamped_early)),
    Defect("gravity left in an acceleration", PERCENT, 1.0, 1.0, on_run(_left_gravity)),
    Defect("no number in a sample", "", 1.0, 1.0, on_run(_no_number)),
    Defect("other branch", "", 1.0, 1.0, _other_branch),
    Defect("run cut short", "", 0.1, 0.1, on_run(_cut_short)),
)
MASS = Defect("mass", PERCENT, 0.01, 0.9, masses)
