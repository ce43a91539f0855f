"""Checks of the pieces of a run that a plugin's engine yields: arrays, stamps, outcome."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

import numpy as np

from conrod.comparison.trajectory import (
    BodyStates,
    BodyTracks,
    Outcome,
    Piece,
    PointTracks,
    Settings,
    Track,
    Trajectory,
)
from conrod.engines.engine import Machine
from conrod.engines.plugin_values import (
    EngineFault,
    check_array,
    check_text,
    check_type,
    check_whole_number,
    one_line,
    refuse_unless,
)
from conrod.exact.motion import Array, Instants

Copied = TypeVar("Copied")

MAX_MISSING_SAMPLES = 4  # at the start of a run, which difference quotients leave out
MAX_STAMP_DEVIATION = 0.5  # of the distance of neighbouring stamps from a step, over the step
TRACK_QUANTITIES = ("position", "velocity", "acceleration")
CRANK_QUANTITIES = ("angle", "rate", "acceleration")
STATE_QUANTITIES = ("poses", "rates", "accelerations")


class PieceChecker:
    """Checks the pieces of one run: each for itself, and that it continues the one before.

    Args:
        engine, version, settings: engine and settings of the run; a piece must state the same engine.
        samples: number of samples of the whole run.
    """

    def __init__(
        self, engine: str, version: str, machine: Machine, settings: Settings, revolutions: float, samples: int
    ) -> None:
        self._names = tuple(point.name for point in machine.kinematics.mechanism.observed)
        self.columns = 3 * len(machine.kinematics.mechanism.bodies)
        self._machine, self._settings, self._step = machine, settings, settings.timestep
        self._identity, self._revolutions, self._samples = (engine, version), revolutions, samples
        self._last: dict[str, float] = {}  # stamp of each track's last sample
        self._missing: dict[str, int] = {}
        self.samples_taken = 0

    def check(self, piece: Any) -> Piece:
        """Return a copy of the piece, with the engine and settings that the run has.

        Raises:
            EngineFault: an array, stamp or outcome of the piece cannot be used; says which.
        """
        check_type(piece, Piece, "a piece of a run")
        found = check_type(piece.trajectory, Trajectory, "the trajectory of a piece")
        refuse_unless(found.engine == self._identity[0], f"a run of engine {one_line(repr(found.engine))}")
        outcome, reason = check_type(found.outcome, Outcome, "an outcome"), check_text(found.reason, "a reason")
        clock = check_array(piece.clock, "a clock", finite=outcome is Outcome.COMPLETED)
        first, count = check_whole_number(piece.first_step, "the number of a first step"), len(clock)
        refuse_unless(
            first == self.samples_taken, f"samples from {first} on after {self.samples_taken}: its pieces do not join"
        )
        refuse_unless(count > 0, "a piece without a sample")
        refuse_unless(
            first + count <= self._samples, f"{first + count} samples of the {self._samples} that were asked for"
        )
        self.samples_taken += count
        copied = TrackCopies(self, count, outcome is Outcome.COMPLETED)
        bodies = None if found.bodies is None and outcome is not Outcome.COMPLETED else copied.bodies(found.bodies)
        points = {name: copied.point(name, tracks) for name, tracks in dict(found.points).items()}
        if outcome is Outcome.COMPLETED:
            refuse_unless(
                set(points) == set(self._names), f"points {sorted(map(str, points))}, not {sorted(self._names)}"
            )
            if (bad := copied.first_not_finite()) is not None:
                outcome, reason = Outcome.DIVERGED, f"not finite from {bad:.6g} s on"
        warnings = {
            check_text(name, "a warning"): check_whole_number(n, "a warning")
            for name, n in dict(piece.warnings).items()
        }
        torque = piece.drive_torque
        if torque is not None:
            torque = check_array(torque, "a drive torque", finite=outcome is Outcome.COMPLETED)
        trajectory = Trajectory(
            *self._identity, self._settings, self._machine.speed, self._revolutions, outcome, reason, points, bodies
        )
        return Piece(trajectory, first, clock, warnings, torque)

    def check_stamps(self, track: str, stamps: Array, count: int) -> None:
        """Raise EngineFault if stamps of a track are out of order, or leave samples out."""
        self._missing[track] = self._missing.get(track, 0) + count - len(stamps)
        refuse_unless(len(stamps) <= count, f"{len(stamps)} samples of {track} in a piece of {count}")
        refuse_unless(
            self._missing[track] <= MAX_MISSING_SAMPLES, f"{track} with {self._missing[track]} samples too few"
        )
        if len(stamps) == 0:
            return
        steps = np.diff(stamps, prepend=self._last.get(track, stamps[0] - self._step))
        self._last[track] = float(stamps[-1])
        if not (np.abs(steps / self._step - 1.0) <= MAX_STAMP_DEVIATION).all():
            bad = int(np.argmax(np.abs(steps / self._step - 1.0) > MAX_STAMP_DEVIATION))
            raise EngineFault(
                f"it handed over stamps of {track} that are {steps[bad]:g} s apart at {stamps[bad]:g} s, "
                f"where a step is {self._step:g} s"
            )


class TrackCopies:
    """Copies the tracks of a piece into conrod's own arrays; an object that two tracks share is copied once.

    Args:
        count: number of new samples in the piece.
        completed: whether the run has not failed so far; of a failed run only the shapes are checked.
    """

    def __init__(self, checker: PieceChecker, count: int, completed: bool) -> None:
        self._checker, self._count, self._completed = checker, count, completed
        self._known: dict[tuple[str, int], Any] = {}
        self._states: list[tuple[Array, Array]] = []  # stamps and values

    def bodies(self, found: Any) -> BodyTracks:
        """Copy the states of the bodies at the instants of position, velocity and acceleration."""
        check_type(found, BodyTracks, "tracks of the bodies")
        return BodyTracks(
            *(
                self._copy_once(self._copy_body_states, getattr(found, q), f"{q} of the bodies")
                for q in TRACK_QUANTITIES
            )
        )

    def point(self, name: Any, found: Any) -> PointTracks:
        """Copy position, velocity and acceleration of an observed point."""
        text = check_text(name, "the name of a point")
        check_type(found, PointTracks, f"tracks of {text}")
        return PointTracks(
            *(self._copy_once(self._copy_track, getattr(found, q), f"{q} of {text}") for q in TRACK_QUANTITIES)
        )

    def first_not_finite(self) -> float | None:
        """Stamp [s] of the first sample with a value that is not finite, or None."""
        bad = [at[~np.isfinite(v).reshape(len(v), -1).all(axis=1)] for at, v in self._states]
        return min((float(at[0]) for at in bad if len(at)), default=None)

    def _copy_once(self, make: Callable[[Any, str], Copied], found: Any, what: str) -> Copied:
        """Copy an object at its first use, and return the same copy later."""
        key = make.__name__, id(found)
        if key not in self._known:
            self._known[key] = make(found, what)
        made: Copied = self._known[key]
        return made

    def _copy_instants(self, found: Any, what: str) -> Instants:
        """Copy the stamps of a track, with the crank's angle, rate and acceleration."""
        check_type(found, Instants, f"instants of {what}")
        times = check_array(found.times, f"stamps of {what}", finite=self._completed)
        others = [
            check_array(getattr(found, one), f"the crank's {one} of {what}", finite=False) for one in CRANK_QUANTITIES
        ]
        for one, values in zip(CRANK_QUANTITIES, others, strict=True):
            refuse_unless(
                len(values) == len(times), f"the crank's {one} of {what}: {len(values)} for {len(times)} stamps"
            )
            self._states.append((times, values))
        if self._completed:
            self._checker.check_stamps(what, times, self._count)
        return Instants(times, *others)

    def _copy_values(self, at: Instants, values: Any, what: str, columns: int) -> Array:
        """Copy the values of a track (T, columns), one row per stamp."""
        copy = check_array(values, what, columns, finite=False)
        refuse_unless(len(copy) == len(at.times), f"{what}: {len(copy)} samples for {len(at.times)} stamps")
        self._states.append((at.times, copy))
        return copy

    def _copy_track(self, found: Any, what: str) -> Track:
        """Copy the motion of a point, values (T, 2)."""
        check_type(found, Track, what)
        at: Instants = self._copy_once(self._copy_instants, found.instants, what)
        return Track(at, self._copy_values(at, found.values, what, 2))

    def _copy_body_states(self, found: Any, what: str) -> BodyStates:
        """Copy poses, rates and accelerations of the bodies, (T, 3 n) each."""
        check_type(found, BodyStates, what)
        at: Instants = self._copy_once(self._copy_instants, found.instants, what)
        values = {one: (getattr(found, one), f"{one} at the {what}") for one in STATE_QUANTITIES}
        return BodyStates(at, *(self._copy_values(at, *named, self._checker.columns) for named in values.values()))
