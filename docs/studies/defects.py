"""Defects that `--qualify` does not plant: what else a verdict would notice, for `make detection`."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np

from conrod.comparison.trajectory import Piece, Track
from conrod.engines import engine_named
from conrod.engines.capabilities import MissingCapability, SettingsVariations, capability
from conrod.engines.engine import run_extent
from conrod.exact.motion import Array, Instants
from conrod.studies.detection.defects import (
    MASS_DEFECT,
    MOTION_DEFECTS,
    PERCENT,
    Defect,
    DefectFunction,
    Recording,
    change_tracks,
    place_in_recording,
)
from conrod.studies.detection.qualification import QualificationCase


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


def _slow_clock(given: Recording, share: float) -> Piece:
    return _with_instants(given.run, lambda at: replace(at, times=(1.0 - share) * at.times))


def _sign(given: Recording, share: float) -> Piece:
    """Velocities along x or y, whichever is larger, by so much of the way to the other sign."""

    def swapped(_: str, track: Track) -> Track:
        axis = int(np.ptp(track.values, axis=0).argmax())
        values = track.values.copy()
        values[:, axis] *= 1.0 - 2.0 * share
        return replace(track, values=values)

    return change_tracks(given.run, "velocity", swapped)


def _missing_term_places(given: Recording) -> Iterator[tuple[str, DefectFunction]]:
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

            return replace(now, run=change_tracks(now.run, "acceleration", left, which))

        if arm.any():
            yield observed.name, without


def _softness_places(given: Recording) -> Iterator[tuple[str, DefectFunction]]:
    """The run made again, with joints or contacts that take so many steps longer to mend an error."""
    trajectory = given.run.trajectory
    engine, settings = engine_named(trajectory.engine), trajectory.settings
    if isinstance(varied := capability(engine, SettingsVariations), MissingCapability):
        return
    timed: Any = settings
    own = timed.time_constant(bool(given.reference.mechanism().cam_contacts)) / timed.timestep

    def softer(now: Recording, steps: float) -> Recording:
        if steps == 0.0:
            return now
        machine: Any = now.reference
        start = run_extent(machine, settings.steps_per_revolution, trajectory.revolutions)[0]
        changed = varied.with_time_constant(machine, settings, own + abs(steps))
        return Recording.from_engine(engine, machine, changed, trajectory.revolutions, start)

    yield "", softer


MORE = (
    Defect("time step", PERCENT, 1e-4, 1.0, place_in_recording(_slow_clock)),
    Defect("sign of a velocity", "% of the way", 1.0, 1.0, place_in_recording(_sign)),
    Defect("missing term of an acceleration", PERCENT, 1.0, 1.0, _missing_term_places),
    Defect("softness", "steps", 20.0, 1000.0, _softness_places),
)


@dataclass(frozen=True)
class DetectionCase(QualificationCase):
    """A run of a scene in an engine with a preset, judged with every defect planted in it."""

    study: ClassVar[str] = "detection"
    defects: ClassVar[tuple[Defect, ...]] = (*MOTION_DEFECTS, *MORE, MASS_DEFECT)
