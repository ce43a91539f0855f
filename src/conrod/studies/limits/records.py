"""Records of a run at an engine's limits beside its errors, and its grade: to rely on, rough, wrong, or none at all.

And whether anything shows it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum

from conrod.runs.plain_values import restore
from conrod.runs.trajectory import Outcome
from conrod.studies.frame.case import Measurement


@dataclass(frozen=True)
class Flight:
    """A stretch in which a follower is off its cam.

    Attributes:
        start, landing: crank angles [rad].
    """

    start: float
    landing: float

    @property
    def length(self) -> float:
        """Angle that the crank turns through [rad]."""
        return abs(self.landing - self.start)


@dataclass(frozen=True)
class Extremes:
    """Record of a run, which a ledger keeps beside its errors.

    Attributes:
        samples: how many were recorded and compared.
        finite: whether all poses and rates of the bodies and the motion of the observed points were.
        warnings: what the engine itself warned of, and how often.
        torque: largest error of the drive torque over its exact peak, from the second sample on: at the first one an
            iterative solver has nothing to start from; None where the engine does not report it.
        penetration: how deep a follower sinks into its cam while it is held [m]; None without a cam.
        flights: of each follower off its cam, the longest.
        fingerprint: of the same numbers, to the last bit.
        again: the same of further runs, see `conrod.studies.limits.determinism`.
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
    def of(cls, measurement: Measurement) -> Extremes:
        """Return what was recorded of a measured run; no sample where it ended before anything could be."""
        nothing = cls(0, True, {}, None, None, (), "")
        return nothing if measurement.extremes is None else restore(cls, measurement.extremes)


# -- grades ----------------------------------------------------------------------------------------------------------

SAFE_ERROR, ROUGH_ERROR = 0.01, 0.1  # of the travel, largest position error

# Ends that nobody overlooks: there is no trajectory, or none was begun.
LOUD = {o.slug for o in (Outcome.CRASHED, Outcome.TIMED_OUT, Outcome.OUT_OF_MEMORY, Outcome.UNSUPPORTED)}
# Ends after which the state is nowhere near the machine any more, or no state at all.
UNBOUNDED = LOUD | {o.slug for o in (Outcome.DIVERGED, Outcome.EXPLODED, Outcome.RESET)}


class Level(Enum):
    """From good to bad; the texts are for people."""

    SAFE = ("safe", f"position within {100 * SAFE_ERROR:g} % of the travel")
    ROUGH = ("rough", f"position within {100 * ROUGH_ERROR:g} % of the travel")
    WRONG = ("wrong", "in one piece, but further off than that")
    BROKEN = ("broken", "no longer the machine: it came apart, flipped, let go of its cam, ..")
    UNBOUNDED = ("unbounded", "blown up, reset, crashed or never ended")

    def __init__(self, slug: str, meaning: str) -> None:
        self.slug = slug
        self.meaning = meaning


LEVELS = [level.slug for level in Level]
GOOD = (Level.SAFE.slug, Level.ROUGH.slug)


def level_of(measurement: Measurement) -> Level:
    """Return the level of a measured run."""
    if measurement.outcome in UNBOUNDED:
        return Level.UNBOUNDED
    error = measurement.largest("position")
    if error is None:
        return Level.BROKEN
    return Level.SAFE if error <= SAFE_ERROR else Level.ROUGH if error <= ROUGH_ERROR else Level.WRONG


def is_undetected(measurement: Measurement) -> bool:
    """Return whether a run is worse than rough, and neither a number that is not finite nor a warning shows it."""
    recorded = Extremes.of(measurement)
    if level_of(measurement).slug in GOOD or measurement.outcome in LOUD:
        return False
    return recorded.samples > 0 and recorded.finite and not recorded.warnings
