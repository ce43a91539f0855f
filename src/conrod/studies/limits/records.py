"""Records of a run at an engine's limits, its level, and whether a failure is undetected."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import Enum

from conrod.comparison.trajectory import Outcome
from conrod.execution.run import RunResult


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
class LimitResult(RunResult):
    """Result of a run at its engine's limits: its errors, and how it failed.

    Attributes:
        samples: number of recorded samples; 0 if the run ended before the first.
        finite: True if all poses and rates of the bodies and the motion of the observed points are finite.
        warnings: warnings of the engine, and how often each came.
        torque: largest error of the drive torque over its exact peak, without the first sample, where an iterative
            solver has no start values; None if the engine does not report the torque.
        penetration: penetration of a follower into its cam at the start [m]; None without a cam.
        flights: longest flight of each follower.
        fingerprint: hash of the recorded numbers, see `Fingerprint`; empty if there are none.
        again: fingerprints of repeated runs, see `conrod.studies.limits.determinism`.
    """

    samples: int = 0
    finite: bool = True
    warnings: Mapping[str, int] = field(default_factory=dict)
    torque: float | None = None
    penetration: float | None = None
    flights: tuple[Flight, ...] = ()
    fingerprint: str = ""
    again: tuple[str, ...] = ()


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


def level_of(result: LimitResult) -> Level:
    """Return the level of a run, from its outcome and position error."""
    if result.outcome in UNBOUNDED_OUTCOMES:
        return Level.UNBOUNDED
    error = result.largest("position")
    if error is None:
        return Level.BROKEN
    return Level.SAFE if error <= SAFE_ERROR else Level.ROUGH if error <= ROUGH_ERROR else Level.WRONG


def is_undetected(result: LimitResult) -> bool:
    """Return True if a run is worse than rough with finite numbers and without a warning."""
    if level_of(result).slug in GOOD_LEVELS or result.outcome in OBVIOUS_FAILURES:
        return False
    return result.samples > 0 and result.finite and not result.warnings
