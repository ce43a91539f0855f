"""Records of a run at an engine's limits, its level, and whether a failure is undetected."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum

from conrod.comparison.plain_values import restore
from conrod.comparison.trajectory import Outcome
from conrod.execution.case import Measurement


@dataclass(frozen=True)
class Flight:
    """A flight of a follower off its cam.

    Attributes:
        start, landing: crank angles at its start and end [rad].
    """

    start: float
    landing: float

    @property
    def length(self) -> float:
        """Rotation of the crank during the flight [rad]."""
        return abs(self.landing - self.start)


@dataclass(frozen=True)
class Extremes:
    """Records of a run other than its errors, which a ledger keeps with them.

    Attributes:
        samples: number of recorded samples.
        finite: True if all poses and rates of the bodies and the motion of the observed points are finite.
        warnings: warnings of the engine, and how often each came.
        torque: largest error of the drive torque over its exact peak, without the first sample, where an iterative
            solver has no start values; None if the engine does not report the torque.
        penetration: penetration of a follower into its cam at the start [m]; None without a cam.
        flights: longest flight of each follower.
        fingerprint: hash of the recorded numbers, see `Fingerprint`.
        again: fingerprints of repeated runs, see `conrod.studies.limits.determinism`.
    """

    samples: int
    finite: bool
    warnings: Mapping[str, int]
    torque: float | None
    penetration: float | None
    flights: tuple[Flight, ...]
    fingerprint: str
    again: tuple[str, ...] = ()

    @classmethod
    def from_measurement(cls, measurement: Measurement) -> Extremes:
        """Return the records of a measured run; zero samples if it ended before the first."""
        nothing = cls(0, True, {}, None, None, (), "")
        return nothing if measurement.extremes is None else restore(cls, measurement.extremes)


# -- levels ----------------------------------------------------------------------------------------------------------

SAFE_ERROR, ROUGH_ERROR = 0.01, 0.1  # largest position error over the travel, of safe and of rough runs

# Outcomes without a trajectory, which nobody overlooks.
OBVIOUS_FAILURES = {o.slug for o in (Outcome.CRASHED, Outcome.TIMED_OUT, Outcome.OUT_OF_MEMORY, Outcome.UNSUPPORTED)}
# Outcomes after which the state is far from the machine, or missing.
UNBOUNDED_OUTCOMES = OBVIOUS_FAILURES | {o.slug for o in (Outcome.DIVERGED, Outcome.EXPLODED, Outcome.RESET)}


class Level(Enum):
    """Level of a run, from safe to unbounded, with its meaning for people."""

    SAFE = ("safe", f"position within {100 * SAFE_ERROR:g} % of the travel")
    ROUGH = ("rough", f"position within {100 * ROUGH_ERROR:g} % of the travel")
    WRONG = ("wrong", "in one piece, but further off than that")
    BROKEN = ("broken", "no longer the machine: it came apart, flipped, let go of its cam, ..")
    UNBOUNDED = ("unbounded", "blown up, reset, crashed or never ended")

    def __init__(self, slug: str, meaning: str) -> None:
        self.slug = slug
        self.meaning = meaning


LEVELS = [level.slug for level in Level]
GOOD_LEVELS = (Level.SAFE.slug, Level.ROUGH.slug)


def level_of(measurement: Measurement) -> Level:
    """Return the level of a measured run, from its outcome and position error."""
    if measurement.outcome in UNBOUNDED_OUTCOMES:
        return Level.UNBOUNDED
    error = measurement.largest("position")
    if error is None:
        return Level.BROKEN
    return Level.SAFE if error <= SAFE_ERROR else Level.ROUGH if error <= ROUGH_ERROR else Level.WRONG


def is_undetected(measurement: Measurement) -> bool:
    """Return True if a run is worse than rough with finite numbers and without a warning."""
    recorded = Extremes.from_measurement(measurement)
    if level_of(measurement).slug in GOOD_LEVELS or measurement.outcome in OBVIOUS_FAILURES:
        return False
    return recorded.samples > 0 and recorded.finite and not recorded.warnings
