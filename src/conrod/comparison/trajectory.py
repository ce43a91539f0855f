"""The trajectory of a run: sampled motion, each quantity with its instants, and the outcome."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from enum import Enum
from typing import Any, Protocol, Self, TypeVar

import numpy as np

from conrod.errors import Named
from conrod.exact.motion import QUANTITIES, Array, Instants

COMPARED_QUANTITIES = (*QUANTITIES, "total")  # of a point; the last is its position at the nominal time


class Outcome(Enum):
    """The outcome of a run: a slug for data, and a meaning for people."""

    COMPLETED = ("completed", "ran to its end")
    DIVERGED = ("diverged", "a state is not finite")
    EXPLODED = ("exploded", "finite, but far out of reach of the mechanism")
    RESET = ("reset", "the engine put the state back by itself")
    FLIPPED = ("flipped", "closed, but on the other assembly branch")
    LOCKED = ("locked", "the crank stopped where the linkage cannot go on")
    OPENED = ("opened", "a joint came apart")
    LOST_CONTACT = ("lost-contact", "the follower left the cam")
    TUNNELLED = ("tunnelled", "the roller's centre is inside the cam")
    STALLED = ("stalled", "the drive did not keep its speed")
    CRASHED = ("crashed", "the process ended abnormally")
    TIMED_OUT = ("timed-out", "the run took longer than its limit")
    OUT_OF_MEMORY = ("out-of-memory", "the run needed more memory than its limit")
    UNSUPPORTED = ("unsupported", "the engine or the preset cannot do this")

    slug: str
    meaning: str

    def __new__(cls, slug: str, meaning: str) -> Self:
        made = object.__new__(cls)
        made._value_ = made.slug = slug
        made.meaning = meaning
        return made

    @classmethod
    def from_slug(cls, slug: str) -> Outcome:
        """The outcome with a slug; raises KeyError for an unknown slug."""
        return {member.slug: member for member in cls}[slug]


@dataclass(frozen=True)
class Track:
    """Samples of one quantity of one point, with the instants that they belong to."""

    instants: Instants
    values: Array  # (T, 2), SI


@dataclass(frozen=True)
class PointTracks:
    """Measured motion of one observed point."""

    position: Track
    velocity: Track
    acceleration: Track


@dataclass(frozen=True)
class BodyStates:
    """States of all bodies at the same instants; (T, 3 n) [m, m, rad], stacked as in `Mechanism.bodies`."""

    instants: Instants
    poses: Array
    rates: Array
    accelerations: Array


@dataclass(frozen=True)
class BodyTracks:
    """States of the bodies at the instants that positions, velocities and accelerations belong to.

    An engine that gives the three at one instant has one object for them. A state holds all three quantities; those
    that do not belong to its instants are second-order accurate, and serve the comparison of the quantity that does.
    """

    position: BodyStates
    velocity: BodyStates
    acceleration: BodyStates


class Settings(Protocol):
    """The settings of an engine, as conrod uses them outside the engine."""

    @property
    def engine(self) -> str: ...  # name in the table of engines
    @property
    def preset(self) -> str: ...  # name of the preset they come from, or 'custom'
    @property
    def steps_per_revolution(self) -> int: ...  # time steps in one turn of the crank
    @property
    def timestep(self) -> float: ...  # length of a step [s]
    # Time [s] in which what closes the joints, or a contact, mends an error; 0 where it does so at once.
    def time_constant(self, contact: bool) -> float: ...
    # All fields as plain values, but for those added later where they have the value of all runs before.
    def as_dict(self) -> dict[str, Any]: ...


@dataclass(frozen=True)
class Trajectory:
    """A run, sampled at every step.

    An outcome other than completed has no samples to compare: `points` and `bodies` are then what was recorded,
    for inspection only.
    """

    engine: str
    engine_version: str
    settings: Settings
    speed: float  # [rad/s], nominal
    revolutions: float
    outcome: Outcome
    reason: str  # details of the outcome, empty when completed
    points: Mapping[str, PointTracks]
    bodies: BodyTracks | None

    def __post_init__(self) -> None:
        object.__setattr__(self, "points", Named(self.points, "observed point"))


@dataclass(frozen=True)
class Piece:
    """A part of a run with all its samples; the run itself may be of any length.

    Attributes:
        trajectory: trajectory of this part, with the outcome and reason of the run so far.
        first_step: index of its first new sample; earlier samples, which derivatives need, are new in no other piece.
        clock: of the engine, or of a user of an engine that has none: the sum of its steps so far, at the instants of
            the positions (T,) [s].
        warnings: the engine's own warnings so far, with their numbers.
        drive_torque: as the engine reports it, at the instants of the accelerations (T,) [N m], about the crank in the
            sense of the crank angle; None if it reports none.
    """

    trajectory: Trajectory
    first_step: int
    clock: Array
    warnings: Mapping[str, int]
    drive_torque: Array | None


Part = TypeVar("Part", Instants, Track, PointTracks, BodyStates, BodyTracks)


def concatenate_pieces(pieces: Sequence[Piece]) -> Piece:
    """Concatenate the samples of several pieces; outcome and warnings come from the last one."""
    if len(pieces) == 1:
        return pieces[0]
    first, last, join = pieces[0], pieces[-1], ArrayMapper(np.concatenate)
    bodies = [piece.trajectory.bodies for piece in pieces]
    points = {name: join(*(piece.trajectory.points[name] for piece in pieces)) for name in last.trajectory.points}
    torques = [piece.drive_torque for piece in pieces]
    return replace(
        last,
        trajectory=replace(last.trajectory, points=points, bodies=join(*(b for b in bodies if b is not None))),
        first_step=first.first_step,
        clock=np.concatenate([piece.clock for piece in pieces]),
        drive_torque=None if last.drive_torque is None else np.concatenate([t for t in torques if t is not None]),
    )


class ArrayMapper:
    """Map a function over the arrays of tracks and states; parts that share arrays share them afterwards.

    Args:
        change: makes one array from the corresponding arrays of all parts.
    """

    def __init__(self, change: Callable[[Sequence[Array]], Array]) -> None:
        self._change = change
        self._known: dict[tuple[int, ...], Any] = {}

    def __call__(self, *parts: Part) -> Part:
        key = tuple(id(part) for part in parts)
        if key not in self._known:
            each: list[Any] = [[getattr(part, field.name) for part in parts] for field in fields(parts[0])]
            made: Any = type(parts[0])
            self._known[key] = made(*(self._change(v) if isinstance(v[0], np.ndarray) else self(*v) for v in each))
        found: Part = self._known[key]
        return found
