"""The door for the pieces of a run: an engine's arrays, stamps and outcome, as conrod's own."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

import numpy as np

from conrod.engines.door import EngineFault, array_of, count_of, demand, one_line, text_of, typed
from conrod.engines.engine import Machine
from conrod.exact.motion import Array
from conrod.runs.trajectory import (
    BodyStates,
    BodyTracks,
    Instants,
    Outcome,
    Piece,
    PointTracks,
    Settings,
    Track,
    Trajectory,
)

Kind = TypeVar("Kind")

MISSING = 4  # samples at most at the start of a run that a difference quotient leaves out
STEP_OFF = 0.5  # of a step that two neighbouring stamps may be off
TRACKS = ("position", "velocity", "acceleration")
CRANK = ("angle", "rate", "acceleration")
POSES = ("poses", "rates", "accelerations")


class PieceDoor:
    """The door for the pieces of one run, which have to join.

    Args:
        engine, version, settings: that the trajectory is to name.
        samples: of the whole run.
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
        self.taken = 0

    def check(self, piece: Any) -> Piece:
        """The piece as one of conrod's own arrays, with the identity that the run has.

        Raises:
            EngineFault: what cannot be used of it.
        """
        typed(piece, Piece, "a piece of a run")
        found = typed(piece.trajectory, Trajectory, "the trajectory of a piece")
        demand(found.engine == self._identity[0], f"a run of engine {one_line(repr(found.engine))}")
        outcome, reason = typed(found.outcome, Outcome, "an outcome"), text_of(found.reason, "a reason")
        clock = array_of(piece.clock, "a clock", finite=outcome is Outcome.COMPLETED)
        first, count = count_of(piece.first_step, "the number of a first step"), len(clock)
        demand(first == self.taken, f"samples from {first} on after {self.taken}: its pieces do not join")
        demand(count > 0, "a piece without a sample")
        demand(first + count <= self._samples, f"{first + count} samples of the {self._samples} that were asked for")
        self.taken += count
        copied = Copies(self, count, outcome is Outcome.COMPLETED)
        bodies = None if found.bodies is None and outcome is not Outcome.COMPLETED else copied.bodies(found.bodies)
        points = {name: copied.point(name, tracks) for name, tracks in dict(found.points).items()}
        if outcome is Outcome.COMPLETED:
            demand(set(points) == set(self._names), f"points {sorted(map(str, points))}, not {sorted(self._names)}")
            if (bad := copied.first_not_finite()) is not None:
                outcome, reason = Outcome.DIVERGED, f"not finite from {bad:.6g} s on"
        warnings = {text_of(name, "a warning"): count_of(n, "a warning") for name, n in dict(piece.warnings).items()}
        torque = piece.drive_torque
        if torque is not None:
            torque = array_of(torque, "a drive torque", finite=outcome is Outcome.COMPLETED)
        trajectory = Trajectory(
            *self._identity, self._settings, self._machine.speed, self._revolutions, outcome, reason, points, bodies
        )
        return Piece(trajectory, first, clock, warnings, torque)

    def check_stamps(self, track: str, stamps: Array, count: int) -> None:
        """Refuse stamps of a track that are out of order, or leave samples out."""
        self._missing[track] = self._missing.get(track, 0) + count - len(stamps)
        demand(len(stamps) <= count, f"{len(stamps)} samples of {track} in a piece of {count}")
        demand(self._missing[track] <= MISSING, f"{track} with {self._missing[track]} samples too few")
        if len(stamps) == 0:
            return
        steps = np.diff(stamps, prepend=self._last.get(track, stamps[0] - self._step))
        self._last[track] = float(stamps[-1])
        if not (np.abs(steps / self._step - 1.0) <= STEP_OFF).all():
            bad = int(np.argmax(np.abs(steps / self._step - 1.0) > STEP_OFF))
            raise EngineFault(
                f"it handed over stamps of {track} that are {steps[bad]:g} s apart at {stamps[bad]:g} s, "
                f"where a step is {self._step:g} s"
            )


class Copies:
    """Copies of the tracks of a piece, of arrays of conrod's own; what is one object stays one.

    Args:
        count: new samples in the piece.
        completed: whether the run is in one piece so far; of one that failed only the shapes are checked.
    """

    def __init__(self, door: PieceDoor, count: int, completed: bool) -> None:
        self._door, self._count, self._completed = door, count, completed
        self._known: dict[tuple[str, int], Any] = {}
        self._states: list[tuple[Array, Array]] = []  # stamps and values

    def bodies(self, found: Any) -> BodyTracks:
        typed(found, BodyTracks, "tracks of the bodies")
        return BodyTracks(*(self._once(self._body_states, getattr(found, q), f"{q} of the bodies") for q in TRACKS))

    def point(self, name: Any, found: Any) -> PointTracks:
        text = text_of(name, "the name of a point")
        typed(found, PointTracks, f"tracks of {text}")
        return PointTracks(*(self._once(self._track, getattr(found, q), f"{q} of {text}") for q in TRACKS))

    def first_not_finite(self) -> float | None:
        """Stamp [s] of the first sample with a value that is not finite; None where there is none."""
        bad = [at[~np.isfinite(v).reshape(len(v), -1).all(axis=1)] for at, v in self._states]
        return min((float(at[0]) for at in bad if len(at)), default=None)

    def _once(self, make: Callable[[Any, str], Kind], found: Any, what: str) -> Kind:
        key = make.__name__, id(found)
        if key not in self._known:
            self._known[key] = make(found, what)
        made: Kind = self._known[key]
        return made

    def _instants(self, found: Any, what: str) -> Instants:
        typed(found, Instants, f"instants of {what}")
        times = array_of(found.times, f"stamps of {what}", finite=self._completed)
        others = [array_of(getattr(found, one), f"the crank's {one} of {what}", finite=False) for one in CRANK]
        for one, values in zip(CRANK, others, strict=True):
            demand(len(values) == len(times), f"the crank's {one} of {what}: {len(values)} for {len(times)} stamps")
            self._states.append((times, values))
        if self._completed:
            self._door.check_stamps(what, times, self._count)
        return Instants(times, *others)

    def _valued(self, at: Instants, values: Any, what: str, columns: int) -> Array:
        copy = array_of(values, what, columns, finite=False)
        demand(len(copy) == len(at.times), f"{what}: {len(copy)} samples for {len(at.times)} stamps")
        self._states.append((at.times, copy))
        return copy

    def _track(self, found: Any, what: str) -> Track:
        typed(found, Track, what)
        at: Instants = self._once(self._instants, found.instants, what)
        return Track(at, self._valued(at, found.values, what, 2))

    def _body_states(self, found: Any, what: str) -> BodyStates:
        typed(found, BodyStates, what)
        at: Instants = self._once(self._instants, found.instants, what)
        values = {one: (getattr(found, one), f"{one} at the {what}") for one in POSES}
        return BodyStates(at, *(self._valued(at, *named, self._door.columns) for named in values.values()))
