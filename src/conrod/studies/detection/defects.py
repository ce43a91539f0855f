"""Defects that are planted into a recorded run: in what was recorded, or in the machine that it is compared with."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from conrod.exact.motion import Array
from conrod.runs.trajectory import BodyStates, BodyTracks, FieldByField, Instants, Piece, PointTracks, Track
from conrod.studies.detection.machine_defects import (
    Plant,
    Plants,
    Recording,
    another_assembly,
    lengths,
    masses,
    softness,
)


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


def _on_run(change: Callable[[Recording, float], Piece]) -> Plants:
    return lambda _: iter([("", lambda given, size: replace(given, run=change(given, size)))])


def _with_tracks(run: Piece, quantity: str, change: Callable[[str, Track], Track], which: int | None = None) -> Piece:
    """The run with other samples of a quantity, of one observed point or of all."""
    points = dict(run.trajectory.points)
    for name in list(points)[slice(which, None if which is None else which + 1)]:
        points[name] = replace(points[name], **{quantity: change(name, getattr(points[name], quantity))})
    return replace(run, trajectory=replace(run.trajectory, points=points))


def _with_instants(run: Piece, change: Callable[[Instants], Instants]) -> Piece:
    """The run with all instants changed; what shares them goes on sharing them."""
    known: dict[int, Any] = {}

    def changed(part: Any) -> Any:
        if id(part) not in known:
            known[id(part)] = change(part) if isinstance(part, Instants) else _rebuilt(part)
        return known[id(part)]

    def _rebuilt(part: Any) -> Any:
        parts = {name: one for name, one in vars(part).items() if not isinstance(one, np.ndarray)}
        return replace(part, **{name: changed(one) for name, one in parts.items()})

    trajectory = run.trajectory
    points = {name: changed(tracks) for name, tracks in trajectory.points.items()}
    bodies = trajectory.bodies and changed(trajectory.bodies)
    return replace(run, trajectory=replace(trajectory, points=points, bodies=bodies))


def _stamped_early(given: Recording, steps: float) -> Piece:
    """Velocities that are said to be of an instant before their own."""
    by = steps * given.run.trajectory.settings.timestep

    def early(_: str, track: Track) -> Track:
        at = track.instants
        return replace(track, instants=replace(at, times=at.times - by, angle=at.angle - by * at.rate))

    return _with_tracks(given.run, "velocity", early)


def _slow_clock(given: Recording, share: float) -> Piece:
    return _with_instants(given.run, lambda at: replace(at, times=(1.0 - share) * at.times))


def _sign(given: Recording, share: float) -> Piece:
    """Velocities along x or y, whichever is larger, by so much of the way to the other sign."""

    def swapped(_: str, track: Track) -> Track:
        axis = int(np.ptp(track.values, axis=0).argmax())
        values = track.values.copy()
        values[:, axis] *= 1.0 - 2.0 * share
        return replace(track, values=values)

    return _with_tracks(given.run, "velocity", swapped)


def _missing_term(given: Recording) -> Iterator[tuple[str, Plant]]:
    """Accelerations without the centripetal term of their point about its body's centre of gravity."""
    mechanism = given.reference.mechanism()
    for which, observed in enumerate(mechanism.observed):
        i, centre = 3 * mechanism.body_index[observed.body], mechanism.body(observed.body).centre_of_gravity
        arm = np.subtract(observed.point, centre)

        def without(now: Recording, share: float, i: int = i, arm: Array = arm, which: int = which) -> Recording:
            def left(_: str, track: Track) -> Track:
                poses, slopes = now.reference.kinematics.derivatives(track.instants.angle, 1)
                c, s = np.cos(poses[:, i + 2]), np.sin(poses[:, i + 2])
                out = np.column_stack([c * arm[0] - s * arm[1], s * arm[0] + c * arm[1]])
                spin = slopes[:, i + 2] * track.instants.rate
                return replace(track, values=track.values + share * spin[:, None] ** 2 * out)

            return replace(now, run=_with_tracks(now.run, "acceleration", left, which))

        if arm.any():
            yield observed.name, without


def _cut_short(given: Recording, share: float) -> Piece:
    """Without so much of its end, and said to be whole."""
    run, samples = given.run, len(given.run.clock)
    kept = samples - math.ceil(share * samples - 1e-9)
    cut = FieldByField(lambda parts: parts[0][: max(2, kept - samples + len(parts[0]))])
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


# -- all of them -----------------------------------------------------------------------------------------------------

PERCENT = "%"
MOTION = (
    Defect("length", PERCENT, 1e-4, 0.1, lengths),
    Defect("velocity stamped early", "steps", 0.5, 10.0, _on_run(_stamped_early)),
    Defect("time step", PERCENT, 1e-4, 1.0, _on_run(_slow_clock)),
    Defect("sign of a velocity", "% of the way", 1.0, 1.0, _on_run(_sign)),
    Defect("missing term of an acceleration", PERCENT, 1.0, 1.0, _missing_term),
    Defect("softness", "steps", 20.0, 1000.0, softness),
    Defect("other branch", "", 1.0, 1.0, _other_branch),
    Defect("run cut short", "", 0.1, 0.1, _on_run(_cut_short)),
)
MASS = Defect("mass", PERCENT, 0.01, 0.9, masses)
